/* The rotation exp([p]x) of a rotation vector p, and T of exp([p]x)' = [T p']x exp([p]x).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   exp([p]x) = 1 + sin(t)/t [p]x + alpha [p]x^2,     T = 1 + alpha [p]x + beta [p]x^2,   t = |p|
 *   alpha = (1 - cos t) / t^2,   beta = (t - sin t) / t^3 */
#ifndef MBSRI_ROTATION_VECTOR_H
#define MBSRI_ROTATION_VECTOR_H

/* p, and the coefficients with their first two derivatives by t^2. */
typedef struct mbsri_rotation_vector {
    double p[3], sinc, alpha[3], beta[3];
} mbsri_rotation_vector;

mbsri_rotation_vector mbsri_rotation_vector_of(const double p[3]);

void mbsri_exp3(const mbsri_rotation_vector *r, double E[9]);

/* T, its derivative along u, and the second one along u and v. */
void mbsri_tangent3(const mbsri_rotation_vector *r, double T[9]);
void mbsri_tangent3_along(const mbsri_rotation_vector *r, const double u[3], double dT[9]);
void mbsri_tangent3_twice(const mbsri_rotation_vector *r, const double u[3], const double v[3],
                          double ddT[9]);

#endif
