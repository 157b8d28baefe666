/* Slopes of the forces in the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NULL_SLOPES_H
#define MBSRI_NULL_SLOPES_H

#include "massless/null_space.h"

/* Least shares that count of what is subtracted in the elimination of C, and of S. */
#define MBSRI_LEAST_DAMPING 1e-12
#define MBSRI_LEAST_STIFFNESS 1e-14

/* C, S and their errors at a state; the basis stays but for
 * rounding, and so do the typical sizes of the first state. Forces without derivatives of their own
 * are evaluated at up to ten times the positions and 10^6 times the velocities of the state. */
int mbsri_null_slopes(mbsri_null_space *w, double t, const double *q, const double *u);

/* Whether elements all have derivatives and exert nothing but rounding, and the bodies rest; after
 * mbsri_null_slopes. */
bool mbsri_nothing_acts(const mbsri_null_space *w);

#endif
