/* The rank of a joint block that is known in twofold precision.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_EXACT_RANK_H
#define MBSRI_EXACT_RANK_H

#include "recursion/rank.h"

/* D of a group by pivots: D = L L^T with a column of L (n x n) a pivot, in the order of the pivots
 * (the first `pivots` of `order`); the rest of D is nothing but rounding, or indefinite. */
typedef struct mbsri_exact_factor {
    int pivots, *order;
    mbsri_two *L;
    double left; /* smallest diagonal entry of the rest, in units of its errors */
} mbsri_exact_factor;

/* Rank and eigenvalues of D (n x n, twofold), as mbsri_rank_decision. reads D, W, unsure, J; writes
 * s, X, lambda, scale, rank. work: 2 n^2 + 2 n twofold. */
int mbsri_exact_decision(const mbsr_model *m, mbsr_data *d, const mbsri_group *g,
                         const mbsri_two *D, mbsri_exact_factor *factor, mbsri_two *work);

#endif
