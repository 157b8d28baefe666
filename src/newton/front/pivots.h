/* Pivots of a front.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * M has the same number of unknowns and equations in front, `size`, and behind them rows and
 * columns that take part in what an elimination changes. N has, for the unknowns and equations, the
 * sum of the sizes of what was added up in each entry; where the front is watched, beyond them too,
 * and where it lacks mass, in the border as well. Both have columns of `stride` numbers. */
#ifndef MBSRI_FRONT_PIVOTS_H
#define MBSRI_FRONT_PIVOTS_H

#include <stdbool.h>

typedef struct mbsri_front_pivots {
    int size, rows, columns, stride, done;
    bool watched;    /* something may be left: what cancels is to be zero */
    bool lacks_mass; /* and in the border: elements alone determine some rates */
    int delayed;     /* how many unknowns may be left that are not pending, */
    bool scarce;     /* and whether others need that room, too */
    double *M, *N;
    int *row, *column;                           /* numbers, exchanged along */
    const unsigned char *row_kind, *column_kind; /* mbsri_front_kind, by number */
    double *row_scale, *column_scale, *largest;  /* scratch: rows, columns, rows */
} mbsri_front_pivots;

/* Eliminates what has a good pivot, where room is scarce a fair one; beyond that, until at most
 * `delayed` unknowns that are not pending are left, what has any pivot that is not rounding. False:
 * more are left than that. */
bool mbsri_front_eliminate(mbsri_front_pivots *p);

#endif
