/* Symmetric sparse matrices: the lower triangle by columns.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_SPARSE_H
#define MBSRI_FE_SPARSE_H

#include "files/arena.h"

#include <mbsrank/fe.h>

/* Rows of a column ascend; the entry on the diagonal comes first and is there even if zero. */
typedef struct mbsri_sparse {
    int n;
    int *start, *row; /* n + 1; start[n] */
    double *value;
} mbsri_sparse;

/* Builds A of what the caller gave, checked: indices, numbers, symmetry. `name` for texts. */
int mbsri_sparse_build(mbsri_arena *arena, const char *name, const mbsr_fe_matrix *given,
                       mbsri_sparse *A, mbsr_error *error);

/* Y (n x c) = A X */
void mbsri_sparse_multiply(const mbsri_sparse *A, int c, const double *X, double *Y);

/* y = |A| |x| */
void mbsri_sparse_multiply_sizes(const mbsri_sparse *A, const double *x, double *y);

/* The matrix of the rows that have place[row] >= 0, at that place of `n`; false: no memory. */
bool mbsri_sparse_extract(mbsri_arena *arena, const mbsri_sparse *A, const int *place, int n,
                          mbsri_sparse *part);

#endif
