/* Motions and forces in space, in lanes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_RIGID_PAIRS_H
#define MBSRI_DERIVATIVES_RIGID_PAIRS_H

#include "sweeps/lane.h"

/* Motions or forces in space: angular and linear part. */
typedef struct pair {
    v4 w, v;
} pair;

MBSRI_INLINE pair load_pair(const double x[8])
{
    return (pair){load(x), load(x + 4)};
}

MBSRI_INLINE void store_pair(double x[8], pair a)
{
    store(x, a.w);
    store(x + 4, a.v);
}

MBSRI_INLINE pair plus(pair a, double s, pair b)
{
    return (pair){a.w + splat(s) * b.w, a.v + splat(s) * b.v};
}

/* a x b of motions; a x* f of a motion and a force. */
MBSRI_INLINE pair cross_motion(pair a, pair b)
{
    return (pair){cross(a.w, b.w), cross(a.w, b.v) + cross(a.v, b.w)};
}

MBSRI_INLINE pair cross_force(pair a, pair f)
{
    return (pair){cross(a.w, f.w) + cross(a.v, f.v), cross(a.w, f.v)};
}

MBSRI_INLINE double dot(pair a, pair b)
{
    return sum3(a.w * b.w + a.v * b.v);
}

#endif
