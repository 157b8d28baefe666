/* The residual and the event functions as IDA calls them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each evaluation leaves its status in `callback`. When IDA gives up because of an evaluation, that
 * one was the last: a failed residual ends the attempt at a step, a failed event function ends the
 * integration. */
#include "ida/callbacks.h"

#include "ida/bend.h"
#include "ida/error.h"
#include "ida/record.h"

#include <float.h>
#include <math.h>

/* Where the residual fails from some state on, IDA creeps up to it: after each failure it takes
 * smaller steps, which succeed until the next one, and never gives up. This tells after so many
 * failures at the same time that no step leads on. */
static bool blocked(mbsr_ida *ida, double t)
{
    enum { FAILURES = 100 };
    const double rounding = 100.0 * DBL_EPSILON * fabs(t);
    ida->blocked = fabs(t - ida->wall) <= rounding ? ida->blocked + 1 : 0;
    ida->wall = t;
    return ida->blocked >= FAILURES;
}

int mbsri_ida_failed(mbsr_ida *ida, double t, int status, const mbsr_error *error, const char *what)
{
    ida->callback = status;
    mbsri_ida_fail(&ida->failure, status, error->body, error->force, "%s at t = %.10g: %s", what, t,
                   error->text);
    return status > 0 && blocked(ida, t) ? -1 : status;
}

int mbsri_ida_residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    mbsr_ida *ida = user;
    ++ida->residuals;
    mbsri_ida_unbend(ida, t, &y, &yp);
    const int status =
        mbsr_dae_residual(ida->model, ida->data, ida->opt.form, t, N_VGetArrayPointer(y),
                          N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
    ida->callback = status;
    return status ? mbsri_ida_failed(ida, t, status, mbsr_data_error(ida->data), "residual")
                  : MBSR_OK;
}

/* The last event function: the reference has to be renewed where it falls through zero. */
static int turned(mbsr_ida *ida, sunrealtype t, const double *y, sunrealtype *value)
{
    double cosine = 1.0;
    ida->callback = mbsr_index1_alignment(ida->model, ida->data, t, y, &cosine);
    value[ida->opt.events] = cosine - MBSRI_IDA_TURNED;
    if (!ida->callback) return MBSR_OK;
    const mbsr_error *error = mbsr_data_error(ida->data);
    return mbsri_ida_fail(&ida->failure, ida->callback, error->body, error->force,
                          "alignment at t = %.10g: %s", t, error->text);
}

int mbsri_ida_events(sunrealtype t, N_Vector y, N_Vector yp, sunrealtype *value, void *user)
{
    mbsr_ida *ida = user;
    ++ida->events;
    mbsri_ida_unbend(ida, t, &y, &yp);
    const int status = ida->turns ? turned(ida, t, N_VGetArrayPointer(y), value) : MBSR_OK;
    if (status || ida->opt.events == 0) return status;
    for (int k = 0; k < ida->opt.events; ++k) value[k] = 0.0;
    ida->callback = ida->opt.event(ida->opt.event_user, t, N_VGetArrayPointer(y),
                                   N_VGetArrayPointer(yp), value);
    if (ida->callback) {
        return mbsri_ida_fail(&ida->failure, ida->callback, MBSR_NONE, MBSR_NONE,
                              "event function at t = %.10g returned %d", t, ida->callback);
    }
    for (int k = 0; k < ida->opt.events; ++k) {
        if (isfinite(value[k])) continue;
        ida->callback = MBSR_NOT_FINITE;
        return mbsri_ida_fail(&ida->failure, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                              "event function %d at t = %.10g is %g", k, t, value[k]);
    }
    return MBSR_OK;
}
