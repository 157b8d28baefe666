/* What makes modal masses 1.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_UNIT_MASSES_H
#define MBSRI_UNIT_MASSES_H

#include "flexible/data.h"

/* f->massive, and root, spread and diagonal where there are no dependent shapes and the masses of
 * the others are well enough conditioned; else root becomes NULL. */
void mbsri_flex_find_root(mbsr_flex *f);

/* y <- R^T x for columns of n numbers, and R x for one; zero at massless modes. */
void mbsri_flex_to_unit_masses(const mbsr_flex *f, int columns, const double *x, double *y);
void mbsri_flex_from_unit_masses(const mbsr_flex *f, const double *x, double *y);

#endif
