/* Finiteness and size of vectors.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/numbers.h"

#include "algebra/dense.h"

#include <math.h>

bool mbsri_finite(size_t n, const double *x)
{
    return mbsri_nothing_of(n, x) == 0.0;
}

double mbsri_largest(int n, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(x[k]));
    return value;
}
