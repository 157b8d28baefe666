/* Solving with loops that close (front.h), in vector code.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_SOLVE_H
#define MBSRI_FRONT_SOLVE_H

#include "newton/carried/carried.h"

/* Before all: r of the rows of closures (NULL: zero), by the caller's order. */
void mbsri_front_load(mbsr_newton *w, const double *r);

/* After all: the multipliers' part of delta. */
void mbsri_front_multipliers(const mbsr_newton *w, const double *r, double *delta);

#endif
