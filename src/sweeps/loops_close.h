/* Loops that close where the parts that carry them meet: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Parts are those at body i; a group of them, which have unknowns in common, is chained from `head`
 * on. What a group leaves goes to `to`, its unknowns from place `base` on. */
#ifndef MBSRI_LOOPS_CLOSE_H
#define MBSRI_LOOPS_CLOSE_H

#include "sweeps/loops.h"

/* Nothing in what loops add to the inertia of the body. */
void mbsri_loops_clear_sums(mbsri_loop_run *w);

/* Where all that meets at body i is rows, the same ones, which close there and are plainly
 * independent, the pivots come as they are. False: they do not, and nothing is changed. */
bool mbsri_loops_close_alone(mbsri_loop_run *w, const mbsri_open_part *part, int count, int i);

/* A group whose first `complete` unknowns, of `size` in `set`, may go; false: some of them cannot,
 * or nothing determines one. */
bool mbsri_loops_close_group(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                             const int *set, int size, int complete, const mbsri_open *to,
                             int base);

/* The same of rows alone that are plainly independent. False: they are not, and nothing is changed.
 */
bool mbsri_loops_close_plainly(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                               const int *set, int size, int complete, const mbsri_open *to,
                               int base);

#endif
