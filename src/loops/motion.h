/* Accelerations and loop forces that closures allow, at a position.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_MOTION_H
#define MBSRI_LOOPS_MOTION_H

#include "loops/dense.h"

/* The rows that K does without, into left_out: those that the data leaves out, and springs that a
 * start takes as they are; or all springs. */
void mbsri_loops_leave_out(mbsri_dense *w, bool springs);

/* K at (t, q, u), which the data then has. */
int mbsri_loops_factor(mbsri_dense *w, double t, const double *q, const double *u);

/* K (u'; lambda) = (-h; -bias), K factored; lambda is zero in rows that K does not have. */
int mbsri_loops_rates(mbsri_dense *w, double t, const double *q, const double *u, const double *tau,
                      double *udot, double *lambda);

/* Forces of the springs that K does not have as rows, into their rows of lambda. */
int mbsri_loops_springs(mbsri_dense *w, double t, const double *q, const double *u, double *lambda);

/* MBSR_UNDETERMINED, with the name of the joint that joint rate `rate` (place in u) belongs to. */
int mbsri_refuse_motion(const mbsr_model *m, mbsr_data *d, int rate, const char *function,
                        const char *why);

/* The largest of rows x (rows) over their lengths (0: 1). */
double mbsri_largest_row(const mbsr_model *m, const double *x, const double *length);

/* MBSR_LOOP_OPEN where more is left of rows (rows) than rounding, although the equations are
 * solved: they contradict each other. length: likewise; size: the largest of what was added up in a
 * row, over its length. */
int mbsri_refuse_left(const mbsr_model *m, mbsr_data *d, const double *left, const double *length,
                      double size, const char *what, const char *function);

#endif
