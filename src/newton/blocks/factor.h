/* The elimination by blocks, for any kind of body.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FACTOR_H
#define MBSRI_FACTOR_H

#include "newton/blocks/joint.h"
#include "recursion/group.h"

/* Doubles of w->work for the largest joint. */
size_t mbsri_tree_work(const mbsr_newton *w);

/* The elimination at the state (t, y), with the loop forces of y', for the factor c. */
int mbsri_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *y, const double *yp,
                      double c);

/* Its step for joint i, whose successors are done: what it hands to its predecessor is added to
 * that one's matrix. The data has all of the body that mbsri_tree_factor prepares, w->node its rank
 * and whether it and its predecessor are deep. A status. */
int mbsri_tree_eliminate(mbsr_newton *w, mbsr_data *d, int i, double c);

/* The matrix of body i <- 0. */
void mbsri_tree_clear(const mbsr_newton *w, int i);

/* What w->node says of a joint at a factorisation. */
void mbsri_tree_mark(mbsr_newton *w, int i, int rank);

/* The same of a group that is eliminated in one piece. */
void mbsri_tree_mark_coupled(mbsr_newton *w, const mbsri_group *g, int rank);

#endif
