/* Newton systems of closed models in vector code, by the front, and as the dense matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_NEWTON_WAYS_H
#define TEST_NEWTON_WAYS_H

#include "newton/carried/record.h"
#include "newton/sweeps/record.h"
#include "newton_system.h"

/* Of the momentum form. */
mbsr_newton *newton_solver(const mbsr_model *m, int by_blocks);

/* Factors at t = 0 and the state of `at`, and solves for r. */
void newton_solve(mbsr_newton *newton, const test_newton_state *at, double c, const double *r,
                  double *x);

/* By the front, all bodies in vector code, or by that which the pivots of a state ask for. */
typedef enum newton_sweeps { BY_FRONT, ONE_SWEEP, EITHER } newton_sweeps;

/* What a test looks at in the solver, after each solution in vector code. */
typedef void newton_look(const mbsr_newton *newton, int expected);

/* Solutions for several c at (q, u), u' = 0: the same both ways, up to what rounding makes of the
 * matrix, and those of the dense matrix. look: or NULL. */
void newton_both_ways(mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                      newton_sweeps sweeps, newton_look *look, int expected);

#endif
