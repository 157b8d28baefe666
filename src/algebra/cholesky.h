/* Cholesky factors of small matrices, column-major. Unlike an eigen-decomposition they are as exact
 * in rows of small entries as in others: the error of A_jk is of the size of sqrt(A_jj A_kk).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CHOLESKY_H
#define MBSRI_CHOLESKY_H

#include <stdbool.h>

/* The lower triangle of A (n x n, the upper one is not read) becomes L with A = L L^T. False where
 * A is not positive definite; then A is lost. */
bool mbsri_cholesky(int n, double *A);

/* X (r x n) <- X L^-T */
void mbsri_divide_by_cholesky(int r, int n, const double *L, double *X);

#endif
