/* Model exchange: see exchange.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/exchange.h"

#include "fmu/indicators.h"
#include "fmu/solve.h"

#include <math.h>
#include <string.h>

static size_t states_of(const mbsri_instance *in)
{
    return in->exchange ? (size_t)(in->plan.nq + in->plan.nu) : 0;
}

/* Whether there is room for as many numbers as there are. */
static bool fits(mbsri_instance *in, const char *function, const void *to, size_t count,
                 size_t right)
{
    if (count == right && (to || count == 0)) return true;
    if (count != right)
        mbsri_say(in, MBSRI_ERROR, "%s: %zu numbers where there are %zu", function, count, right);
    else
        mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    return false;
}

/* The ODE of the state; in initialization mode, before there is one, that of the start. */
static mbsri_result have_ode(mbsri_instance *in)
{
    if (in->solver.ode && in->started) return MBSRI_OK;
    const mbsri_result result = in->started ? MBSRI_OK : mbsri_find_start(in);
    return result ? result : mbsri_make_solver(in);
}

/* x'; where the number of massless directions has changed, by the equations of the new ones. */
static int find_derivatives(mbsri_instance *in, double *xdot)
{
    int status = mbsr_ode_rhs(in->solver.ode, in->t, in->x, xdot);
    if (status != MBSR_RANK_CHANGED) return status;
    mbsri_tell(in, "ranks change at t = %.9g: %s", in->t, mbsr_data_error(in->solver.data)->text);
    mbsr_ode *made;
    memcpy(in->q, in->x, (size_t)in->plan.nq * sizeof *in->q);
    status = mbsr_ode_create(in->built.model, in->solver.data, in->t, in->q, in->u, &made);
    if (status) return status;
    mbsr_ode_destroy(in->solver.ode);
    in->solver.ode = made;
    return mbsr_ode_rhs(in->solver.ode, in->t, in->x, xdot);
}

mbsri_result mbsri_get_states(mbsri_instance *in, const char *function, double *x, size_t count)
{
    if (!fits(in, function, x, count, states_of(in))) return MBSRI_ERROR;
    const mbsri_result result = have_ode(in);
    if (!result) memcpy(x, in->x, count * sizeof *x);
    return result;
}

mbsri_result mbsri_set_states(mbsri_instance *in, const char *function, const double *x,
                              size_t count)
{
    if (!fits(in, function, x, count, states_of(in))) return MBSRI_ERROR;
    for (size_t k = 0; k < count; ++k)
        if (!isfinite(x[k]))
            return mbsri_say(in, MBSRI_ERROR, "%s: state %zu is %g", function, k, x[k]);
    const mbsri_result result = have_ode(in);
    if (!result) memcpy(in->x, x, count * sizeof *x);
    in->evaluated = false;
    return result;
}

mbsri_result mbsri_get_derivatives(mbsri_instance *in, const char *function, double *xdot,
                                   size_t count)
{
    if (!fits(in, function, xdot, count, states_of(in))) return MBSRI_ERROR;
    const mbsri_result result = have_ode(in);
    if (result) return result;
    in->evaluated = false;
    const int status = find_derivatives(in, xdot);
    if (status > 0)
        return mbsri_say(in, MBSRI_DISCARD, "%s at t = %.9g: %s", function, in->t,
                         mbsr_data_error(in->solver.data)->text);
    return status ? mbsri_failed(in, function, status, mbsr_data_error(in->solver.data)) : MBSRI_OK;
}

mbsri_result mbsri_get_nominals(mbsri_instance *in, const char *function, double *x, size_t count)
{
    if (!fits(in, function, x, count, states_of(in))) return MBSRI_ERROR;
    for (size_t k = 0; k < count; ++k) x[k] = 1.0;
    return MBSRI_OK;
}

mbsri_result mbsri_get_indicators(mbsri_instance *in, const char *function, double *value,
                                  size_t count)
{
    if (!fits(in, function, value, count, (size_t)in->variables.indicators)) return MBSRI_ERROR;
    if (count == 0) return MBSRI_OK;
    const mbsri_result result = mbsri_evaluate(in);
    if (result) return result;
    const int status = mbsri_indicate(in, in->solver.event_data, in->t, in->q, in->u, value);
    return status ? mbsri_failed(in, function, status, mbsr_data_error(in->solver.event_data))
                  : MBSRI_OK;
}

mbsri_result mbsri_set_time(mbsri_instance *in, const char *function, double t)
{
    if (!isfinite(t)) return mbsri_say(in, MBSRI_ERROR, "%s: the time is %g", function, t);
    in->t = t;
    in->evaluated = false;
    return MBSRI_OK;
}

bool mbsri_next_event(const mbsri_instance *in, double *t)
{
    mbsr_kink next = {.t = INFINITY};
    if (mbsr_model_kink(in->built.model, in->t, 1, &next)) return false;
    *t = next.t;
    return isfinite(next.t);
}

/* Of co-simulation from F(t, y, 0) of the momentum form, which is -q', -p', ... */
int mbsri_state_value(mbsri_instance *in, const mbsri_variable *v, double *value)
{
    if (in->solver.ode) { /* with quaternions of any length, as x has them */
        const int at = (v->kind == MBSRI_QDOT ? 0 : in->plan.nq) + v->of;
        const int found = v->kind == MBSRI_P ? MBSR_OK : find_derivatives(in, in->work);
        in->evaluated = false;
        *value = v->kind == MBSRI_P ? in->x[at] : in->work[at];
        return found;
    }
    const mbsr_model *m = in->built.model;
    double *y = in->work, *zero = y + in->size, *F = zero + in->size;
    int status = mbsr_dae_pack(m, in->solver.data, MBSR_DAE_MOMENTUM, in->t, in->q, in->u, y);
    in->evaluated = false;
    if (!status && v->kind == MBSRI_P) {
        *value = y[in->plan.nq + v->of];
        return MBSR_OK;
    }
    memset(zero, 0, (size_t)in->size * sizeof *zero);
    if (!status)
        status = mbsr_dae_residual(m, in->solver.data, MBSR_DAE_MOMENTUM, in->t, y, zero, F);
    *value = -F[(v->kind == MBSRI_QDOT ? 0 : in->plan.nq) + v->of];
    return status;
}
