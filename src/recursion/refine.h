/* Accelerations corrected by inverse dynamics, and the error left in them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_REFINE_H
#define MBSRI_REFINE_H

#include "recursion/data.h"

/* At the state of mbsri_backward with full ranks: improves udot (by the caller's order). error (nu,
 * by the caller's order): that of each entry; returns the largest over the joints of error over
 * acceleration, sqrt(x^T D x) being the size of either. Writes A and mu of the improved udot. */
double mbsri_refine(const mbsr_model *m, mbsr_data *d, double *udot, double *error);

/* At the same state, x (nu, by the caller's order) = M^-1 r, where `out` of the data holds -r in
 * the order of the sweeps. */
void mbsri_refine_solve(const mbsr_model *m, mbsr_data *d, double *x);

#endif
