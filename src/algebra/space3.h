/* Vectors and rotations in space, written out. Outputs may be inputs unless said otherwise.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SPACE3_H
#define MBSRI_SPACE3_H

#include <math.h>
#include <stdbool.h>

static inline double mbsri_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double mbsri_norm3(const double a[3])
{
    return sqrt(mbsri_dot3(a, a));
}

/* c = a x b */
static inline void mbsri_cross3(const double a[3], const double b[3], double c[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
                 z = a[0] * b[1] - a[1] * b[0];
    c[0] = x, c[1] = y, c[2] = z;
}

/* c += a x b; c is neither a nor b */
static inline void mbsri_add_cross3(const double a[3], const double b[3], double c[3])
{
    c[0] += a[1] * b[2] - a[2] * b[1];
    c[1] += a[2] * b[0] - a[0] * b[2];
    c[2] += a[0] * b[1] - a[1] * b[0];
}

/* y += s x */
static inline void mbsri_add3(double s, const double x[3], double y[3])
{
    for (int k = 0; k < 3; ++k) y[k] += s * x[k];
}

/* n = a / |a|, without overflow; false where a is zero or not finite (n = a then). */
static inline bool mbsri_direction3(const double a[3], double n[3])
{
    const double largest = fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
    const bool good = largest > 0.0 && isfinite(a[0]) && isfinite(a[1]) && isfinite(a[2]);
    for (int k = 0; k < 3; ++k) n[k] = good ? a[k] / largest : a[k];
    const double length = good ? mbsri_norm3(n) : 1.0;
    for (int k = 0; k < 3; ++k) n[k] /= length;
    return good;
}

/* n along q, of a length whose square neither overflows nor vanishes: q itself nearly always; false
 * for zero. */
static inline bool mbsri_scale4(const double q[4], double n[4])
{
    const double square = q[0] * q[0] + mbsri_dot3(q + 1, q + 1);
    const bool fits = square > 1e-280 && square < 1e280;
    const double largest =
        fits ? 1.0 : fmax(fmax(fabs(q[0]), fabs(q[1])), fmax(fabs(q[2]), fabs(q[3])));
    for (int k = 0; k < 4; ++k) n[k] = fits ? q[k] : q[k] / largest;
    return largest > 0.0;
}

/* y = R x, column-major */
static inline void mbsri_rotate3(const double R[9], const double x[3], double y[3])
{
    const double a = x[0], b = x[1], c = x[2];
    for (int k = 0; k < 3; ++k) y[k] = R[k] * a + R[3 + k] * b + R[6 + k] * c;
}

/* y = R^T x */
static inline void mbsri_unrotate3(const double R[9], const double x[3], double y[3])
{
    const double a = x[0], b = x[1], c = x[2];
    for (int k = 0; k < 3; ++k) y[k] = R[3 * k] * a + R[3 * k + 1] * b + R[3 * k + 2] * c;
}

/* C = A B; C is neither A nor B */
static inline void mbsri_multiply3(const double A[9], const double B[9], double C[9])
{
    for (int k = 0; k < 3; ++k) mbsri_rotate3(A, B + 3 * k, C + 3 * k);
}

/* C = A B^T; C is neither A nor B */
static inline void mbsri_multiply_transposed3(const double A[9], const double B[9], double C[9])
{
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k)
            C[3 * j + k] = A[k] * B[j] + A[3 + k] * B[3 + j] + A[6 + k] * B[6 + j];
    }
}

/* X = [a]x, so that X b = a x b */
static inline void mbsri_cross_matrix3(const double a[3], double X[9])
{
    X[0] = X[4] = X[8] = 0.0;
    X[5] = a[0], X[7] = -a[0];
    X[6] = a[1], X[2] = -a[1];
    X[1] = a[2], X[3] = -a[2];
}

#endif
