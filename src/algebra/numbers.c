/* Finiteness and size of vectors.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/numbers.h"

#include <math.h>

bool mbsri_finite(size_t n, const double *x)
{
    /* 0 x is 0 for finite x and NaN for others; four sums at a time do not wait for each other */
    double sum[4] = {0.0};
    size_t k = 0;
    for (; k + 4 <= n; k += 4) {
        for (size_t l = 0; l < 4; ++l) sum[l] += 0.0 * x[k + l];
    }
    for (; k < n; ++k) sum[0] += 0.0 * x[k];
    return sum[0] + sum[1] + sum[2] + sum[3] == 0.0;
}

double mbsri_largest(int n, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(x[k]));
    return value;
}
