/* Rotation vectors: see rotation_vector.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As functions of x = t^2, alpha and beta are analytic; their derivatives by x are alpha1, alpha2
 * and so on. Along u and v
 *
 *   alpha_u = 2 (p.u) alpha1,   alpha_uv = 4 (p.u) (p.v) alpha2 + 2 (u.v) alpha1 */
#include "flexible/rotation_vector.h"

#include "algebra/space3.h"

typedef mbsri_rotation_vector coefficients;

enum { TERMS = 18 };

/* -1 / ((2 k + c + 1) (2 k + c + 2)), by which the coefficients of the series of sinc, alpha, beta
 * (c = 1, 2, 3) follow each other. */
#define RATIO(k, c) (-1.0 / ((2.0 * (k) + (c) + 1.0) * (2.0 * (k) + (c) + 2.0)))
#define RATIOS(k)                                                                                  \
    {                                                                                              \
        RATIO(k, 1), RATIO(k, 2), RATIO(k, 3)                                                      \
    }
static const double ratio[TERMS][3] = {RATIOS(0),  RATIOS(1),  RATIOS(2),  RATIOS(3),  RATIOS(4),
                                       RATIOS(5),  RATIOS(6),  RATIOS(7),  RATIOS(8),  RATIOS(9),
                                       RATIOS(10), RATIOS(11), RATIOS(12), RATIOS(13), RATIOS(14),
                                       RATIOS(15), RATIOS(16), RATIOS(17)};

/* Sums of (-x)^k / (2 k + c)! over k for sinc, alpha, beta and their first two derivatives by x, up
 * to x = 10, from inside: f = 1 + ratio_0 x (1 + ratio_1 x (...)). */
static void series(double x, coefficients *sum)
{
    const int terms = x < 1e-3 ? 6 : x < 0.1 ? 9 : TERMS;
    double f[3] = {1.0, 1.0, 1.0}, f1[3] = {0.0}, f2[3] = {0.0};
    for (int k = terms - 1; k >= 0; --k) {
        for (int c = 0; c < 3; ++c) {
            const double r = ratio[k][c];
            f2[c] = r * (2.0 * f1[c] + x * f2[c]);
            f1[c] = r * (f[c] + x * f1[c]);
            f[c] = 1.0 + r * x * f[c];
        }
    }
    sum->sinc = f[0];
    sum->alpha[0] = f[1] / 2.0, sum->alpha[1] = f1[1] / 2.0, sum->alpha[2] = f2[1] / 2.0;
    sum->beta[0] = f[2] / 6.0, sum->beta[1] = f1[2] / 6.0, sum->beta[2] = f2[2] / 6.0;
}

/* From x alpha = 1 - cos t, x beta = 1 - sinc and their derivatives, with sinc' = (cos t - sinc) /
 * 2 x and (1 - cos t)' = sinc / 2. */
static void closed_coefficients(double x, coefficients *c)
{
    const double t = sqrt(x), cosine = cos(t), sinc = sin(t) / t,
                 sinc1 = (cosine - sinc) / (2.0 * x),
                 sinc2 = (-0.5 * sinc - 3.0 * sinc1) / (2.0 * x);
    c->sinc = sinc;
    c->alpha[0] = (1.0 - cosine) / x;
    c->alpha[1] = (0.5 * sinc - c->alpha[0]) / x;
    c->alpha[2] = (0.5 * sinc1 - 2.0 * c->alpha[1]) / x;
    c->beta[0] = (1.0 - sinc) / x;
    c->beta[1] = (-sinc1 - c->beta[0]) / x;
    c->beta[2] = (-sinc2 - 2.0 * c->beta[1]) / x;
}

mbsri_rotation_vector mbsri_rotation_vector_of(const double p[3])
{
    const double x = mbsri_dot3(p, p);
    coefficients c = {.p = {p[0], p[1], p[2]}};
    if (x > 10.0) {
        closed_coefficients(x, &c);
        return c;
    }
    series(x, &c);
    return c;
}

/* A += s [a]x */
static void add_skew(double s, const double a[3], double A[9])
{
    const double x = s * a[0], y = s * a[1], z = s * a[2];
    A[1] += z, A[2] -= y;
    A[3] -= z, A[5] += x;
    A[6] += y, A[7] -= x;
}

/* A += s ([a]x [b]x + [b]x [a]x) / 2 = s ((a b^T + b a^T) / 2 - (a.b) 1) */
static void add_square(double s, const double a[3], const double b[3], double A[9])
{
    const double h = 0.5 * s, xx = s * a[0] * b[0], yy = s * a[1] * b[1], zz = s * a[2] * b[2],
                 xy = h * (a[0] * b[1] + a[1] * b[0]), xz = h * (a[0] * b[2] + a[2] * b[0]),
                 yz = h * (a[1] * b[2] + a[2] * b[1]);
    A[0] -= yy + zz, A[1] += xy, A[2] += xz;
    A[3] += xy, A[4] -= xx + zz, A[5] += yz;
    A[6] += xz, A[7] += yz, A[8] -= xx + yy;
}

static void set_diagonal(double value, double A[9])
{
    for (int k = 0; k < 9; ++k) A[k] = k % 4 == 0 ? value : 0.0;
}

void mbsri_exp3(const mbsri_rotation_vector *c, double E[9])
{
    const double *p = c->p;
    set_diagonal(1.0, E);
    add_skew(c->sinc, p, E);
    add_square(c->alpha[0], p, p, E);
}

void mbsri_tangent3(const mbsri_rotation_vector *c, double T[9])
{
    const double *p = c->p;
    set_diagonal(1.0, T);
    add_skew(c->alpha[0], p, T);
    add_square(c->beta[0], p, p, T);
}

void mbsri_tangent3_along(const mbsri_rotation_vector *c, const double u[3], double dT[9])
{
    const double *p = c->p;
    const double x_u = 2.0 * mbsri_dot3(p, u);
    set_diagonal(0.0, dT);
    add_skew(c->alpha[1] * x_u, p, dT);
    add_skew(c->alpha[0], u, dT);
    add_square(c->beta[1] * x_u, p, p, dT);
    add_square(2.0 * c->beta[0], p, u, dT);
}

void mbsri_tangent3_twice(const mbsri_rotation_vector *c, const double u[3], const double v[3],
                          double ddT[9])
{
    const double *p = c->p;
    const double x_u = 2.0 * mbsri_dot3(p, u), x_v = 2.0 * mbsri_dot3(p, v),
                 x_uv = 2.0 * mbsri_dot3(u, v);
    set_diagonal(0.0, ddT);
    add_skew(c->alpha[2] * x_u * x_v + c->alpha[1] * x_uv, p, ddT);
    add_skew(c->alpha[1] * x_u, v, ddT);
    add_skew(c->alpha[1] * x_v, u, ddT);
    add_square(c->beta[2] * x_u * x_v + c->beta[1] * x_uv, p, p, ddT);
    add_square(2.0 * c->beta[1] * x_u, p, v, ddT);
    add_square(2.0 * c->beta[1] * x_v, p, u, ddT);
    add_square(2.0 * c->beta[0], u, v, ddT);
}
