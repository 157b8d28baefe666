/* The LAPACK routines used, behind C signatures. Matrices column-major, leading dimension = rows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LAPACK_H
#define MBSRI_LAPACK_H

/* Eigenvalues of the symmetric A (n x n, lower triangle read) in ascending order in w; A becomes
 * the eigenvectors. Returns LAPACK's info. */
int mbsri_lapack_syev(int n, double *A, double *w, double *work, int lwork);

/* Doubles of workspace syev needs at most for matrices up to n x n. */
int mbsri_lapack_syev_work(int n);

/* A (n x n) becomes its inverse; pivots: n ints, work: 4 n doubles. Returns the reciprocal
 * condition number in the 1-norm, 0 for an exactly singular matrix (A is then not the inverse). */
double mbsri_lapack_inverse(int n, double *A, int *pivots, double *work);

/* Singular value decomposition of A (n x n, overwritten): singular values in descending order in s,
 * left and right singular vectors in the columns of U and V (n x n). Returns info;
 * what is not finite, on which LAPACK may iterate for ever, gives n + 1, as without convergence. */
int mbsri_lapack_svd(int n, double *A, double *s, double *U, double *V, double *work, int lwork);

/* The singular values alone. */
int mbsri_lapack_singular_values(int n, double *A, double *s, double *work, int lwork);

/* Doubles of workspace that svd and a gelsy of that size need. */
int mbsri_lapack_svd_work(int n);

/* Least squares min |A x - b| by QR with column pivoting and rank decision at rcond; A (r x c) is
 * overwritten, b has max(r, c) numbers and becomes x. Returns info; *rank is the effective rank. */
int mbsri_lapack_gelsy(int r, int c, double *A, double *b, double rcond, int *pivots, int *rank,
                       double *work, int lwork);
int mbsri_lapack_gelsy_work(int r, int c);

#endif
