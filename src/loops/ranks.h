/* Which rows of closures are independent.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_RANKS_H
#define MBSRI_LOOPS_RANKS_H

#include "loops/dense.h"

/* What was found of the rows in one position. */
typedef struct mbsri_ranks {
    int independent; /* rigid rows */
    int springs; /* position rows of stiff ones that depend neither on rigid ones nor on each other */
    double smallest_kept, largest_dropped;
    int weakest; /* of the rows that the data does not leave out, the one with the smallest pivot */
    double weakest_pivot;
} mbsri_ranks;

/* The length to which each row is compared, into `scale` (rows): the largest of its closure and kind, a
 * thousandth of the largest of its kind at least. Its own length would not do: where links are stretched
 * a row becomes small as a whole. */
void mbsri_rank_scales(const mbsri_dense *w, double *scale);

/* Marks the rows that depend on those before them, position rows of all closures before the others; of
 * stiff rows those whose position row depends on the rigid ones and stiff ones before it. At the C of the
 * workspace; uses its A and right. */
void mbsri_ranks_here(mbsri_dense *w, bool *dropped, mbsri_ranks *found);

/* The same for the position q (closed) and two nearby, into `dropped` what holds where most rows are
 * independent; *nearby: how many. The data is left at the positions q. */
int mbsri_ranks_around(mbsri_dense *w, double t, const double *q, bool *dropped, mbsri_ranks *here,
                       int *nearby);

#endif
