/* From mode to mode: see cycle.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/cycle.h"

#include "fmu/solve.h"
#include "fmu/steps.h"

#include <math.h>

mbsri_result mbsri_set_up(mbsri_instance *in, const char *function, double tolerance, double start)
{
    if (!isfinite(start))
        return mbsri_say(in, MBSRI_ERROR, "%s: the start time is %g", function, start);
    if (!(tolerance >= 0.0 && tolerance < 1.0))
        return mbsri_say(in, MBSRI_ERROR, "%s: the tolerance is %g, must lie between 0 and 1",
                         function, tolerance);
    in->t = in->start.t = start;
    in->tolerance = tolerance;
    return MBSRI_OK;
}

mbsri_result mbsri_initialize(mbsri_instance *in)
{
    in->started = in->evaluated = false;
    in->mode = MBSRI_INITIALIZATION;
    return MBSRI_OK;
}

mbsri_result mbsri_initialized(mbsri_instance *in, const char *function, mbsri_unit_mode next)
{
    mbsri_result result = in->started && !in->parameters.stale ? MBSRI_OK : mbsri_find_start(in);
    if (!result) result = mbsri_make_solver(in);
    if (result) return result;
    mbsri_tell(in, "%s: starts at t = %.9g", function, in->t);
    in->mode = next;
    return MBSRI_OK;
}

mbsri_result mbsri_communicate(mbsri_instance *in, const char *function, double t, double h,
                               bool *event)
{
    *event = false;
    if (!isfinite(t) || fabs(t - in->t) > 1e-9 * (1.0 + fabs(in->t)))
        return mbsri_say(in, MBSRI_ERROR,
                         "%s: the communication point is %.17g, the instance is at %.17g", function,
                         t, in->t);
    if (!isfinite(h) || !(t + h > in->t))
        return mbsri_say(in, MBSRI_ERROR, "%s: the step is %g, must be positive", function, h);
    const mbsri_result result = mbsri_step(in, t + h, event);
    if (*event) mbsri_tell(in, "%s: a stop or a contact is hit at t = %.9g", function, in->t);
    return result;
}
