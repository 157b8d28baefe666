/* Rank and null spaces of a matrix whose entries have errors.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Gauss-Jordan elimination with complete pivoting of A, scaled to unit rows and columns, beside the
 * unit matrix. It carries bounds of the errors along; an entry that may be error, or that is so small
 * beside what it was subtracted from, is set to zero, so that zeros of structure stay zeros and the
 * null vectors have few entries. With pivots (r_k, c_k), the reduced matrix R and the row operations
 * L, L A = R:
 *
 *   A z_j = 0      z_j = e_j - sum_k R_(r_k) j e_(c_k)     for every column j without pivot
 *   y_i^T A = 0    y_i^T = row i of L                      for every row i without pivot
 *   row space      rho_k = e_(c_k) + sum_j R_(r_k) j e_j   for every pivot */
#ifndef MBSRI_REDUCTION_H
#define MBSRI_REDUCTION_H

#include <stdbool.h>
#include <stddef.h>

typedef struct mbsri_reduction {
    int n, rank;
    double *A, *error;              /* n x 2n: R and L, what they may be wrong by; column-major */
    double *rows, *columns;         /* n: scales, R and L belong to diag(rows) A diag(columns) */
    int *pivot_row, *pivot_column;  /* n: of the pivots */
    bool *row_taken, *column_taken; /* n: whether it has a pivot */
} mbsri_reduction;

/* Bytes of memory for matrices up to n x n, and the places in it, aligned for doubles. */
size_t mbsri_reduction_size(int n);
void mbsri_reduction_place(mbsri_reduction *r, int n, void *memory);

/* A and its errors are in the first n columns of r->A and r->error. `small`: the least share that
 * counts of what is subtracted. */
void mbsri_reduce(mbsri_reduction *r, int n, double small);

/* Number l of the null vectors, or of the row space (l < rank), and what it may be wrong by (NULL:
 * not asked for); n numbers, of the unscaled A. */
void mbsri_right_null(const mbsri_reduction *r, int l, double *z, double *error);
void mbsri_left_null(const mbsri_reduction *r, int l, double *y, double *error);
void mbsri_row_space(const mbsri_reduction *r, int l, double *rho);

#endif
