/* Derivatives of a joint's equations where it is a sequence of axes in space, in formulas.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_AXES_H
#define MBSRI_AXES_H

#include "recursion/data.h"

/* Whether the joint is one: rotations, translations and screws between bodies in space, all free,
 * q' = u. */
bool mbsri_axes_serve(const mbsri_body *b);

/* The derivatives of joint_slopes.h without rows and columns of A, mu and u': x (12 rows), below
 * (12), own (2 n), qdot (n), of 12 + 2 n columns each: the predecessor's pose and V, q, u. On a
 * root at rest there is neither its motion nor `below`. */
void mbsri_axes_slopes(const mbsri_body *b, const mbsr_data *d, double *x, double *below,
                       double *own, double *qdot);

#endif
