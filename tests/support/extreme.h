/* Trees whose masses and lengths differ by many powers of ten, and their accelerations in long
 * double.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_EXTREME_H
#define TEST_EXTREME_H

#include <mbsrank/mbsrank.h>

#include <stdint.h>

enum { EXTREME_BODIES = 10, EXTREME_NU = 6 * EXTREME_BODIES, EXTREME_NQ = 7 * EXTREME_BODIES };

/* 2 to 10 boxes on joints of all kinds, masses from 1e-30 to 1e30 kg, lengths from 1e-9 to 1e9 m,
 * under gravity; a random state. */
typedef struct extreme {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    double q[EXTREME_NQ], u[EXTREME_NU];
} extreme;

void extreme_make(extreme *s, uint64_t seed);
void extreme_free(extreme *s);

/* u' (nu) by the stages' kinematics, masses and forces, for which the data is at mbsr_stage_forces,
 * and ranks that are full: the articulated-body algorithm in long double, corrected once. Returns
 * the largest correction, relative in the norm of mbsr_forward_dynamics_refined. */
double extreme_accelerations(const extreme *s, double *udot);

/* The largest of |x_i - y_i| / |y_i| over the joints i in that norm; the data is at
 * mbsr_stage_backward. */
double extreme_distance(const extreme *s, const double *x, const double *y);

#endif
