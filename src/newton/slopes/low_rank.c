/* A matrix of low rank as a product: see low_rank.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/slopes/low_rank.h"

#include "algebra/dense.h"

#include <math.h>

static int longest(int rows, int columns, const double *E, double *norm)
{
    int at = 0;
    *norm = -1.0;
    for (int k = 0; k < columns; ++k) {
        const double *column = E + (size_t)k * (size_t)rows;
        const double size = sqrt(mbsri_dot(rows, column, column));
        if (size > *norm) *norm = size, at = k;
    }
    return at;
}

double mbsri_longest_column(int rows, int columns, const double *E)
{
    double norm;
    (void)longest(rows, columns, E, &norm);
    return norm;
}

/* Columns of E in turn, the longest that is left first, become an orthonormal `left`, read = left^T
 * E. */
int mbsri_low_rank(int rows, int columns, double *E, double *left, double *read, int most,
                   double least)
{
    int rank = 0;
    for (; rank < most; ++rank) {
        double norm, *const q = left + (size_t)rank * (size_t)rows;
        const double *column = E + (size_t)longest(rows, columns, E, &norm) * (size_t)rows;
        if (!(norm > least)) break;
        for (int k = 0; k < rows; ++k) q[k] = column[k] / norm;
        for (int k = 0; k < columns; ++k) {
            double *x = E + (size_t)k * (size_t)rows;
            const double part = mbsri_dot(rows, q, x);
            read[k * most + rank] = part;
            for (int l = 0; l < rows; ++l) x[l] -= part * q[l];
        }
    }
    return rank;
}
