/* Derivatives of a flexible body's momentum and inertia forces along its pose and velocity.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FLEX_SLOPES_H
#define MBSRI_FLEX_SLOPES_H

#include "flexible/data.h"

/* Doubles of scratch. */
size_t mbsri_flex_slopes_size(const mbsr_flex *f);

/* Takes one column: the derivatives (d) of M V, of h - M' V and of h + M A. */
typedef void mbsri_flex_column_fn(void *to, int column, const double *momentum,
                                  const double *turning, const double *load);

/* Columns 0 .. d - 1: the pose (small rotation, displacement, s), d .. 2 d - 1: V. At pose (R, s),
 * velocity V and acceleration A (d). */
void mbsri_flex_slopes_of(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                          const double *A, double *work, mbsri_flex_column_fn *take, void *to);

#endif
