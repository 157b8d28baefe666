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

/* Of position rows that depend on each other rigid ones stay, then stiff ones that are not soft
 * beside others of their closure: the mechanism moves against soft ones. Into late (rows) as for
 * mbsri_row_fronts_order; scale (rows): to what rows are compared. */
void mbsri_late_rows(const mbsr_model *m, const double *scale, int *late);

/* Where rows of a closure depend on others its soft ones all do without, too. */
void mbsri_leave_soft(const mbsr_model *m, const int *late, bool *dropped);

/* Marks the rows that depend on those before them, position rows of all closures before the others;
 * of stiff rows those whose position row depends on the rigid ones and on stiff ones farther from
 * these. After the derivatives of the closures; distances are those from all others. Statuses of
 * mbsri_row_fronts_rank. */
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
