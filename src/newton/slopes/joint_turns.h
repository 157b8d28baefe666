/* Derivatives of a joint's equations along motions of its predecessor, where it knows of places
 * only how the two bodies lie to each other.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JOINT_TURNS_H
#define MBSRI_JOINT_TURNS_H

#include "recursion/data.h"

/* Whether the joint is one: a sequence of axes between bodies in space. */
bool mbsri_joint_turns_serve(const mbsri_body *b);

/* The columns of the predecessor's pose and V of joint i, which are zero before: of the body's
 * pose, V and A (18 rows), of what goes to the predecessor (18), of the joint's own (3 n), as in
 * joint_slopes.h. */
void mbsri_joint_turns(const mbsr_model *m, const mbsr_data *d, int i, bool accelerated,
                       const double *udot, double *x, double *below, double *own);

#endif
