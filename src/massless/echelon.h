/* A basis with few entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ECHELON_H
#define MBSRI_ECHELON_H

/* X (n x k, column-major), orthonormal columns: others that span the same, k of whose rows are
 * those of the unit matrix. What is rounding is zero. */
void mbsri_echelon(int n, int k, double *X);

#endif
