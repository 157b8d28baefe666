/* The Newton matrix of a DAE form as a dense matrix of differences, and errors of a solution.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_NEWTON_SYSTEM_H
#define TEST_NEWTON_SYSTEM_H

#include <mbsrank/mbsrank.h>

/* A = dF/dy + c dF/dy' (n x n, column-major) by differences of fourth order; a status of the
 * residual. step: change of an entry of size one. */
int test_newton_matrix(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                       const double *y, const double *yp, double c, double step, double *A);

/* Largest error of x against the solution of A x = r by LAPACK, relative to the largest entry of
 * its kind (q, p or u, of which there are nq, nu, nu); A is used up. */
double test_newton_error(int nq, int nu, double *A, const double *r, const double *x);

#endif
