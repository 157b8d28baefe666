/* Loop forces that move nothing, where rows are redundant.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A row that nothing is left of in its front depends on others: with lambda = 1 there, the way back
 * to the leaves gives those of the others, C^T lambda = 0. Taken out of solutions, these vectors
 * leave the least norm, of moments and of forces times the model's length: first over the rows of
 * closures that meet at the root, then of the others by the bodies where these meet, as vector code
 * has it, which sees one meeting after the other. The vectors are sparse, and only what overlaps is
 * looked at. */
#ifndef MBSRI_FRONTS_IDLE_H
#define MBSRI_FRONTS_IDLE_H

#include "fronts/fronts.h"

/* After all fronts have been eliminated; false: no memory. */
bool mbsri_idle_find(mbsri_fronts *w);

/* Marks rows that depend on others, of those that are redundant together the one with the greatest
 * place in `order` (rows; in one place: the one with most part in it), and those whose forces such
 * vectors have (`shared`). Only after mbsri_idle_find; takes memory for the factors: false where
 * there is none. */
bool mbsri_idle_rows(mbsri_fronts *w, const int *order, bool *dependent, bool *shared);

/* Takes them out of lambda (rows). */
void mbsri_idle_leave_out(const mbsri_fronts *w, double *lambda);

#endif
