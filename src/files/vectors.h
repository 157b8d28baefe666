/* Vectors in space, for files: the component knows the public headers alone.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_VECTORS_H
#define MBSRI_FILES_VECTORS_H

/* c = a x b; c is neither of them */
static inline void mbsri_vectors_cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        c[k] = a[i] * b[j] - a[j] * b[i];
    }
}

/* y = R x, R by columns; y may be x */
static inline void mbsri_vectors_rotate(const double R[9], const double x[3], double y[3])
{
    const double a = x[0], b = x[1], c = x[2];
    for (int k = 0; k < 3; ++k) y[k] = R[k] * a + R[3 + k] * b + R[6 + k] * c;
}

/* y = R^T x; y may be x */
static inline void mbsri_vectors_rotate_back(const double R[9], const double x[3], double y[3])
{
    const double a = x[0], b = x[1], c = x[2];
    for (int k = 0; k < 3; ++k) y[k] = R[3 * k] * a + R[3 * k + 1] * b + R[3 * k + 2] * c;
}

#endif
