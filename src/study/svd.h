/* Singular values of a tall matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SVD_H
#define MBSRI_SVD_H

/* A (m x n, m >= n, column-major) becomes U diag(s) with A = U diag(s) V^T; V: n x n, s: n,
 * descending. One-sided rotations of Jacobi's (Hestenes 1958): small singular values are as exact
 * as large ones where columns are scaled badly. */
void mbsri_svd(int m, int n, double *A, double *V, double *s);

#endif
