/* Steps of co-simulation: see steps.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/steps.h"

#include "fmu/solve.h"

#include <math.h>

/* Restarts in one communication step. */
enum { MOST_CHANGES = 1000 };

/* ---- by the error ---- */

/* A new driver from the state in y and yp, completed for the inputs as they are: one that has run
 * before remembers how. */
static mbsri_result begin_anew(mbsri_instance *in)
{
    int status = MBSR_OK;
    if (in->inputs_changed)
        status = mbsr_completion_solve(in->solver.completion, in->solver.data, MBSR_DAE_MOMENTUM,
                                       in->t, in->y, in->yp);
    if (!status) return mbsri_make_solver(in);
    return mbsri_failed(in, "no state for the inputs", status,
                        mbsr_completion_error(in->solver.completion));
}

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

/* Tells the importer of a step that has ended at t; false: it wants control back there. *t_end
 * becomes the time at which it wants it later on. */
static bool update(mbsri_instance *in, double t, double *t_end)
{
    bool early = false;
    double wanted = t;
    in->t = t;
    in->evaluated = false;
    in->importer.intermediate(in, t, &early, &wanted);
    if (early && wanted > t) *t_end = fmin(wanted, *t_end);
    return in->mode != MBSRI_TERMINATED && !(early && wanted <= t);
}

/* After a pause of the driver. */
static int resume_driver(mbsri_instance *in, double *t_end, bool *done)
{
    double t;
    int status = mbsr_ida_state(in->solver.ida, &t, NULL, NULL);
    in->inputs_changed = false;
    if (status || t >= *t_end) return status;
    *done = !update(in, t, t_end);
    return in->inputs_changed ? mbsr_ida_jump(in->solver.ida) : MBSR_OK;
}

static mbsri_result drive(mbsri_instance *in, double t_end, bool *event)
{
    if (in->fresh && begin_anew(in)) return MBSRI_ERROR;
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

/* ---- fixed ones ---- */

static mbsri_result refuse_step(mbsri_instance *in, double t, int status)
{
    const mbsr_error error = *mbsr_stepper_error(in->solver.stepper);
    if (mbsr_stepper_resume(in->solver.stepper, t, in->y, in->yp) || status < 0)
        return mbsri_failed(in, "the step", status, &error);
    in->t = t;
    return mbsri_say(in, MBSRI_DISCARD, "the step from t = %.9g is refused: %s", t, error.text);
}

static mbsri_result march(mbsri_instance *in, double t_end)
{
    const double t = in->t, h = t_end - t, count = fmax(1.0, ceil(h / in->plan.fixed_step - 1e-9));
    int status = in->fresh ? mbsr_stepper_resume(in->solver.stepper, t, in->y, in->yp)
                           : mbsr_stepper_state(in->solver.stepper, NULL, in->y, in->yp);
    in->fresh = false;
    if (status) return mbsri_failed(in, "the step", status, mbsr_stepper_error(in->solver.stepper));
    for (double k = 1.0; k <= count && in->t < t_end; k += 1.0) {
        const double to = k < count ? t + h * (k / count) : t_end;
        status = mbsr_stepper_to(in->solver.stepper, fmin(to, t_end));
        if (status) return refuse_step(in, t, status);
        in->t = fmin(to, t_end);
        if (in->importer.intermediate && in->t < t_end && !update(in, in->t, &t_end)) break;
    }
    return MBSRI_OK;
}

mbsri_result mbsri_step(mbsri_instance *in, double t_end, bool *event)
{
    *event = false;
    const mbsri_result result = in->solver.stepper ? march(in, t_end) : drive(in, t_end, event);
    in->evaluated = false;
    in->inputs_changed = false;
    return in->mode == MBSRI_TERMINATED ? MBSRI_ERROR : result; /* by a call within the step */
}
