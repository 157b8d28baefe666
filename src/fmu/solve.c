/* The model of an instance, its start and its evaluation: see solve.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/solve.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

mbsri_result mbsri_failed(mbsri_instance *in, const char *what, int status, const mbsr_error *of)
{
    return mbsri_say(in, MBSRI_ERROR, "%s at t = %.9g: %s (%s)", what, in->t,
                     of && of->text[0] ? of->text : mbsr_status_text(status),
                     mbsr_status_name(status));
}

/* ---- the model ---- */

/* Inertias whose tensors were changed have no digits beyond those given. */
static void settle_tensors(mbsri_instance *in)
{
    for (int k = 1; k <= in->variables.parameters && in->variables.list; ++k) {
        const mbsri_variable *v = in->variables.list + k;
        if (v->of > 0 && (*v->place < v->start || *v->place > v->start))
            in->plan.body[v->of - 1].def.inertia.exact = 0;
    }
}

static bool take_state(mbsri_instance *in)
{
    const mbsr_model *m = in->built.model;
    in->size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    in->rows = mbsr_model_rows(m);
    const size_t nq = (size_t)in->plan.nq, nu = (size_t)in->plan.nu, size = (size_t)in->size;
    const size_t indicators = 2 * (size_t)in->plan.forces;
    in->q = calloc(2 * nq + 3 * nu + (size_t)in->rows + 5 * size + indicators + 1, sizeof *in->q);
    if (!in->q) return false;
    in->u = in->q + nq;
    in->udot = in->u + nu;
    in->lambda = in->udot + nu;
    in->x = in->lambda + in->rows;
    in->y = in->x + nq + nu;
    in->yp = in->y + size;
    in->work = in->yp + size;
    return true;
}

/* The data of a model, and room for its states. */
static mbsri_result take_data(mbsri_instance *in)
{
    mbsr_error error = {.text = ""};
    int status = mbsr_data_create(in->built.model, &in->solver.data, &error);
    if (!status) status = mbsr_data_create(in->built.model, &in->solver.event_data, &error);
    if (!status)
        status = mbsr_completion_create(in->built.model, NULL, &in->solver.completion, &error);
    if (status) return mbsri_failed(in, "no data for the model", status, &error);
    if (!take_state(in)) return mbsri_failed(in, "the model", MBSR_ERR_NO_MEMORY, NULL);
    return MBSRI_OK;
}

mbsri_result mbsri_make_model(mbsri_instance *in)
{
    mbsr_error error = {.text = ""};
    mbsri_drop_model(in);
    settle_tensors(in);
    const int status = mbsri_build(&in->plan, in->input, in->t_motion, &in->built, &error);
    if (status) return mbsri_failed(in, "the model cannot be built", status, &error);
    const mbsri_result result = take_data(in);
    if (result)
        mbsri_drop_model(in);
    else
        in->stale = false;
    return result;
}

static void drop_solver(mbsri_instance *in)
{
    mbsr_ida_destroy(in->solver.ida);
    mbsr_stepper_destroy(in->solver.stepper);
    mbsr_ode_destroy(in->solver.ode);
    in->solver.ida = NULL;
    in->solver.stepper = NULL;
    in->solver.ode = NULL;
}

void mbsri_drop_model(mbsri_instance *in)
{
    drop_solver(in);
    mbsr_completion_destroy(in->solver.completion);
    mbsr_data_destroy(in->solver.data);
    mbsr_data_destroy(in->solver.event_data);
    in->solver.completion = NULL;
    in->solver.data = in->solver.event_data = NULL;
    free(in->q);
    in->q = NULL;
    mbsri_built_destroy(&in->built);
    in->started = in->evaluated = false;
}

/* ---- start ---- */

mbsri_result mbsri_find_start(mbsri_instance *in)
{
    if (in->stale || !in->built.model) {
        const mbsri_result made = mbsri_make_model(in);
        if (made) return made;
    }
    const mbsr_model *m = in->built.model;
    drop_solver(in);
    in->t = in->start.t;
    for (int k = 0; k < in->plan.motions; ++k) in->t_motion[k] = in->t;
    in->evaluated = false;
    int status = mbsr_dae_pack(m, in->solver.data, MBSR_DAE_MOMENTUM, in->start.t, in->start.q,
                               in->start.u, in->y);
    if (!status)
        status = mbsr_dae_consistent(m, in->solver.data, MBSR_DAE_MOMENTUM, in->start.t, in->y,
                                     in->yp, NULL, NULL);
    if (!status)
        status = mbsr_dae_unpack(m, in->solver.data, MBSR_DAE_MOMENTUM, in->start.t, in->y, in->q,
                                 in->u);
    if (status) return mbsri_failed(in, "no start", status, mbsr_data_error(in->solver.data));
    in->started = true;
    return MBSRI_OK;
}

/* ---- solvers ---- */

static int events_of_driver(void *user, double t, const double *y, const double *yp, double *value)
{
    mbsri_instance *in = user;
    const mbsr_model *m = in->built.model;
    double *u = in->work + in->plan.nq; /* together fewer than y */
    (void)yp;
    const int status =
        mbsr_dae_unpack(m, in->solver.event_data, MBSR_DAE_MOMENTUM, t, y, in->work, u);
    return status ? status : mbsri_indicate(in, in->solver.event_data, t, in->work, u, value);
}

/* With intermediate updates the driver pauses after each of its steps. */
static int pause_driver(void *user, const mbsr_ida_progress *now)
{
    (void)user;
    (void)now;
    return MBSRI_PAUSE;
}

static mbsri_result make_driver(mbsri_instance *in)
{
    mbsr_error error = {.text = ""};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = in->tolerance > 0.0 ? in->tolerance : in->plan.rtol;
    opt.atol = in->plan.atol;
    if (in->importer.event_mode && in->importer.early_return && in->variables.indicators > 0) {
        opt.events = in->variables.indicators;
        opt.event = events_of_driver;
        opt.event_user = in;
    }
    if (in->importer.intermediate) opt.progress = pause_driver;
    int status = mbsr_ida_create(in->built.model, in->solver.data, &opt, &in->solver.ida, &error);
    if (!status) {
        status = mbsr_ida_start(in->solver.ida, in->t, in->y, in->yp);
        error = *mbsr_ida_error(in->solver.ida);
    }
    return status ? mbsri_failed(in, "the driver does not start", status, &error) : MBSRI_OK;
}

static mbsri_result make_stepper(mbsri_instance *in)
{
    mbsr_error error = {.text = ""};
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.h = in->plan.fixed_step;
    opt.order = in->plan.order;
    int status =
        mbsr_stepper_create(in->built.model, in->solver.data, &opt, &in->solver.stepper, &error);
    if (!status) {
        status = mbsr_stepper_resume(in->solver.stepper, in->t, in->y, in->yp);
        error = *mbsr_stepper_error(in->solver.stepper);
    }
    return status ? mbsri_failed(in, "the stepper does not start", status, &error) : MBSRI_OK;
}

mbsri_result mbsri_make_solver(mbsri_instance *in)
{
    drop_solver(in);
    in->inputs_changed = in->fresh = false;
    if (!in->exchange) return in->plan.fixed_step > 0.0 ? make_stepper(in) : make_driver(in);
    int status =
        mbsr_ode_create(in->built.model, in->solver.data, in->t, in->q, in->u, &in->solver.ode);
    if (!status) status = mbsr_ode_pack(in->solver.ode, in->t, in->q, in->u, in->x);
    return status ? mbsri_failed(in, "no derivatives", status, mbsr_data_error(in->solver.data))
                  : MBSRI_OK;
}

/* ---- evaluation ---- */

/* The state of what steps, or that of x. */
static int find_stepped_state(mbsri_instance *in, const mbsr_error **error)
{
    *error = mbsr_data_error(in->solver.data);
    if (in->solver.ode) {
        memcpy(in->q, in->x, (size_t)in->plan.nq * sizeof *in->q);
        return mbsr_ode_velocities(in->solver.ode, in->t, in->x, in->u);
    }
    if (in->solver.stepper && !in->fresh) {
        *error = mbsr_stepper_error(in->solver.stepper);
        return mbsr_stepper_motion(in->solver.stepper, NULL, in->q, in->u);
    }
    if (in->fresh)
        return mbsr_dae_unpack(in->built.model, in->solver.data, MBSR_DAE_MOMENTUM, in->t, in->y,
                               in->q, in->u);
    return MBSR_OK;
}

static int find_accelerations(mbsri_instance *in)
{
    const mbsr_model *m = in->built.model;
    int status = mbsr_stage_positions(m, in->solver.data, in->t, in->q);
    if (!status) status = mbsr_stage_velocities(m, in->solver.data, in->u);
    if (!status && in->rows > 0) status = mbsr_closures_set_lambda(m, in->solver.data, in->lambda);
    if (!status) status = mbsr_stage_forces(m, in->solver.data, NULL);
    return status ? status : mbsr_stage_accelerations(m, in->solver.data, in->udot);
}

mbsri_result mbsri_evaluate(mbsri_instance *in)
{
    const mbsr_error *error;
    if (in->evaluated) return MBSRI_OK;
    if (!in->started) {
        const mbsri_result found = mbsri_find_start(in);
        if (found) return found;
    }
    int status;
    if (in->solver.ida && !in->fresh) {
        error = mbsr_ida_error(in->solver.ida);
        status = mbsr_ida_motion(in->solver.ida, in->q, in->u, in->udot, in->lambda);
        if (status || !in->inputs_changed) {
            in->evaluated = !status;
            return status ? mbsri_failed(in, "no state", status, error) : MBSRI_OK;
        }
    }
    status = find_stepped_state(in, &error);
    if (status) return mbsri_failed(in, "no state", status, error);
    status = mbsr_completion_dynamics(in->solver.completion, in->solver.data, in->t, in->q, in->u,
                                      NULL, in->udot, in->lambda);
    if (status)
        return mbsri_failed(in, "no accelerations", status,
                            mbsr_completion_error(in->solver.completion));
    status = find_accelerations(in);
    if (status)
        return mbsri_failed(in, "no accelerations", status, mbsr_data_error(in->solver.data));
    in->evaluated = true;
    return MBSRI_OK;
}

/* ---- events ---- */

/* Where the coordinate of a stop stands in q; -1: it is locked. */
static int index_of_stop(const mbsri_instance *in, const mbsr_force_def *stop)
{
    const double *held = in->plan.body[stop->body[0]].held;
    int at, left = 0;
    mbsr_body_coordinates(in->built.model, stop->body[0], &at, NULL, NULL, NULL);
    if (held && !isnan(held[stop->option[0]])) return -1;
    for (int k = 0; k < stop->option[0]; ++k) left += !held || isnan(held[k]);
    return at + left;
}

static double distance_to_stop(const mbsri_instance *in, const mbsri_variable *v, const double *q)
{
    const mbsr_force_def *stop = &in->plan.force[v->of].def;
    const int at = index_of_stop(in, stop);
    if (at < 0) return 1.0;
    return v->component == 0 ? q[at] - stop->param[0] : stop->param[1] - q[at];
}

int mbsri_indicate(mbsri_instance *in, mbsr_data *data, double t, const double *q, const double *u,
                   double *value)
{
    const mbsr_model *m = in->built.model;
    bool placed = false;
    for (int k = 0; k < in->variables.indicators; ++k) {
        const mbsri_variable *v = in->variables.list + in->variables.indicators_at + k;
        if (in->plan.force[v->of].def.table->flags & MBSR_FORCE_JOINT_ONLY) {
            value[k] = distance_to_stop(in, v, q);
            continue;
        }
        mbsr_contact_state contact;
        int status = placed ? MBSR_OK : mbsr_stage_positions(m, data, t, q);
        if (!status && !placed) status = mbsr_stage_velocities(m, data, u);
        if (!status) status = mbsr_contact_at(m, data, v->of, &contact);
        if (status) return status;
        placed = true;
        value[k] = -contact.depth;
    }
    return MBSR_OK;
}
