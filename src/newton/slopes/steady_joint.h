/* Derivatives of a joint that moves its body the same way in every state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STEADY_JOINT_H
#define MBSRI_STEADY_JOINT_H

#include "recursion/data.h"

/* Whether J is constant: a free body, or one on a ball about its origin, behind a root at rest. */
bool mbsri_steady_joint_serves(const mbsri_body *b);

/* The columns of q (first) and of u (next), of x (18 rows) and qdot (nq), as in joint_slopes.h; all
 * arrive as zero. q, u: of the joint. */
void mbsri_steady_joint(const mbsri_body *b, const mbsr_data *d, const double *q, const double *u,
                        double *const x[2], double *const qdot[2]);

#endif
