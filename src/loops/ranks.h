/* Which rows of closures are independent.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_RANKS_H
#define MBSRI_LOOPS_RANKS_H

#include "loops/ranking.h"
#include "loops/row_fronts.h"

#include <math.h>

static inline mbsri_ranks mbsri_no_ranks(void)
{
    return (mbsri_ranks){.smallest_kept = INFINITY, .weakest = -1, .weakest_pivot = INFINITY};
}

/* Rows of all closures over joint rates, and room for them. */
typedef struct mbsri_row_set {
    const mbsr_model *m;
    mbsr_data *d;
    int n, rows;      /* rates, rows of C */
    double dependent; /* squared distances below this are zero */
    const double *C;  /* rows x n */
    const double *
        span; /* n: of what joint rates move; rows are over rates in these, the same in all units */
    double *Q;         /* n x n: rows that are independent, made orthogonal */
    double *scale, *x; /* rows, n */
    double *left;      /* rows */
} mbsri_row_set;

/* Marks the rows of the set that depend on those before them, as mbsri_ranks_here does, in the
 * order of all rows, and adds to what was found. */
void mbsri_ranks_of(const mbsri_row_set *s, bool *dropped, mbsri_ranks *found);

/* The length to which each row is compared, into w->scale: the largest of its closure and
 * kind, a thousandth of the largest of its kind at least. Its own length would not do: where links
 * are stretched a row becomes small as a whole. After the derivatives. */
void mbsri_rank_scales(mbsri_ranking *w);

/* Of position rows that depend on each other rigid ones stay, then stiff ones that are not soft
 * beside others of their closure: the mechanism moves against soft ones. Into late (rows) as for
 * mbsri_row_fronts_order; scale (rows): to what rows are compared. */
void mbsri_late_rows(const mbsr_model *m, const double *scale, int *late);

/* Where rows of a closure depend on others its soft ones all do without, too. */
void mbsri_leave_soft(const mbsr_model *m, const int *late, bool *dropped);

/* Marks the rows that depend on those before them, position rows of all closures before the others;
 * of stiff rows those whose position row depends on the rigid ones and on stiff ones farther from
 * these. At the C of the workspace; uses its A and right. On fronts distances are those from all
 * others; where digits get lost on them the workspace goes on with matrices. Nonzero: of these
 * alone. */
int mbsri_ranks_here(mbsri_ranking *w, bool *dropped, mbsri_ranks *found);

/* The same without rows (rows flags; NULL: none) that are dropped from the beginning. */
int mbsri_ranks_without(mbsri_ranking *w, const bool *without, bool *dropped, mbsri_ranks *found);

/* The same for the position q (closed) and for positions nearby, into `dropped` what holds where
 * most rows are independent; *nearby: how many. Rows that depend on others at q alone open beside
 * it, to the second order, where these others are closed: then it is singular, and what counts is a
 * closed position nearby that is not, or, where none is found, that position beside it. The data is
 * left at the positions q. */
int mbsri_ranks_around(mbsri_ranking *w, double t, const double *q, bool *dropped,
                       mbsri_ranks *here, int *nearby);

#endif
