/* The rank of a joint block without its eigenvalues.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RANK_PIVOTS_H
#define MBSRI_RANK_PIVOTS_H

#include "recursion/group.h"

/* As mbsri_rank_decision (rank.h) of a joint that is a group of its own, where Cholesky's pivots
 * tell the rank; else false, and nothing that counts is written. The rank and D^+ are the same. Of
 * X the columns that are dropped are as there; those that are kept are any with S X X^T S = lambda
 * D^-, where D D^- D = D, and all lambda of these are one bound of the eigenvalues. judged is not
 * written.
 *
 * reads D, J, W;  writes s, X, lambda, Dinv, scale, rank.  cost: n^3 / 2. */
bool mbsri_rank_by_pivots(const mbsr_model *m, mbsr_data *d, const mbsri_group *g);

#endif
