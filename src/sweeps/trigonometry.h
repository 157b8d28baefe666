/* Sines and cosines of all coordinates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_TRIGONOMETRY_H
#define MBSRI_SWEEPS_TRIGONOMETRY_H

#include "sweeps/lane.h"
#include "sweeps/sine.h"

#include <math.h>

/* Of `count` of the four numbers x. */
MBSRI_INLINE void store_sine_cosine(v4 x, int count, double *sincos)
{
    v4 s, c;
    sine_cosine(x, &s, &c);
    for (int l = 0; l < count; ++l) {
        const bool far = !(fabs(x[l]) < (double)MBSRI_REDUCED);
        sincos[2 * l] = far ? cos(x[l]) : c[l];
        sincos[2 * l + 1] = far ? sin(x[l]) : s[l];
    }
}

static void trigonometry(int n, const double *q, double *sincos)
{
    int k = 0;
    for (; k + 4 <= n; k += 4)
        store_sine_cosine((v4){q[k], q[k + 1], q[k + 2], q[k + 3]}, 4, sincos + 2 * k);
    const int rest = n - k;
    if (rest == 0) return;
    const v4 x = {q[k], rest > 1 ? q[k + 1] : 0.0, rest > 2 ? q[k + 2] : 0.0, 0.0};
    store_sine_cosine(x, rest, sincos + 2 * k);
}

#endif
