/* The rank of a joint block, and projections that belong to it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RANK_H
#define MBSRI_RANK_H

#include "recursion/data.h"

/* Eigen-decomposition, rank and pseudo-inverse of joint block i. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, int i);

/* After the decision: D = L L^T of body i into L (n x n, its lower triangle). False where the rank is
 * not full, and for n < 2, where it gains nothing. */
bool mbsri_definite_factor(const mbsri_body *b, const mbsr_data *d, int i, double *L);

/* MBSR_RANK_CHANGED if body i's rank is watched and another. */
int mbsri_rank_watched(const mbsr_model *m, mbsr_data *d, int i);

/* MBSR_UNDETERMINED, naming the first joint whose block is rank-deficient, or MBSR_OK. */
int mbsri_check_ranks(const mbsr_model *m, mbsr_data *d);

/* y = (I - D^+ D) x for body i: the part of a joint rate that D does not see. y and x may be the
 * same. */
void mbsri_null_part(const mbsr_model *m, const mbsr_data *d, int i, const double *x, double *y);

/* y = projection of x, a joint force or momentum of body i, on what D cannot take up. For x = e it
 * is gamma_i. y and x may be the same. */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, int i, const double *x, double *y);

#endif
