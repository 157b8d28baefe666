/* The rank of a joint block, and projections that belong to it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RANK_H
#define MBSRI_RANK_H

#include "recursion/group.h"

/* Eigen-decomposition, rank and pseudo-inverse of a group's block; the rank is shared out among its
 * joints. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, const mbsri_group *g);

/* After the decision: D = L L^T into L (n x n, its lower triangle). False where the rank is not full,
 * and for n < 2, where it gains nothing. */
bool mbsri_definite_factor(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                           double *L);

/* MBSR_RANK_CHANGED if the rank of the group of head i is watched and another. */
int mbsri_rank_watched(const mbsr_model *m, mbsr_data *d, int i);

/* MBSR_UNDETERMINED, naming the first joint that lacks rank, or MBSR_OK. */
int mbsri_check_ranks(const mbsr_model *m, mbsr_data *d);

/* y = (I - D^+ D) x for a group: the part of joint rates that D does not see. y and x may be the
 * same. */
void mbsri_null_part(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, const double *x,
                     double *y);

/* y = projection of x, joint forces or momenta of a group, on what D cannot take up. For x = e it is
 * gamma. y and x may be the same. */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                      const double *x, double *y);

#endif
