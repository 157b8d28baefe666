/* Joints of which some coordinates are held.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/locks.h"

#include <math.h>
#include <string.h>

void mbsri_with_held(const mbsri_body *b, const double *x, bool values, double *full)
{
    for (int k = 0; k < b->joint.n; ++k) {
        full[k] = isnan(b->lock.at[k]) ? *x++ : values ? b->lock.at[k] : 0.0;
    }
}

void mbsri_drop_held(const mbsri_body *b, const double *full, double *J)
{
    const size_t d = (size_t)b->d;
    for (size_t k = 0; k < (size_t)b->joint.n; ++k) {
        if (!isnan(b->lock.at[k])) continue;
        memmove(J, full + k * d, d * sizeof *J);
        J += d;
    }
}
