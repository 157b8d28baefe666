/* Rank and null spaces of a matrix whose entries have errors.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Gauss-Jordan elimination with complete pivoting of A, scaled to rows of the sizes of what they
 * stand for and to unit columns, beside the unit matrix. It carries bounds of the errors along; an
 * entry that may be error, or that is so small beside what it was subtracted from, is set to zero,
 * so that zeros of structure stay zeros and the null vectors have few entries. With pivots (r_k,
 * c_k), the reduced matrix R and the row operations L, L A = R:
 *
 *   A z_j = 0      z_j = e_j - sum_k R_(r_k) j e_(c_k)     for every column j without pivot
 *   y_i^T A = 0    y_i^T = row i of L                      for every row i without pivot
 *   y_k^T A        is zero at all pivots but the k-th      y_k^T = row r_k of L
 *   row space      rho_k = e_(c_k) + sum_j R_(r_k) j e_j   for every pivot */
#ifndef MBSRI_REDUCTION_H
#define MBSRI_REDUCTION_H

#include <stdbool.h>
#include <stddef.h>

typedef struct mbsri_reduction {
    int n, m, rank;         /* of A: rows, columns, rank */
    double *A, *error;      /* n x (m + n): R and L, what they may be wrong by; column-major */
    double *rows, *columns; /* n, m: scales, R and L belong to diag(rows) A diag(columns) */
    int *pivot_row, *pivot_column;  /* of the pivots */
    int *largest;                   /* m: row of the largest entry of the column, -1: none */
    bool *row_taken, *column_taken; /* n, m: whether it has a pivot */
} mbsri_reduction;

/* Bytes of memory for matrices up to n x m, and the places in it, aligned for doubles. */
size_t mbsri_reduction_size(int n, int m);
void mbsri_reduction_place(mbsri_reduction *r, int n, int m, void *memory);

/* A (n x m) and its errors are at the beginning of r->A and r->error. No more than `most` pivots
 * are looked for. `small`: the least share that counts of what is subtracted. sizes (n): what rows
 * are scaled by, of what they stand for; NULL: their largest entries. */
void mbsri_reduce(mbsri_reduction *r, int n, int m, int most, double small, const double *sizes);

/* Number l of the null vectors, or of the pivots (l < rank), and what it may be wrong by (NULL: not
 * asked for), of the unscaled A: right ones and the row space have m numbers, left ones n. */
void mbsri_right_null(const mbsri_reduction *r, int l, double *z, double *error);
void mbsri_left_null(const mbsri_reduction *r, int l, double *y, double *error);
void mbsri_left_pivot(const mbsri_reduction *r, int l, double *y);
void mbsri_row_space(const mbsri_reduction *r, int l, double *rho);

#endif
