/* Force elements in derivatives of trees of rigid bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_RIGID_ELEMENTS_H
#define MBSRI_DERIVATIVES_RIGID_ELEMENTS_H

#include "derivatives/record.h"

/* Derivatives of elements at the state that the data's sweeps have left. A status. */
int mbsri_rigid_elements_keep(mbsr_derivatives *w);

/* Along dq, du: the changes of loads on bodies, into those of `rigid`, and of joint forces, added
 * to `torque` of w, in the order of the sweeps. */
void mbsri_rigid_elements_along(mbsr_derivatives *w, const double *dq, const double *du);

/* The transpose, where the work has Y = sum of S by: what it makes of gradients by motions goes
 * into the work, what it makes of those by coordinates into `by_q` and `by_u`. */
void mbsri_rigid_elements_back(mbsr_derivatives *w, const double *by);

#endif
