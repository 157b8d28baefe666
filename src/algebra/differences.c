/* Rounding in difference quotients.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/differences.h"

#include <float.h>

double mbsri_slope_noise(int count, int at, int stride, const double *slopes, double size,
                         double share, double unit)
{
    /* of sums of forces, and of projections on null directions, which are less exact */
    static const double rounding = 1e3 * DBL_EPSILON;
    double steepest = 0.0;
    for (int k = 0; k < count && k <= at + 3; ++k)
        steepest = fmax(steepest, fabs(slopes[k * stride]));
    return rounding * (size / unit + 32.0 * steepest) / share;
}
