/* Steps by the error: see driver.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/driver.h"

#include "fmu/indicators.h"

#include <mbsrank/driver.h>

/* Restarts in one communication step. */
enum { MOST_CHANGES = 1000 };

/* ---- making ---- */

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

mbsri_result mbsri_make_driver(mbsri_instance *in)
{
    mbsr_error error = {.text = ""};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = in->tolerance > 0.0 ? in->tolerance : in->plan.steps.rtol;
    opt.atol = in->plan.steps.atol;
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

void mbsri_drop_driver(mbsri_instance *in)
{
    mbsr_ida_destroy(in->solver.ida);
    in->solver.ida = NULL;
}

/* ---- state ---- */

int mbsri_driver_state(mbsri_instance *in, const mbsr_error **error)
{
    *error = mbsr_ida_error(in->solver.ida);
    return mbsr_ida_state(in->solver.ida, NULL, in->y, in->yp);
}

int mbsri_driver_motion(mbsri_instance *in, const mbsr_error **error)
{
    *error = mbsr_ida_error(in->solver.ida);
    return mbsr_ida_motion(in->solver.ida, in->q, in->u, in->udot, in->lambda);
}

/* ---- steps ---- */

/* Ranks of joint blocks have changed: the consistent state at the last good one, with its massless
 * directions. */
static int change_ranks(mbsri_instance *in)
{
    double t;
    mbsri_tell(in, "ranks change after t = %.9g: %s", in->t, mbsr_ida_error(in->solver.ida)->text);
    int status = mbsr_ida_state(in->solver.ida, &t, in->y, in->yp);
    if (!status)
        status = mbsr_dae_consistent(in->built.model, in->solver.data, MBSR_DAE_MOMENTUM, t, in->y,
                                     in->yp, NULL, NULL);
    if (!status) status = mbsr_ida_start(in->solver.ida, t, in->y, in->yp);
    if (!status) in->t = t;
    return status;
}

/* After a pause of the driver. */
static int resume_driver(mbsri_instance *in, double *t_end, bool *done)
{
    double t;
    int status = mbsr_ida_state(in->solver.ida, &t, NULL, NULL);
    in->inputs_changed = false;
    if (status || t >= *t_end) return status;
    *done = !mbsri_update(in, t, t_end);
    return in->inputs_changed ? mbsr_ida_jump(in->solver.ida) : MBSR_OK;
}

mbsri_result mbsri_drive(mbsri_instance *in, double t_end, bool *event)
{
    int changes = 0, status = MBSR_OK;
    const bool sampled = in->inputs_changed;
    bool done = false;
    while (!done) {
        status = sampled ? mbsr_ida_sample(in->solver.ida, t_end, NULL, NULL, NULL)
                         : mbsr_ida_advance(in->solver.ida, t_end, NULL, NULL, NULL);
        if (!status) in->t = t_end;
        *event = status == MBSR_EVENT;
        if (*event) status = mbsr_ida_state(in->solver.ida, &in->t, NULL, NULL);
        done = *event || !status;
        if (status == MBSRI_PAUSE) status = resume_driver(in, &t_end, &done);
        if (status == MBSR_RANK_CHANGED && ++changes < MOST_CHANGES) status = change_ranks(in);
        done = done || status;
    }
    return status ? mbsri_failed(in, "the step", status, mbsr_ida_error(in->solver.ida)) : MBSRI_OK;
}
