/* A consistent start of a model with closures, on the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_TREE_START_H
#define MBSRI_LOOPS_TREE_START_H

#include "recursion/data.h"

#include <mbsrank/dae.h>

/* As mbsri_loops_dense_start, in O(bodies + local loops), for rigid rows. The gaps become `offset`
 * (held; NULL: zero). *served: false where loops do not close or no state is found; the data's
 * error is as it was then, q and u are not. Takes memory from the model's allocator. */
int mbsri_loops_tree_start(const mbsr_model *m, mbsr_data *d, double t, const double *offset,
                           double *q, double *u, double *udot, double *lambda,
                           const mbsr_consistent_opt *opt, mbsr_consistent_info *info,
                           bool *served);

/* The same with stiff rows, by a copy of the model in which they are rigid (stiff_tree_start.c).
 * Not served where a start takes springs as they are, or springs share a force among rows that
 * depend on each other. */
int mbsri_stiff_tree_start(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                           double *udot, double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info, bool *served);

#endif
