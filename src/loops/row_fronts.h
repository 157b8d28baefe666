/* Which rows of closures are independent, front by front: for models of any size.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Loop forces that move nothing, C^T y = 0, are found by eliminating the equations of a tree whose
 * only inertias are those of joint rates in their spans. Of the rows that depend on each other the
 * last ones do without. With the others, the diagonal of (C W C^T)^-1 tells how far each is from
 * the span of the rest. */
#ifndef MBSRI_LOOPS_ROW_FRONTS_H
#define MBSRI_LOOPS_ROW_FRONTS_H

#include "fronts/fronts.h"

/* Squared distances below this are zero [choice]. */
#define MBSRI_DEPENDENT 1e-10

/* What was found of the rows in one position. */
typedef struct mbsri_ranks {
    int independent; /* rigid rows */
    int springs; /* position rows of stiff ones that depend neither on rigid ones nor on each other
                  */
    double smallest_kept, largest_dropped;
    int weakest; /* of the rows that the data does not leave out, the one with the smallest pivot */
    double weakest_pivot;
} mbsri_ranks;

typedef struct mbsri_row_fronts mbsri_row_fronts;

/* Of a model without stiff rows; span (nu): of what joint rates move. Memory from the model's
 * allocator. */
int mbsri_row_fronts_open(const mbsr_model *m, mbsr_data *d, const double *span,
                          const char *function, mbsri_row_fronts **fronts);
void mbsri_row_fronts_close(mbsri_row_fronts *w);

/* As mbsri_ranks_here, but that distances are those from the span of all others that are kept.
 * After the derivatives. without (rows; NULL: none): rows that are dropped from the beginning. near
 * (rows; NULL: nothing is known): those that were dropped in a position nearby: one begins with
 * them, and takes back what does not depend on others here. MBSR_LOOP_SINGULAR: digits get lost,
 * rows that were dropped are not in the span of those kept, or these depend on each other; statuses
 * of mbsri_fronts_factor. */
int mbsri_row_fronts_rank(mbsri_row_fronts *w, const bool *without, const bool *near, bool *dropped,
                          mbsri_ranks *found);

/* Rows on which others depend, and these: their forces are not determined one by one. After the
 * ranks without `near`. */
const bool *mbsri_row_fronts_shared(const mbsri_row_fronts *w);

/* The part of x (nu, in spans) that the rows kept allow; after the ranks, at their position. */
void mbsri_row_fronts_allow(mbsri_row_fronts *w, double *x);

/* Of position rows that depend on each other those with the greatest number in `late` are dropped
 * first (rows, from 0 on; NULL: all alike); before them velocity rows, which count as the last. */
enum { MBSRI_LATEST = 5 };
void mbsri_row_fronts_order(mbsri_row_fronts *w, const int *late);

/* Loop forces lambda (rows) become those of the same effect, C^T lambda, of which stiff rows share
 * by their compliance what they bear: the sum of lambda^2 / stiffness is least. stiffness (rows; 0:
 * rigid); left_out (rows): those that bear nothing. After the derivatives. */
int mbsri_row_fronts_share(mbsri_row_fronts *w, const double *stiffness, const bool *left_out,
                           double *lambda);

/* The length to which each row is compared (rows). After the derivatives. */
const double *mbsri_row_fronts_scales(mbsri_row_fronts *w);

/* Of loop forces lambda (rows), found with doubts (rows), those become zero that are rounding of
 * the others and of what acts (load), by the work of each along its row, or no more than solving
 * them is in doubt: they would stiffen directions along which nothing holds. After the derivatives.
 */
void mbsri_row_fronts_clear_traces(mbsri_row_fronts *w, double load, const double *doubt,
                                   double *lambda);

bool mbsri_any_stiff(const mbsr_model *m);

#endif
