/* A direction that moves no mass, from the joints where it begins to the leaves.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NULL_LIFT_H
#define MBSRI_NULL_LIFT_H

#include "recursion/data.h"

/* What rounding leaves of a sum, as a share of its terms: positions and axes come out of many
 * turns. */
#define MBSRI_NULL_ROUNDING 1e-14

/* How many times its error bound a number has to be, to be told from zero. */
#define MBSRI_NULL_CLEAR 10.0

/* A direction and its twist, with bounds of their errors: nu and size_v numbers. */
typedef struct mbsri_lifted {
    double *a, *a_error, *twist, *twist_error;
} mbsri_lifted;

/* Where rotations and translations stand in V of a body in space or in the plane, and moments and
 * forces in f; false where there are none. */
bool mbsri_motion_places(const mbsri_body *b, int *turns, int *rotation, int *moves,
                         int *translation);

/* Each of the sizes (d) of a motion is that of its kind, turning or moving: axes are known to the
 * last digit of their length, not of each component. */
void mbsri_null_spread(const mbsri_body *b, double *sizes);

/* x (n) = 0 where it may be error. */
void mbsri_null_drop(size_t n, double *x, const double *error);

/* Numbers of scratch for a lift. */
size_t mbsri_null_lift_room(const mbsr_model *m);

/* The direction of null rates z (nu) of the group of head j or groups behind it; size (nu): of what
 * they were added up from. The data holds mbsri_backward. */
void mbsri_null_lift(const mbsr_model *m, mbsr_data *d, int j, const double *z, const double *size,
                     const mbsri_lifted *out, double *room);

#endif
