/* A matrix of low rank as a product.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOW_RANK_H
#define MBSRI_LOW_RANK_H

/* Typical sizes of the motions that belong to rows and to columns: times both, entries are
 * energies, whatever forces and motions they stand for. */
typedef struct mbsri_low_rank_spans {
    double *row, *column;
} mbsri_low_rank_spans;

/* E (rows x columns) = left (rows x rank) read (rank x columns, stored with `most` rows), left
 * orthonormal by the spans; E is used up. Columns as long as `least` at most, by the spans, count
 * as zero. The rank. */
int mbsri_low_rank(int rows, int columns, double *E, const mbsri_low_rank_spans *spans,
                   double *left, double *read, int most, double least);

/* The length of the longest column by the spans. */
double mbsri_longest_column(int rows, int columns, const double *E,
                            const mbsri_low_rank_spans *spans);

#endif
