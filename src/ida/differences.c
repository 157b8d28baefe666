/* A dense matrix by central differences.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA's difference quotients are one-sided. Of a stiff element they take the force that its
 * direction turns into along the step, of the second order in the step times the stiffness, for a
 * slope across that direction, where only inertia stands against it: with k = 1e12 N/m and steps of
 * 1e-8 rad the error is 1e4 N/m and Newton's method fails. Central differences, with steps near the
 * third root of the rounding error, have none of the second order, for twice the price. Only the
 * coordinates turn a direction: other columns have one side as before. */
#include "ida/differences.h"

#include "ida/callbacks.h"
#include "ida/tolerances.h"

#include <ida/ida_ls.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <float.h>
#include <math.h>

/* F at y + sign step e_k, y' + sign c step e_k */
static int shifted(mbsr_ida *ida, double t, N_Vector y, N_Vector yp, int k, double step, double c,
                   N_Vector F)
{
    double *value = N_VGetArrayPointer(y) + k, *rate = N_VGetArrayPointer(yp) + k;
    const double y_k = *value, yp_k = *rate;
    *value = y_k + step;
    *rate = yp_k + c * step;
    ++ida->central_residuals;
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

/* Column k by one side; r is F at y, y', h the step of IDA. */
static int one_sided(mbsr_ida *ida, double t, double c, double h, N_Vector y, N_Vector yp, int k,
                     double *column, N_Vector r, N_Vector plus)
{
    const double tolerance = mbsri_ida_tolerance(ida, N_VGetArrayPointer(y), k),
                 moved = fabs(h * N_VGetArrayPointer(yp)[k]);
    const double size = fmax(fabs(N_VGetArrayPointer(y)[k]), fmax(moved, tolerance));
    const double step = sqrt(DBL_EPSILON) * size;
    const int status = shifted(ida, t, y, yp, k, step, c, plus);
    if (status) return status;
    const double *a = N_VGetArrayPointer(plus), *b = N_VGetArrayPointer(r);
    for (int row = 0; row < ida->size; ++row) column[row] = (a[row] - b[row]) / step;
    return MBSR_OK;
}

static int central(sunrealtype t, sunrealtype c, N_Vector y, N_Vector yp, N_Vector r,
                   SUNMatrix matrix, void *user, N_Vector plus, N_Vector minus, N_Vector unused)
{
    (void)unused;
    mbsr_ida *ida = user;
    const int nq = mbsr_model_nq(ida->model);
    double h = 0.0;
    int status = MBSR_OK;
    IDAGetCurrentStep(ida->memory, &h);
    for (int k = 0; k < ida->size && !status; ++k) {
        double *column = SUNDenseMatrix_Column(matrix, k);
        status = k < nq ? two_sided(ida, t, c, y, yp, k, column, plus, minus)
                        : one_sided(ida, t, c, h, y, yp, k, column, r, plus);
    }
    return status;
}

void mbsri_ida_use_central(void *user, bool wanted)
{
    mbsr_ida *ida = user;
    IDASetJacFn(ida->memory, wanted ? central : NULL);
}
