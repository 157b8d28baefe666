/* The test of a joint's derivatives.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JOINT_CHECK_TANGENTS_H
#define MBSRI_JOINT_CHECK_TANGENTS_H

#include "verify/verifier.h"

/* Places its arrays as lay_out of joint_check.c does, and compares tangent and rate_tangent
 * at `base`. Needs row and speed. */
void mbsri_verifier_lay_out_tangents(mbsri_verifier *w, double *memory, size_t *used);
int mbsri_verify_tangents(mbsri_verifier *w);

#endif
