/* Equations of motion with loops, solved along the tree in O(bodies + loops).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   M x - C^T lambda = g,    C x = b          with the rows of C that are not left out
 *
 * by the articulated-body algorithm: the motions x of joints are eliminated from the leaves to the root. A body
 * passes on, beside its articulated inertia, what is still unknown of the loops behind it: v, that is lambda
 * of the loops that are open past its joint and the joint motions behind it that move no mass. For every body
 *
 *   reaction   mu = fbar + Q v - Mbar a            row of v   F v + Q^T a = s
 *
 * with the accelerations a = -(H a_pred + J x), beside those that x = 0 leaves. A joint gives
 *
 *   x = D^+ (e - U^T H a_pred - X v) + N w,   X = J^T Q - E,    Q_pred = -H^T (Q - G X),  F += X^T D^+ X,
 *
 * where E is what the rows read of x itself and N spans the null space of D: w joins v, its row says that
 * forces along N balance, -N^T X v = -N^T e. Where a loop closes its lambda are eliminated by symmetric pivots
 * (pivots.h) together with w, and their inertia is added to Mbar.
 *
 * What turns out to be zero but for rounding is left out: rows that depend on others, of which the least
 * norm is taken closing by closing, of moments and of forces times the model's length; and motions that nothing
 * determines (`free`). */
#ifndef MBSRI_LOOPS_SYSTEM_H
#define MBSRI_LOOPS_SYSTEM_H

#include "loops/waiting.h"

/* At the positions of the data, after the derivatives of the closures. Overwrites Mbar, D and what
 * belongs to them. `armature`: as above. */
int mbsri_system_factor(mbsri_system *w, const double *armature, const char *function);

/* x (nu, by the caller's order) and lambda (rows, zero in those left out), from g (nu, likewise) and b (rows). */
void mbsri_system_solve(mbsri_system *w, const double *g, const double *b, double *x,
                        double *lambda);

/* The steps of the way back, on w's own v, a, e and s: the rates of joint i to their place in e, which has what is
 * left of g, from a of the predecessor and v of the loops (work: n); then a of the body, and v of what closes there. */
void mbsri_system_rates(mbsri_system *w, int i, double *work);
void mbsri_system_move(mbsri_system *w, int i);

/* The joint rate (place in the caller's u) that has most of a motion that nothing determines; `free` is not -1. */
int mbsri_system_free_rate(const mbsri_system *w);

#endif
