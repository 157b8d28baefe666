/* Random trees with loops, their dense equations of motion, and these solved by singular values.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   forward    [M -C^T; C 0] (u'; lambda) = (g; -bias) with the rigid rows; u' is unique where no
 *       motion is in
 *              the kernels of both M and C, lambda up to the kernel of C^T
 *   inverse    B tau + C^T lambda = need, of all tau that do this the shortest: tau = B^T x with C
 *       x = 0 */
#ifndef TEST_LOOPS_EQUATIONS_H
#define TEST_LOOPS_EQUATIONS_H

#include "loops.h"

#include "sweeps/loops.h"

#include <stdbool.h>

/* ---- random mechanisms ---- */

/* With massless bodies, redundant and stiff rows. In the plane of space many rows are redundant.
 * `light`: how many of ten bodies have no mass. */
void loops_make_random(loops *s, test_rng *rng, int bodies, int closures, bool plane, int light);

/* One of all kinds, by its seed, which rng goes on from; whether it is larger than the vectors. */
void loops_make_case(loops *s, test_rng *rng, uint64_t seed);
bool loops_too_large(const loops *s);

/* ---- dense equations ---- */

typedef struct loops_equations {
    int n, m, N;
    double M[LOOPS_MOST * LOOPS_MOST], C[LOOPS_MOST * LOOPS_MOST]; /* n x n, m x n: rigid rows */
    double g[LOOPS_MOST], bias[LOOPS_MOST];
    double x[2 * LOOPS_MOST]; /* u', lambda */
    bool clear;               /* whether each singular value is either large or rounding */
    bool moves;               /* whether some motion is in the kernel */
    double left;              /* of the right-hand side */
} loops_equations;

/* At the state of s. tau: joint forces or NULL. */
void loops_find_equations(const loops *s, loops_equations *e, const double *tau);

/* [P -C^T; C 0] x = (g; b) by singular values. */
void loops_solve(loops_equations *e, const double *P, const double *g, const double *b);

/* C^T lambda of the rigid rows, of the library and of these equations, of lambda with that sign. */
void loops_compare_forces(loops *s, const loops_equations *e, const double *lambda, double sign,
                          double size);

/* ---- the sweeps ---- */

/* Without its plan of loops a model is left to src/loops. */
mbsri_sweep_loops *loops_hide_plan(mbsr_model *m);
void loops_show_plan(mbsr_model *m, mbsri_sweep_loops *plan);

#endif
