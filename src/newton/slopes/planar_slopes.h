/* Derivatives of a joint's equations in the plane, in formulas.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PLANAR_SLOPES_H
#define MBSRI_PLANAR_SLOPES_H

#include "recursion/data.h"

/* Whether the joint is a stock one between bodies in the plane, or of one on a root at rest. */
bool mbsri_planar_slopes_serve(const mbsri_body *b);

/* The columns of the predecessor's pose and V, of q and of u: of the body's pose, V and A (9 rows),
 * of what goes to the predecessor (9, none at a root at rest), of the joint's own (3 n) and of q'
 * (nq), as in joint_slopes.h; all arrive as zero. */
void mbsri_planar_slopes(const mbsri_body *b, const mbsr_data *d, bool accelerated,
                         const double *udot, double *x, double *below, double *own, double *qdot);

#endif
