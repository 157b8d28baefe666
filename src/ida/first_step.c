/* The first step, and when two times are the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/first_step.h"

#include "ida/loops.h"
#include "ida/tolerances.h"

#include <float.h>
#include <math.h>

/* y' for the residual of first_step: zero, but for the loop forces, which are rates. */
static N_Vector at_rest(mbsr_ida *ida, bool on)
{
    const int first = mbsri_ida_loops(ida);
    double *zero = N_VGetArrayPointer(ida->zero);
    const double *yp = N_VGetArrayPointer(ida->yp);
    for (int k = first; k < ida->size; ++k) zero[k] = on ? yp[k] : 0.0;
    return ida->zero;
}

/* With the norm of the error test, which is 1 at
 * the tolerance, and a short time s,
 *
 *   |h^2 y'' / 2| = 1/2,    y'' = (y'(t + s) - y'(t)) / s
 *
 * for q and p, whose y'(t + s) = -F of the residual there with y' = 0. IDA's own choice goes with
 * the first order, h y', and with the way to the first t_end: far smaller at tight tolerances, too
 * small for directions that only springs determine, and it would make the steps depend on where
 * output is asked for. */
double mbsri_ida_first_step(mbsr_ida *ida, double direction, double longest)
{
    if (ida->opt.initial_step > 0.0) return ida->opt.initial_step;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const int n = ida->opt.form == MBSR_DAE_MOMENTUM ? nq + nu : nq;
    const double *yp = N_VGetArrayPointer(ida->yp);
    double *moved = N_VGetArrayPointer(ida->displaced), *rate = N_VGetArrayPointer(ida->work);
    const double slope = mbsri_ida_norm(ida, mbsri_ida_loops(ida), yp);
    const double little = slope * longest > 0.5 ? 0.5 / slope : longest;
    N_VLinearSum(1.0, ida->y, direction * little, ida->yp, ida->displaced);
    ++ida->count.residuals;
    const int failed = mbsr_dae_residual(ida->model, ida->data, ida->opt.form,
                                         ida->run.present + direction * little, moved,
                                         N_VGetArrayPointer(at_rest(ida, true)), rate);
    at_rest(ida, false);
    if (failed) return little;
    for (int k = 0; k < n; ++k) rate[k] = (-rate[k] - yp[k]) / little;
    const double second = mbsri_ida_norm(ida, n, rate);
    return second * longest * longest > 1.0 ? 1.0 / sqrt(second) : longest;
}

double mbsri_ida_longest_first_step(const mbsr_ida *ida)
{
    return 1e-3 * ida->tol.time;
}

bool mbsri_ida_same_time(double a, double b)
{
    return fabs(a - b) <= 2.0 * DBL_EPSILON * (fabs(a) + fabs(b));
}
