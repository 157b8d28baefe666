/* Eigenvalues of small symmetric matrices, without the overhead of a call of LAPACK.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JACOBI_H
#define MBSRI_JACOBI_H

enum { MBSRI_JACOBI_MAX = 6 };

/* Eigenvalues of the symmetric A (n x n, n <= MBSRI_JACOBI_MAX) in descending order; A becomes the
 * eigenvectors. Returns 0, or 1 if the rotations did not end. */
int mbsri_jacobi(int n, double *A, double *lambda);

/* A (n x c) <- A Q with an orthogonal Q that makes its columns orthogonal, by descending length:
 * the eigenvectors of A A^T, not of unit length, and into lambda (c) the squares of these lengths,
 * its eigenvalues. Each keeps its digits however small it is beside others, if those of A's columns
 * do (Demmel and Veselic 1992). Returns 0, or 1 if the rotations did not end. */
int mbsri_orthogonalise(int n, int c, double *A, double *lambda);

#endif
