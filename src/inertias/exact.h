/* Inertia tensors in twofold precision: what cancels in sums of moments stays.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A tensor I and the second moments P = sum of m r r^T are the same up to a linear map,
 *
 *   I = trace(P) 1 - P,    P = trace(I) / 2 1 - I
 *
 * but turning is not the same for both where the axes R are orthonormal only up to rounding: R P
 * R^T is still that of a distribution of mass, whose points have moved by rounding, so a moment of
 * next to nothing about an axis stays one. R I R^T is wrong by the trace of I times machine
 * precision. So P is turned. */
#ifndef MBSRI_EXACT_H
#define MBSRI_EXACT_H

#include "algebra/twofold.h"

#include <mbsrank/inertia.h>

#include <stdbool.h>

/* Where entry (j, k) of a tensor stands: MBSR_XX .. MBSR_YZ. */
static inline int mbsri_tensor_place(int j, int k)
{
    return j == k ? j : MBSR_XY + j + k - 1;
}

/* About the centre of mass in body axes. */
typedef struct mbsri_exact {
    double mass, lost;
    mbsri_two com[3], tensor[6];
} mbsri_exact;

/* Of a rigid body in space (SPATIAL). */
mbsri_exact mbsri_exact_of(const mbsr_inertia *inertia);

/* com_rest, tensor_rest and lost of an inertia whose other numbers are these, rounded. */
void mbsri_exact_settle(const mbsri_exact *exact, mbsr_inertia *inertia);

/* y = R x;  the tensor along turned axes;  the tensor += mass (|c|^2 - c c^T). */
void mbsri_exact_rotate(const double R[9], const mbsri_two x[3], mbsri_two y[3]);
void mbsri_exact_turn(const double R[9], mbsri_two tensor[6]);
void mbsri_exact_parallel_axes(double mass, const mbsri_two c[3], mbsri_two tensor[6]);

/* Whether a moment about an axis through the body's origin is so small beside others, and the axis
 * so oblique, that the tensor about the origin in double precision does not have it to ten digits.
 */
bool mbsri_exact_hides_moment(const mbsr_inertia *inertia);

/* M of a rigid body, 6 x 6, in a pose with axes R. */
void mbsri_exact_mass(const mbsr_inertia *inertia, const double R[9], mbsri_two M[36]);

#endif
