/* Forward and inverse dynamics of models with closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_FORWARD_H
#define MBSRI_LOOPS_FORWARD_H

#include "recursion/data.h"

#include <mbsrank/dynamics.h>

/* mbsr_forward_dynamics; the data is left at the forces, with loop forces and accelerations.
 * left_out (rows; NULL: none): rows without a part in the equations, beside springs. */
int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, const bool *left_out, double *udot,
                        const char *function);

/* Changes u (nu) by impulses of the loops, so that the closures allow it; left_out: likewise.
 * MBSR_UNDETERMINED where a motion that moves no mass is free, MBSR_LOOP_OPEN where rows, those
 * left out among them, contradict each other. */
int mbsri_loops_push(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                     const bool *left_out, double *u, const char *function);

/* Loop forces lambda (rows) where stiff rows count as rigid but for those of left_out (rows), which
 * are springs; those are zero. doubt (rows): what a refinement has changed them by. Where motions
 * are not determined what acts along them is left. *load: the largest of what acts along span (nu),
 * before anything cancels. */
int mbsri_loops_settled(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const bool *left_out, const double *span, double *lambda,
                        double *doubt, double *load, const char *function);

/* Forces of springs at (t, q, u), into their rows of lambda (rows); those (rows; NULL: all): of
 * which. */
int mbsri_loops_take_springs(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                             const double *u, const bool *those, double *lambda);

/* How many directions without mass no loop holds, at the positions and velocities of the data.
 * left_out: likewise; if `settled` stiff rows count as rigid but for those of left_out. */
int mbsri_loops_count_free(const mbsr_model *m, mbsr_data *d, const bool *left_out, bool settled,
                           const char *function, int *count);

/* Torques tau (nu) of the joint rates that have motors, and loop forces, left in the data, that
 * together are `need` (nu); after the inverse dynamics of the tree. Both are as they were after a
 * failure. */
int mbsri_loops_actuate(const mbsr_model *m, mbsr_data *d, const mbsr_motors *motors,
                        const double *need, double *tau, const char *function);

#endif
