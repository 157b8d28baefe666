/* Derivatives of trees of rigid bodies on stock joints, by the sweeps of rigid_sweeps.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_RIGID_H
#define MBSRI_DERIVATIVES_RIGID_H

#include "derivatives/rigid_record.h"

/* Whether the model is such a tree. */
bool mbsri_rigid_serves(const mbsr_model *m);

/* NULL: there is no memory. */
mbsri_rigid *mbsri_rigid_create(const mbsr_model *m);
void mbsri_rigid_destroy(mbsri_rigid *r);

/* Linearises at the state that the data's sweeps have left, of forward or of inverse dynamics; all
 * by the caller's order. A status. */
int mbsri_rigid_linearise(mbsri_rigid *r, mbsr_data *d, const double *q, const double *u,
                          const double *udot, bool forward);

#endif
