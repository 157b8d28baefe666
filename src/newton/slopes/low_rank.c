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

double mbsri_longest_column(int rows, int columns, const double *E,
                            const mbsri_low_rank_spans *spans)
{
    double most = 0.0;
    for (int k = 0; k < columns; ++k) {
        double sum = 0.0;
        for (int r = 0; r < rows; ++r) {
            const double x = *E++ * spans->row[r];
            sum += x * x;
        }
        most = fmax(most, sqrt(sum) * spans->column[k]);
    }
    return most;
}

static void take_spans(int rows, int columns, const mbsri_low_rank_spans *spans, double *E)
{
    for (int k = 0; k < columns; ++k) {
        for (int r = 0; r < rows; ++r) *E++ *= spans->row[r] * spans->column[k];
    }
}

/* Of left and read. */
static void give_spans(int rows, int columns, int rank, int most, const mbsri_low_rank_spans *spans,
                       double *left, double *read)
{
    for (int k = 0; k < rank; ++k) {
        for (int r = 0; r < rows; ++r) *left++ /= spans->row[r];
    }
    for (int k = 0; k < columns; ++k) {
        for (int r = 0; r < rank; ++r) read[k * most + r] /= spans->column[k];
    }
}

/* Columns of E in turn, the longest that is left first, become an orthonormal `left`, read = left^T
 * E. */
int mbsri_low_rank(int rows, int columns, double *E, const mbsri_low_rank_spans *spans,
                   double *left, double *read, int most, double least)
{
    int rank = 0;
    take_spans(rows, columns, spans, E);
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
    give_spans(rows, columns, rank, most, spans, left, read);
    return rank;
}
