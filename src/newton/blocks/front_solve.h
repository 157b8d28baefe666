/* Solving with fronts, beside the steps of solve.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_SOLVE_H
#define MBSRI_FRONT_SOLVE_H

#include "newton/blocks/carried.h"

/* Before all: r of the rows of closures (NULL: zero), by the caller's order. */
void mbsri_front_load(mbsr_newton *w, const double *r);

/* Leaves to root. Joint i, or the group of that head: `own` are the right-hand sides
 * of its equations, q0 = Cq r_q. Then loops that close on a body; those of one front, b: of a body in
 * vector code. */
void mbsri_front_reduce(mbsr_newton *w, int i, double *own, const double *q0);
void mbsri_front_reduce_closing(mbsr_newton *w, int body);
void mbsri_front_reduce_one(mbsr_newton *w, int k, double *b);

/* Root to leaves, likewise. What of the joint's dq, d(M u) and dp' is that of the multipliers is
 * added to q, momentum, rate. x: of a body in vector code. */
void mbsri_front_substitute(mbsr_newton *w, int i);
void mbsri_front_substitute_closing(mbsr_newton *w, int body);
void mbsri_front_substitute_one(mbsr_newton *w, int k, const double *x);
void mbsri_front_apply(const mbsr_newton *w, int i, double *q, double *momentum, double *rate);

/* After all: the multipliers' part of delta. */
void mbsri_front_multipliers(const mbsr_newton *w, const double *r, double *delta);

#endif
