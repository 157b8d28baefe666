/* Slopes of the forces in the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NULL_SLOPES_H
#define MBSRI_NULL_SLOPES_H

#include "massless/null_space.h"

/* C and S at a state by central differences; the basis stays. Forces are evaluated at up to ten
 * times the positions and 10^6 times the velocities of the state. */
int mbsri_null_slopes(mbsri_null_space *w, double t, const double *q, const double *u);

#endif
