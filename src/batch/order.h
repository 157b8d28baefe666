/* Numbers of several states between the caller's order and the lanes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_ORDER_H
#define MBSRI_BATCH_ORDER_H

#include "batch/wide.h"

#include <stddef.h>

MBSRI_INLINE unsigned set_of(lane_bits where)
{
    unsigned set = 0;
    for (int l = 0; l < MBSRI_LANES; ++l) set |= (unsigned)(where[l] & 1) << l;
    return set;
}

/* x(0), x(1), ..., one for each lane */
#if MBSRI_LANES == 8
#define MBSRI_LIST(x) x(0), x(1), x(2), x(3), x(4), x(5), x(6), x(7)
#elif MBSRI_LANES == 4
#define MBSRI_LIST(x) x(0), x(1), x(2), x(3)
#else
#define MBSRI_LIST(x) x(0), x(1)
#endif

/* ---- all numbers of some states; `place` is where the caller's k-th stands in the lanes ---- */

static unsigned gather_states(int n, const int *place, int count, const double *from, double *to)
{
    const double *state[MBSRI_LANES];
    lanes *all = (lanes *)to;
    lane_bits finite = {0};
    finite = ~finite;
    for (int l = 0; l < MBSRI_LANES; ++l)
        state[l] = from + (size_t)n * (size_t)(l < count ? l : count - 1);
    for (int k = 0; k < n; ++k) {
#define MBSRI_K_OF(l) state[l][k]
        const lanes x = {MBSRI_LIST(MBSRI_K_OF)};
        finite &= x - x == splat(0.0);
        all[place ? place[k] : k] = x;
    }
    return set_of(finite);
}

static unsigned scatter(int n, const int *place, int count, const double *from, double *to)
{
    const lanes *all = (const lanes *)from;
    lane_bits finite = {0};
    finite = ~finite;
    for (int k = 0; k < n; ++k) {
        const lanes x = all[place ? place[k] : k];
        finite &= x - x == splat(0.0);
        for (int l = 0; l < MBSRI_LANES; ++l) {
            if (l < count) to[(size_t)n * (size_t)l + (size_t)k] = x[l];
        }
    }
    return set_of(finite);
}

#endif
