/* Rotation vectors and the moments of springs that act on them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * theta with |theta| <= pi, R = exp [theta]x, and the angular velocity omega = J(theta) theta'
 * along the axes that R turns away from. The energy 1/2 sum of c theta^2 makes the moment -J^-T (c
 * theta),
 *
 *   J^-T(theta) = 1 + [theta]x / 2 + s [theta]x^2,
 *       s = (1 - |theta|/2 cot |theta|/2) / |theta|^2 */
#ifndef MBSRI_ROTATION_H
#define MBSRI_ROTATION_H

#include <stdbool.h>

/* s of |theta|^2, and its derivative (slope may be NULL). */
double mbsri_turn_factor(double square, double *slope);

/* theta of a quaternion of any length whose square neither overflows nor vanishes. */
void mbsri_quaternion_vector(const double quaternion[4], double theta[3]);

/* Whether this quaternion's angle is pi but for rounding, so that theta may as well be -theta, and
 * the entries of theta that count are not zero: those with stiffness (3). */
bool mbsri_turn_is_half(const double quaternion[4], const double theta[3], const double *stiffness);

/* For mbsr_force_table.side: another number where theta jumps, and where it grows beyond a quarter
 * of a turn or its largest entry becomes another one. */
double mbsri_turn_side(const double theta[3]);

/* y = J^-T(theta) x; they may be the same. */
void mbsri_unturn(const double theta[3], const double x[3], double y[3]);

/* T (3 x 3): derivative of J^-T (c theta) for a small rotation phi that follows R, along the axes
 * of omega, for which dtheta = J^-1 phi = (J^-T(-theta)) phi. */
void mbsri_turning_stiffness(const double theta[3], const double *stiffness, double T[9]);

#endif
