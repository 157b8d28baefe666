/* Solving with loops that close (front.h), in vector code.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_SOLVE_H
#define MBSRI_FRONT_SOLVE_H

#include "newton/carried/carried.h"

/* Before all: r of the rows of closures (NULL: zero), by the caller's order. */
void mbsri_front_load(mbsr_newton *w, const double *r);

/* After all: the multipliers' part of delta. */
void mbsri_front_multipliers(const mbsr_newton *w, const double *r, double *delta);

/* Transposed: before all, what is said of the multipliers, and x of rows that are left out; after
 * all, x of the others. */
void mbsri_front_multipliers_transposed(mbsr_newton *w, const double *v, double *x);
void mbsri_front_load_transposed(const mbsr_newton *w, double *x);

#endif
