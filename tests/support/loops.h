/* Mechanisms with closed loops, and their dense equations of motion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_LOOPS_H
#define TEST_LOOPS_H

#include "close.h"
#include "expect.h"

#include <mbsrank/mbsrank.h>

enum { LOOPS_MOST = 64 };

/* A model with data and a state. */
typedef struct loops {
    mbsr_model *m;
    mbsr_data *d;
    int nq, nu, rows, position_rows, size;
    double q[LOOPS_MOST], u[LOOPS_MOST], udot[LOOPS_MOST], lambda[LOOPS_MOST];
} loops;

/* An empty model with gravity (0, -9.81, 0); loops_finish makes the data. */
void loops_begin(loops *s, const mbsr_root *root);
void loops_finish(loops *s);
/* The same for one that is larger than the vectors here. */
void loops_build(loops *s);
void loops_free(loops *s);

/* A uniform rod along x in the plane, hinged at its end to (x, y) of the parent; mass may be zero.
 * Returns its id. */
int loops_rod(loops *s, const char *name, int parent, double x, double y, double mass,
              double length);

/* A pin between points of two bodies in the plane; returns its id. */
int loops_pin(loops *s, const char *name, int a, double ax, double ay, int b, double bx, double by);

/* A row of parallelograms on three legs, one behind the other: of each two rows are redundant. */
void loops_add_parallelograms(loops *s, int count);

/* mbsr_inverse_dynamics with motors at `count` rates, and the loop forces lambda that belong to it.
 */
int loops_inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                           const double *u, const double *udot, int count, const int *rate,
                           double *tau, double *lambda);

/* Newton's method on the gaps, least change of q (joints with q' = u). */
void loops_close(loops *s, double t);

/* C (rows x nu, column-major), g and C u + g_t, bias at (t, q, u). Any may be NULL. */
void loops_rows(loops *s, double t, const double *q, const double *u, double *C, double *g,
                double *rate, double *bias);

/* u' and lambda at the state of s, by the dense equations, least norm where they are not unique;
 * tau: joint forces or NULL. Returns the rank of these equations. */
int loops_accelerations(loops *s, double t, const double *tau);

/* Velocities consistent with the rows, with least change in the metric of the mass matrix. */
void loops_velocities(loops *s, double t);

/* y and y' of the momentum form for the state of s, with its udot and lambda; rigid rows. */
void loops_state(loops *s, double t, double *y, double *yp);

/* Any q and u, open or not; quaternions of length 1. */
void loops_random_state(loops *s, test_rng *rng);

#endif
