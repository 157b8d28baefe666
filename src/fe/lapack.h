/* The BLAS and LAPACK routines of the component, behind C signatures. Matrices column-major,
 * leading dimension = rows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_LAPACK_H
#define MBSRI_FE_LAPACK_H

#include <stddef.h>

/* C (r x c) = s A B + t C,  A r x k, B k x c */
void mbsri_fe_ab(int r, int k, int c, double s, const double *A, const double *B, double t,
                 double *C);

/* C (r x c) = A^T B,  A k x r, B k x c */
void mbsri_fe_atb(int k, int r, int c, const double *A, const double *B, double *C);

/* Lower triangle of A (n x n) becomes L with A = L L^T. Returns the column that has no positive
 * pivot, -1: none. */
int mbsri_fe_cholesky(int n, double *A);

/* X (n x c) <- (L L^T)^-1 X */
void mbsri_fe_cholesky_solve(int n, const double *L, int c, double *X);

/* Eigenvalues of the symmetric A (n x n) in ascending order in w; A becomes the eigenvectors. work:
 * 3 n + n n. Returns LAPACK's info. */
int mbsri_fe_eigen(int n, double *A, double *w, double *work);
size_t mbsri_fe_eigen_work(int n);

#endif
