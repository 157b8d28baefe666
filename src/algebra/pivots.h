/* Symmetric elimination in a small dense matrix, of which only part is complete.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   [F Q^T; Q 0]     the first `complete` rows and columns may be pivots, one by one or in pairs
 *                    (Bunch and Parlett's complete pivoting)
 *
 * `sizes` has what was added up in each number, beside which it may be nothing. */
#ifndef MBSRI_PIVOTS_H
#define MBSRI_PIVOTS_H

#include <stdbool.h>
#include <stddef.h>

/* Numbers smaller than this beside what was added up in them are zero. */
#define MBSRI_PIVOTS_ROUNDING 1e-13

typedef struct mbsri_pivots {
    int size, complete, d; /* unknowns; complete ones, which come first; accelerations behind all */
    int pivots;            /* unknowns eliminated, which come first then */
    int left;              /* unknowns behind them without a pivot: zero, but for `idle` */
    int *id;               /* size: the unknowns, as eliminated */
    double *A;      /* (size + d) squared: L below the diagonal of the first `pivots` columns */
    double *sizes;  /* (size + d) squared: size of what was added up in each number of A */
    double *across; /* pivots: entry beside the diagonal of a pair, at its first; else zero */
    double *scale;  /* size: scale of each unknown in the choice of pivots */
    double *value;  /* size: scratch */
    int shared;     /* ids below this have a part in norms of solutions: */
    const double *share; /* by id, what one of the unknown counts there, or 0: as 1 */
    int idles;
    double *idle; /* size x idles: solutions without right-hand side, orthonormal in these */
    struct mbsri_pivots *next;
} mbsri_pivots;

/* What a row that turns and moves its body by these counts as: a force by the moment that it has at
 * a lever of `length`. *share: so far, of its other bodies. */
static inline void mbsri_share(double turn, double move, double length, double *share)
{
    const double size = move > 0.0 ? length * move : turn;
    if (size > *share) *share = size;
}

/* Eliminates; the arrays are there, with id, A and sizes. What was complete and could not be a
 * pivot stands behind the pivots: `left` of them have nothing left, the others go on with those
 * that were not complete. */
void mbsri_pivots_eliminate(mbsri_pivots *f);

/* Solutions without right-hand side for those left of which `wanted` says so; idle has room for
 * `left` of them. */
void mbsri_pivots_find_idle(mbsri_pivots *f, const bool *wanted);

/* s (by id) less what the pivots take of it, and the loads that they make (d); then v (by id) of
 * the pivots and those left, where the others and a (d) are known. */
void mbsri_pivots_forward(const mbsri_pivots *f, double *s, double *fbar);
void mbsri_pivots_backward(const mbsri_pivots *f, const double *s, const double *a, double *v);

#endif
