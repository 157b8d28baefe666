/* Statistics of numbers: see statistics.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/statistics.h"

#include <math.h>
#include <stdlib.h>

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile_of(const double *sorted, long n, double part)
{
    const double place = part * (double)(n - 1);
    const long k = (long)place;
    const double rest = place - (double)k;
    return k + 1 < n ? sorted[k] + rest * (sorted[k + 1] - sorted[k]) : sorted[n - 1];
}

study_statistics statistics_of(long n, double *x)
{
    study_statistics s = {n, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    double sum = 0.0, squares = 0.0;
    if (n == 0) return s;
    qsort(x, (size_t)n, sizeof *x, by_size);
    for (long l = 0; l < n; ++l) sum += x[l];
    s.mean = sum / (double)n;
    for (long l = 0; l < n; ++l) squares += (x[l] - s.mean) * (x[l] - s.mean);
    if (n > 1) s.deviation = sqrt(squares / (double)(n - 1));
    s.least = x[0];
    s.most = x[n - 1];
    s.low = quantile_of(x, n, 0.05);
    s.median = quantile_of(x, n, 0.5);
    s.high = quantile_of(x, n, 0.95);
    return s;
}
