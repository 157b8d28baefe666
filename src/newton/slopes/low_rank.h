/* A matrix of low rank as a product.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOW_RANK_H
#define MBSRI_LOW_RANK_H

/* E (rows x columns) = left (rows x rank) read (rank x columns, stored with `most` rows), left
 * orthonormal; E is used up. Columns as long as `least` at most count as zero. The rank. */
int mbsri_low_rank(int rows, int columns, double *E, double *left, double *read, int most,
                   double least);

/* The length of the longest column. */
double mbsri_longest_column(int rows, int columns, const double *E);

#endif
