/* Steps of co-simulation: see steps.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/steps.h"

#include "fmu/driver.h"
#include "fmu/solve.h"

#include <math.h>

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
    static const double most = 1e9;
    const double t = in->t, h = t_end - t,
                 count = fmax(1.0, ceil(h / in->plan.steps.fixed_step - 1e-9));
    if (count > most)
        return mbsri_say(in, MBSRI_DISCARD,
                         "the step of %.9g s takes %.3g steps of %.9g s, more than %.3g", h, count,
                         in->plan.steps.fixed_step, most);
    int status = in->fresh ? mbsr_stepper_resume(in->solver.stepper, t, in->y, in->yp)
                           : mbsr_stepper_state(in->solver.stepper, NULL, in->y, in->yp);
    in->fresh = false;
    if (status) return mbsri_failed(in, "the step", status, mbsr_stepper_error(in->solver.stepper));
    for (double k = 1.0; k <= count && in->t < t_end; k += 1.0) {
        const double to = k < count ? t + h * (k / count) : t_end;
        status = mbsr_stepper_to(in->solver.stepper, fmin(to, t_end));
        if (status) return refuse_step(in, t, status);
        in->t = fmin(to, t_end);
        if (in->importer.intermediate && in->t < t_end && !mbsri_update(in, in->t, &t_end)) break;
    }
    return MBSRI_OK;
}

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

static mbsri_result drive(mbsri_instance *in, double t_end, bool *event)
{
    if (in->fresh && begin_anew(in)) return MBSRI_ERROR;
    return mbsri_drive(in, t_end, event);
}

mbsri_result mbsri_step(mbsri_instance *in, double t_end, bool *event)
{
    *event = false;
    mbsri_result result;
    if (!in->solver.stepper)
        result = drive(in, t_end, event);
    else if (in->plan.steps.fixed_step > 0.0)
        result = march(in, t_end);
    else
        result = mbsri_drive(in, t_end, event);
    in->evaluated = false;
    in->inputs_changed = false;
    return in->mode == MBSRI_TERMINATED ? MBSRI_ERROR : result; /* by a call within the step */
}
