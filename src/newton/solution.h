/* Solutions of the Newton solver, by whichever elimination has factored.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_SOLUTION_H
#define MBSRI_NEWTON_SOLUTION_H

#include "newton/carried/record.h"

/* delta from r + (dF/dtau) tau into w->solution; tau (nu): NULL, none, and none of lean solvers.
 * w->right may be r, and is overwritten where there are some. False: see mbsri_front_solve. */
bool mbsri_newton_solution(mbsr_newton *w, const double *r, const double *tau);

/* x from v, not the same, with the transposed matrix. tau: NULL, or where (dF/dtau)^T x goes. */
void mbsri_newton_solution_transposed(mbsr_newton *w, const double *v, double *x, double *tau);

#endif
