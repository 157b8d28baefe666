/* The rank of a joint block, and projections that belong to it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RANK_H
#define MBSRI_RANK_H

#include "algebra/twofold.h"
#include "recursion/group.h"
#include "recursion/rank_rule.h"

/* Returned where an eigenvalue is neither clearly zero nor known to nine digits: twofold precision
 * decides (exact.h). */
enum { MBSRI_UNCLEAR = 1 << 21 };

/* How a rank is decided: by eigenvalues where they are clear, by eigenvalues in any case, or, of
 * mounts, by pivots where these tell (rank_pivots.h), which is much less work and leaves no
 * eigenvalues. */
typedef enum mbsri_rank_way {
    MBSRI_RANK_CLEARLY,
    MBSRI_RANK_ROUGHLY,
    MBSRI_RANK_QUICKLY
} mbsri_rank_way;

/* Returned where pivots told. */
enum { MBSRI_BY_PIVOTS = 1 << 22 };

/* Eigen-decomposition, rank and pseudo-inverse of a group's block; the rank is shared out among its
 * joints. rough: decides in any case. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, bool rough);

/* The pieces. S = diag(J^T W J)^(-1/2), or the one that is kept, into d->s: the largest entry of
 * diag(J^T W J), and of S J^T W J S into *noise if that is larger than 1. */
double mbsri_equilibrate(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                         double *noise);

/* The S that is given for the joint block of a group, if it is: by its rates, from the first one's
 * place `ig` in vectors by groups. */
const double *mbsri_given_scale(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g);

/* The rank of a group shared out among its joints; A (n x n) is S D S and gets lost. */
void mbsri_share_rank(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, int rank,
                      double tolerance, mbsri_two *A);

/* The columns of X (n x m) orthonormal, spanning S^-1 N; entries that are nothing but rounding are
 * zero. */
void mbsri_null_columns(int n, int m, const double *s, const double *N, double *X);

/* After the decision: D = L L^T into L (n x n, its lower triangle). False where the rank is not
 * full, and for n < 2, where it gains nothing. */
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

/* y = projection of x, joint forces or momenta of a group, on what D cannot take up. For x = e it
 * is gamma. y and x may be the same. */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                      const double *x, double *y);

#endif
