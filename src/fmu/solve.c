/* The model of an instance, its start and its evaluation: see solve.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/solve.h"

#include "fmu/driver.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the model ---- */

/* That of the plan at first, then one in which changed parameters are as they are set. */
static int renew_model(mbsri_instance *in, mbsr_error *error)
{
    if (!in->built.list) return mbsri_build(&in->plan, in->input, in->t_motion, &in->built, error);
    mbsr_model *made;
    int changed = 0;
    for (int k = 0; k < in->variables.parameters; ++k) {
        const double start = in->variables.list[k + 1].start, value = in->parameters.value[k];
        if (!(value < start || value > start)) continue;
        in->parameters.which[changed] = k;
        in->parameters.changed[changed++] = value;
    }
    const int status = mbsr_parameters_model(in->built.list, changed, in->parameters.which,
                                             in->parameters.changed, &made, error);
    if (status) return status;
    mbsr_model_destroy(in->built.model);
    in->built.model = made;
    return MBSR_OK;
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
    const int status = renew_model(in, &error);
    if (status) return mbsri_failed(in, "the model cannot be built", status, &error);
    const mbsri_result result = take_data(in);
    if (result)
        mbsri_drop_model(in);
    else
        in->parameters.stale = false;
    return result;
}

static void drop_solver(mbsri_instance *in)
{
    mbsri_drop_driver(in);
    mbsr_stepper_destroy(in->solver.stepper);
    mbsr_ode_destroy(in->solver.ode);
    in->solver.stepper = NULL;
    in->solver.ode = NULL;
}

void mbsri_drop_model(mbsri_instance *in)
{
    drop_solver(in);
    mbsr_newton_destroy(in->solver.newton);
    mbsr_derivatives_destroy(in->solver.forward);
    in->solver.newton = NULL;
    in->solver.forward = NULL;
    mbsr_completion_destroy(in->solver.completion);
    mbsr_data_destroy(in->solver.data);
    mbsr_data_destroy(in->solver.event_data);
    in->solver.completion = NULL;
    in->solver.data = in->solver.event_data = NULL;
    free(in->q);
    in->q = NULL;
    in->started = in->evaluated = false;
}

/* ---- start ---- */

mbsri_result mbsri_find_start(mbsri_instance *in)
{
    if (in->parameters.stale || !in->q) {
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

mbsri_result mbsri_make_stepper(mbsri_instance *in, const mbsr_stepper_opt *opt)
{
    mbsr_error error = {.text = ""};
    int status =
        mbsr_stepper_create(in->built.model, in->solver.data, opt, &in->solver.stepper, &error);
    if (!status) {
        status = mbsr_stepper_resume(in->solver.stepper, in->t, in->y, in->yp);
        error = *mbsr_stepper_error(in->solver.stepper);
    }
    return status ? mbsri_failed(in, "the stepper does not start", status, &error) : MBSRI_OK;
}

static mbsri_result make_fixed(mbsri_instance *in)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.h = in->plan.steps.fixed_step;
    opt.order = in->plan.steps.order;
    return mbsri_make_stepper(in, &opt);
}

mbsri_result mbsri_make_solver(mbsri_instance *in)
{
    drop_solver(in);
    in->inputs_changed = in->fresh = false;
    if (!in->exchange)
        return in->plan.steps.fixed_step > 0.0 ? make_fixed(in) : mbsri_make_driver(in);
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
    const mbsr_error *error = NULL;
    if (in->evaluated) return MBSRI_OK;
    if (!in->started) {
        const mbsri_result found = mbsri_find_start(in);
        if (found) return found;
    }
    int status;
    if (in->solver.ida && !in->fresh) {
        status = mbsri_driver_motion(in, &error);
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
