/* A dense matrix whose columns of coordinates are right where something is stiff.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA's difference quotients are one-sided. Of a stiff element they take the force that its
 * direction turns into along the step, of the second order in the step times the stiffness, for a
 * slope across that direction, where only inertia stands against it: with k = 1e12 N/m and steps of
 * 1e-8 rad the error is 1e4 N/m and Newton's method fails. Central differences, with steps near the
 * third root of the rounding error, have none of the second order, for twice the price. Only the
 * coordinates turn a direction: other columns have one side as before.
 *
 * On a stop that is strained by less than such a step the slope has two values, and differences
 * have neither. So in the momentum form of trees these columns are products with the matrix of
 * mbsr_newton, which has the slopes of elements; differences serve the other forms. */
#include "ida/differences.h"

#include "ida/callbacks.h"
#include "ida/tolerances.h"

#include <ida/ida_ls.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

/* F at y + sign step e_k, y' + sign c step e_k */
static int shifted(mbsr_ida *ida, double t, N_Vector y, N_Vector yp, int k, double step, double c,
                   N_Vector F)
{
    double *value = N_VGetArrayPointer(y) + k, *rate = N_VGetArrayPointer(yp) + k;
    const double y_k = *value, yp_k = *rate;
    *value = y_k + step;
    *rate = yp_k + c * step;
    ++ida->count.central_residuals;
    const int status = mbsri_ida_residual(t, y, yp, F, ida);
    *value = y_k;
    *rate = yp_k;
    return status;
}

/* Column k by two sides; `minus` serves. */
static int two_sided(mbsr_ida *ida, double t, double c, N_Vector y, N_Vector yp, int k,
                     double *column, N_Vector plus, N_Vector minus)
{
    const double tolerance = mbsri_ida_tolerance(ida, N_VGetArrayPointer(y), k);
    const double step = cbrt(DBL_EPSILON) * fmax(fabs(N_VGetArrayPointer(y)[k]), tolerance);
    int status = shifted(ida, t, y, yp, k, step, c, plus);
    if (!status) status = shifted(ida, t, y, yp, k, -step, c, minus);
    if (status) return status;
    const double *a = N_VGetArrayPointer(plus), *b = N_VGetArrayPointer(minus);
    for (int row = 0; row < ida->size; ++row) column[row] = (a[row] - b[row]) / (2.0 * step);
    return MBSR_OK;
}

/* The largest of the entries first .. last - 1 of y, in tolerances. */
static double largest(const mbsr_ida *ida, const double *y, int first, int last)
{
    double most = 1.0;
    for (int k = first; k < last; ++k)
        most = fmax(most, fabs(y[k]) / mbsri_ida_tolerance(ida, y, k));
    return most;
}

/* What the momenta and the velocities, in which F is almost linear, are changed by. F has rounding
 * errors of all of them: the step of one that is zero is not much smaller than those of the others.
 */
typedef struct sizes {
    double h, momenta, velocities; /* the step of IDA; the largest, in tolerances */
} sizes;

/* Column k by one side; r is F at y, y'. */
static int one_sided(mbsr_ida *ida, double t, double c, sizes s, N_Vector y, N_Vector yp, int k,
                     double *column, N_Vector r, N_Vector plus)
{
    static const double smallest = 0.1;
    const bool momentum = k < mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    const double tolerance = mbsri_ida_tolerance(ida, N_VGetArrayPointer(y), k),
                 moved = fabs(s.h * N_VGetArrayPointer(yp)[k]),
                 others = smallest * tolerance * (momentum ? s.momenta : s.velocities);
    const double size = fmax(fabs(N_VGetArrayPointer(y)[k]), fmax(moved, fmax(others, tolerance)));
    const double step = sqrt(DBL_EPSILON) * size;
    const int status = shifted(ida, t, y, yp, k, step, c, plus);
    if (status) return status;
    const double *a = N_VGetArrayPointer(plus), *b = N_VGetArrayPointer(r);
    for (int row = 0; row < ida->size; ++row) column[row] = (a[row] - b[row]) / step;
    return MBSR_OK;
}

/* The columns of the coordinates from derivatives; false where there are none. */
static bool differentiate(mbsr_ida *ida, double t, double c, N_Vector y, N_Vector yp,
                          SUNMatrix matrix)
{
    const double *at = N_VGetArrayPointer(y), *rate = N_VGetArrayPointer(yp);
    if (!ida->linear.tangent ||
        mbsr_newton_linearise(ida->linear.tangent, ida->data, t, at, rate, c))
        return false;
    for (int k = 0; k < mbsr_model_nq(ida->model); ++k) {
        double *column = SUNDenseMatrix_Column(matrix, k);
        memset(column, 0, (size_t)ida->size * sizeof *column);
        column[k] = 1.0;
        if (mbsr_newton_multiply(ida->linear.tangent, column, column)) return false;
    }
    return true;
}

static int central(sunrealtype t, sunrealtype c, N_Vector y, N_Vector yp, N_Vector r,
                   SUNMatrix matrix, void *user, N_Vector plus, N_Vector minus, N_Vector unused)
{
    (void)unused;
    mbsr_ida *ida = user;
    const int nq = mbsr_model_nq(ida->model), u = nq + mbsr_model_nu(ida->model);
    const double *value = N_VGetArrayPointer(y);
    sizes s = {0.0, largest(ida, value, nq, u), largest(ida, value, u, ida->size)};
    int status = MBSR_OK;
    IDAGetCurrentStep(ida->memory, &s.h);
    const bool exact = differentiate(ida, t, c, y, yp, matrix);
    for (int k = exact ? nq : 0; k < ida->size && !status; ++k) {
        double *column = SUNDenseMatrix_Column(matrix, k);
        status = k < nq ? two_sided(ida, t, c, y, yp, k, column, plus, minus)
                        : one_sided(ida, t, c, s, y, yp, k, column, r, plus);
    }
    return status;
}

void mbsri_ida_use_central(void *user, bool wanted)
{
    mbsr_ida *ida = user;
    IDASetJacFn(ida->memory, wanted ? central : NULL);
}

/* In these forms F is linear in y'. */
int mbsri_ida_weigh(void *user, N_Vector x)
{
    mbsr_ida *ida = user;
    N_Vector y = NULL, yp = NULL, plus = ida->displaced, minus = ida->work;
    double t = 0.0;
    if (IDAGetCurrentTime(ida->memory, &t) < 0 || IDAGetCurrentY(ida->memory, &y) < 0 ||
        IDAGetCurrentYp(ida->memory, &yp) < 0)
        return -1;
    ida->count.central_residuals += 2;
    N_VLinearSum(1.0, yp, 1.0, x, minus);
    int status = mbsri_ida_residual(t, y, minus, plus, ida);
    if (!status) status = mbsri_ida_residual(t, y, yp, minus, ida);
    if (!status) N_VLinearSum(1.0, plus, -1.0, minus, x);
    return status;
}
