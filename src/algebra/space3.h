/* Vectors and rotations in space, written out. Outputs may be inputs unless said otherwise.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SPACE3_H
#define MBSRI_SPACE3_H

#include "algebra/dense.h"

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

/* Whether H (6 x 6) is minus a translation of twists, H = -X with X = [1 0; -[rho]x 1], as between
 * rigid bodies along the world's axes. */
static inline bool mbsri_is_translation(const double H[36], double rho[3])
{
    const double x = H[11], y = H[15], z = H[4];
    const double expected[36] = {-1.0, 0.0, 0.0,  0.0, z,    -y,  0.0, -1.0, 0.0, -z,   0.0, x,
                                 0.0,  0.0, -1.0, y,   -x,   0.0, 0.0, 0.0,  0.0, -1.0, 0.0, 0.0,
                                 0.0,  0.0, 0.0,  0.0, -1.0, 0.0, 0.0, 0.0,  0.0, 0.0,  0.0, -1.0};
    rho[0] = x, rho[1] = y, rho[2] = z;
    return mbsri_same(18, H, expected);
}

/* C += X^T A X of a symmetric A = [a b^T; b c]:  b - c [rho]x,  a + Y + Y^T with Y = [rho]x (b - c
 * [rho]x / 2). C may not be A. */
static inline void mbsri_translate_matrix(const double rho[3], const double A[36], double C[36])
{
    const double x = rho[0], y = rho[1], z = rho[2];
    double Y[9];
    for (int k = 0; k < 3; ++k) {
        /* column k of c [rho]x, and of b with half of it */
        const double *c[3] = {A + 21, A + 27, A + 33}, *b = A + 6 * k + 3;
        const double turn[3][3] = {{0.0, z, -y}, {-z, 0.0, x}, {y, -x, 0.0}};
        double half[3];
        for (int l = 0; l < 3; ++l) {
            const double cr = c[0][l] * turn[k][0] + c[1][l] * turn[k][1] + c[2][l] * turn[k][2];
            half[l] = b[l] - 0.5 * cr;
            C[6 * k + 3 + l] += b[l] - cr;
            C[6 * (3 + l) + k] += b[l] - cr;
            C[6 * (3 + k) + 3 + l] += c[k][l];
        }
        mbsri_cross3(rho, half, Y + 3 * k);
    }
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) C[6 * k + l] += A[6 * k + l] + Y[3 * k + l] + Y[3 * l + k];
    }
}

#endif
