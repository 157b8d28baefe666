/* What springs and dampers see of the directions that move no mass, one number each.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A damper exerts -d l (l^T V) on what it acts on, V the twists and joint rates there, and so of
 * most elements the derivatives are sums of such products,
 *
 *   F_V = sum_r s_r l_r l_r^T,    F_x = sum_r s_r l_r l_r^T.
 *
 * Along the directions a_l, with V = W a, C is then B^T diag(s) B, B_rl = l_r^T W a_l, and where
 * all signs are the same a direction is in the null space of C if and only if no row of B sees it.
 * So it does not count how strong an element is, nor how little is left of it beside others in C:
 * rows are of length one. */
#ifndef MBSRI_ELEMENT_ROWS_H
#define MBSRI_ELEMENT_ROWS_H

#include "massless/null_space.h"

/* Of one factor l: what it sees of `count` directions, from `first` of w->element.entries on. */
typedef struct mbsri_row {
    int element; /* number of the force element */
    bool velocity;
    double slope; /* the derivatives are this times l l^T */
    size_t first;
    int count;
} mbsri_row;

typedef struct mbsri_row_entry {
    int direction;
    double value, error;
} mbsri_row_entry;

/* Adds the rows of the element whose derivatives are in w->element.slope, for `moving` directions
 * w->element.moving: to its velocities, or positions. Where the derivatives are no such sum, or
 * where an element sees coordinates that are no rates, these directions are noted in
 * w->element.dense. */
int mbsri_element_rows(mbsri_null_space *w, int number, int moving, bool velocity);

/* Whether C (velocity) or S of these directions is made of rows alone, all of one sign. */
bool mbsri_rows_serve(const mbsri_null_space *w, int count, const int *direction, bool velocity);

/* How many rows there are that see some of these directions, and B^T (count x rows), column-major,
 * with its errors, where B is not NULL. */
int mbsri_rows_gather(const mbsri_null_space *w, int count, const int *direction, bool velocity,
                      double *B, double *error);

#endif
