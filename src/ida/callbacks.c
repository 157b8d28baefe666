/* The residual and the event functions as IDA calls them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each evaluation leaves its status in `callback`. When IDA gives up because of an evaluation, that
 * one was the last: a failed residual ends the attempt at a step, a failed event function ends the
 * integration. */
#include "driver.h"

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

double mbsri_ida_tolerance(const mbsr_ida *ida, const double *y, int k)
{
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const bool momentum =
        ida->scales && ida->opt.form == MBSR_DAE_MOMENTUM && k >= nq && k < nq + nu;
    const double atol = N_VGetArrayPointer(ida->atol)[k];
    if (!momentum) return ida->opt.rtol * fabs(y[k]) + atol;
    return ida->opt.rtol * N_VGetArrayPointer(ida->mass)[k] * fabs(y[k + nu]) + atol;
}

int mbsri_ida_weights(N_Vector y, N_Vector weight, void *user)
{
    mbsr_ida *ida = user;
    for (int k = 0; k < ida->size; ++k) {
        const double tolerance = mbsri_ida_tolerance(ida, N_VGetArrayPointer(y), k);
        if (!(tolerance > 0.0)) {
            ida->callback = MBSR_ERR_VALUE;
            return mbsri_ida_fail(&ida->failure, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                                  "y[%d] is %g: its tolerance, relative and absolute, is zero", k,
                                  N_VGetArrayPointer(y)[k]);
        }
        N_VGetArrayPointer(weight)[k] = 1.0 / tolerance;
    }
    return 0;
}

int mbsri_ida_residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    mbsr_ida *ida = user;
    ++ida->residuals;
    const int status =
        mbsr_dae_residual(ida->model, ida->data, ida->opt.form, t, N_VGetArrayPointer(y),
                          N_VGetArrayPointer(yp), N_VGetArrayPointer(F));
    ida->callback = status;
    if (status) {
        const mbsr_error *error = mbsr_data_error(ida->data);
        mbsri_ida_fail(&ida->failure, status, error->body, error->force,
                       "residual at t = %.10g: %s", t, error->text);
    }
    return status > 0 && blocked(ida, t) ? -1 : status;
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
