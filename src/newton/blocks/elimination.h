/* A front: a dense matrix of which some unknowns are eliminated and the others are carried on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * M has a row and a column for each of `size` unknowns; its further rows and columns are what the
 * front hands on, and take part in what an elimination changes. */
#ifndef MBSRI_ELIMINATION_H
#define MBSRI_ELIMINATION_H

#include <stdbool.h>

/* What may become of a row or column: no pivot; a joint's with inertia; a direction without, that
 * loops may hold; a multiplier of a loop that closes. */
typedef enum mbsri_kind { MBSRI_WAITS, MBSRI_MASSIVE, MBSRI_HELD, MBSRI_CLOSES } mbsri_kind;

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

/* Rows and columns with inertia. row_scale holds what was added up in the rows; what is singular to
 * the rounding errors in that joins the directions that loops may hold. */
void mbsri_eliminate_massive(mbsri_elimination *e);

/* Multipliers and directions that they hold, as far as they can go; at most `delayed` of them are
 * left, or none where nothing waits. False: more would be, being singular. */
bool mbsri_eliminate_held(mbsri_elimination *e, int delayed);

#endif
