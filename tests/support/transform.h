/* Homogeneous transforms in space, written without the library: 4 x 4, row by row, rotations by the
 * series of the matrix exponential and by products of quaternions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_TRANSFORM_H
#define TEST_TRANSFORM_H

#include <mbsrank/joint.h>

#include <math.h>

typedef struct transform {
    double m[4][4];
} transform;

static inline transform transform_unit(void)
{
    return (transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

static inline transform transform_product(transform a, transform b)
{
    transform c = {{{0}}};
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            for (int k = 0; k < 4; ++k) c.m[i][j] += a.m[i][k] * b.m[k][j];
        }
    }
    return c;
}

/* Inverse of a rotation and shift. */
static inline transform transform_inverse(transform a)
{
    transform c = transform_unit();
    for (int i = 0; i < 3; ++i) {
        c.m[i][3] = 0.0;
        for (int k = 0; k < 3; ++k) {
            c.m[i][k] = a.m[k][i];
            c.m[i][3] -= a.m[k][i] * a.m[k][3];
        }
    }
    return c;
}

/* exp([w]x v; 0 0): a rotation by |w| about w, a shift by v, a screw. Taylor's series of a 1/1024
 * of it, squared ten times; the parts beyond the unit matrix are what is carried. */
static inline transform transform_exp(const double w[3], const double v[3])
{
    transform x = {{{0, -w[2], w[1], v[0]}, {w[2], 0, -w[0], v[1]}, {-w[1], w[0], 0, v[2]}}};
    transform sum = {{{0}}}, term = transform_unit();
    for (int n = 1; n <= 9; ++n) {
        term = transform_product(term, x);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 4; ++j) {
                term.m[i][j] /= 1024.0 * n;
                sum.m[i][j] += term.m[i][j];
            }
        }
    }
    for (int n = 0; n < 10; ++n) { /* (1 + s)^2 - 1 = 2 s + s^2 */
        const transform square = transform_product(sum, sum);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 4; ++j) sum.m[i][j] = 2.0 * sum.m[i][j] + square.m[i][j];
        }
    }
    for (int i = 0; i < 4; ++i) sum.m[i][i] += 1.0;
    return sum;
}

/* (w, x, y, z) */
static inline void quaternion_product(const double a[4], const double b[4], double c[4])
{
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3];
    c[3] = a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1];
}

/* The columns are q e q* / |q|^2 for the three units e. */
static inline transform transform_quaternion(const double q[4])
{
    const double conjugate[4] = {q[0], -q[1], -q[2], -q[3]};
    const double size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    transform t = transform_unit();
    for (int k = 0; k < 3; ++k) {
        double e[4] = {0.0, k == 0, k == 1, k == 2}, left[4], image[4];
        quaternion_product(q, e, left);
        quaternion_product(left, conjugate, image);
        for (int i = 0; i < 3; ++i) t.m[i][k] = image[1 + i] / size;
    }
    return t;
}

/* From and to R (by columns) and x. */
static inline transform transform_of(const double R[9], const double x[3])
{
    transform t = transform_unit();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) t.m[i][j] = R[3 * j + i];
        t.m[i][3] = x[i];
    }
    return t;
}

static inline void transform_pose(const transform *t, double p[MBSR_POSE_SIZE])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) p[3 * j + i] = t->m[i][j];
        p[MBSR_POSE_X + i] = t->m[i][3];
    }
}

/* Where a body or root in this space stands. */
static inline transform transform_of_body(mbsr_space space, const double *p)
{
    if (space == MBSR_SPACE_SPATIAL) return transform_of(p + MBSR_POSE_R, p + MBSR_POSE_X);
    if (space == MBSR_SPACE_FIXED) return transform_unit();
    const double w[3] = {0, 0, space == MBSR_SPACE_PLANAR ? p[2] : 0.0}, none[3] = {0, 0, 0};
    transform t = transform_exp(w, none);
    t.m[0][3] = p[0];
    t.m[1][3] = p[1];
    return t;
}

/* From T and T' the twist (omega, v); from T and T'' its rate: skew(R'' R^T) = [omega']x, because
 * what else R'' R^T holds, [omega]x squared, is symmetric. */
static inline void transform_twist(const transform *at, const transform *rate, double V[6])
{
    double W[3][3] = {{0}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) W[i][j] += rate->m[i][k] * at->m[j][k];
        }
        V[3 + i] = rate->m[i][3];
    }
    V[0] = 0.5 * (W[2][1] - W[1][2]);
    V[1] = 0.5 * (W[0][2] - W[2][0]);
    V[2] = 0.5 * (W[1][0] - W[0][1]);
}

#endif
