/* A front: a dense matrix of which some unknowns are eliminated and the others are carried on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * M has a row and a column for each of `size` unknowns; its further rows and columns are what the
 * front hands on, and take part in what an elimination changes. */
#ifndef MBSRI_ELIMINATION_H
#define MBSRI_ELIMINATION_H

#include <stdbool.h>

/* What may become of a row or column: no pivot; a direction without inertia, that loops may hold; a
 * multiplier of a loop that closes. */
typedef enum mbsri_kind { MBSRI_WAITS, MBSRI_HELD, MBSRI_CLOSES } mbsri_kind;

typedef struct mbsri_elimination {
    int size, rows, columns, done;
    double *M;                   /* rows x columns, in the order of the exchanges */
    int *row, *column;           /* size: numbers of the rows and columns before the exchanges */
    int *row_kind, *column_kind; /* by these numbers */
    double *row_scale, *column_scale;     /* likewise */
    const double *row_unit, *column_unit; /* likewise: sizes of multipliers, 0 for others */
} mbsri_elimination;

/* The numbers of rows and columns, none eliminated. */
void mbsri_elimination_begin(mbsri_elimination *e);

/* Multipliers and directions that they hold, as far as they can go; at most `delayed` of them are
 * left, or none where nothing waits. False: more would be, being singular. */
bool mbsri_eliminate_held(mbsri_elimination *e, int delayed);

#endif
