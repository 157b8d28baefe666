/* What the equations of loops refuse, by name.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_REFUSE_H
#define MBSRI_LOOPS_REFUSE_H

#include "recursion/data.h"

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
