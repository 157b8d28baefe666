/* A small system of linear equations, scaled and factored in place.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BLOCK_H
#define MBSRI_BLOCK_H

#include <stdbool.h>

/* A (n x n) = rows^-1 L U columns^-1 with row exchanges. `rows` holds the size of what was added up
 * in each row, and then the scales. False where A is singular to the rounding errors in that. */
bool mbsri_block_factor(int n, double *A, double *rows, double *columns, int *pivots);

/* x (n) <- A^-1 x; work: n. */
void mbsri_block_solve(int n, const double *A, const double *rows, const double *columns,
                       const int *pivots, double *x);

#endif
