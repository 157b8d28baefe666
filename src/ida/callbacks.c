/* The residual and the event functions as IDA calls them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each evaluation leaves its status in `callback`. When IDA gives up because of an evaluation, that
 * one was the last: a failed residual ends the attempt at a step, a failed event function ends the
 * integration. */
#include "ida/callbacks.h"

#include "ida/shift.h"
#include "ida/error.h"
#include "ida/record.h"

#include <mbsrank/driver.h>

#include <float.h>
#include <math.h>

/* Where the residual fails from some state on, IDA creeps up to it: after each failure it takes
 * smaller steps, which succeed until the next one, and never gives up. This tells after so many
 * failures at the same time that no step leads on. */
static bool blocked(mbsr_ida *ida, double t)
{
    enum { FAILURES = 100 };
    const double rounding = 100.0 * DBL_EPSILON * fabs(t);
    ida->failing.blocked = fabs(t - ida->failing.wall) <= rounding ? ida->failing.blocked + 1 : 0;
    ida->failing.wall = t;
    return ida->failing.blocked >= FAILURES;
}

int mbsri_ida_failed(mbsr_ida *ida, double t, int status, const mbsr_error *error, const char *what)
{
    ida->failing.callback = status;
    mbsri_ida_pass_on(&ida->failing.failure, status, error, "%s at t = %.10g", what, t);
    return status > 0 && blocked(ida, t) ? -1 : status;
}

int mbsri_ida_residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    mbsr_ida *ida = user;
    ++ida->count.residuals;
    mbsri_ida_shift_back(ida, t, &y, &yp);
    const int status =
        mbsr_dae_residual(ida->model, ida->data, ida->opt.form, t, N_VGetArrayPointer(y),
                          N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
    ida->failing.callback = status;
    return status ? mbsri_ida_failed(ida, t, status, mbsr_data_error(ida->data), "residual")
                  : MBSR_OK;
}

/* The last event function: the reference has to be renewed where it falls through zero. */
static int turned(mbsr_ida *ida, sunrealtype t, const double *y, sunrealtype *value)
{
    double cosine = 1.0;
    ida->failing.callback = mbsr_index1_alignment(ida->model, ida->data, t, y, &cosine);
    value[ida->opt.events] = cosine - MBSRI_IDA_TURNED;
    if (!ida->failing.callback) return MBSR_OK;
    return mbsri_ida_pass_on(&ida->failing.failure, ida->failing.callback,
                             mbsr_data_error(ida->data), "alignment at t = %.10g", t);
}

int mbsri_ida_events(sunrealtype t, N_Vector y, N_Vector yp, sunrealtype *value, void *user)
{
    mbsr_ida *ida = user;
    ++ida->count.events;
    mbsri_ida_shift_back(ida, t, &y, &yp);
    const int status = ida->turns ? turned(ida, t, N_VGetArrayPointer(y), value) : MBSR_OK;
    if (status || ida->opt.events == 0) return status;
    for (int k = 0; k < ida->opt.events; ++k) value[k] = 0.0;
    ida->failing.callback = ida->opt.event(ida->opt.event_user, t, N_VGetArrayPointer(y),
                                           N_VGetArrayPointer(yp), value);
    if (ida->failing.callback)
        return mbsri_ida_refuse(&ida->failing.failure, ida->failing.callback,
                                "event function at t = %.10g returned %d", t,
                                ida->failing.callback);
    for (int k = 0; k < ida->opt.events; ++k) {
        if (isfinite(value[k])) continue;
        ida->failing.callback = MBSR_NOT_FINITE;
        return mbsri_ida_refuse(&ida->failing.failure, MBSR_NOT_FINITE,
                                "event function %d at t = %.10g is %g", k, t, value[k]);
    }
    return MBSR_OK;
}
