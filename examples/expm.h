/* Exact solution of x' = A x + b with constant coefficients, for comparison: matrix exponential by
 * scaling, Taylor series and squaring in long double.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_EXPM_H
#define EXAMPLES_EXPM_H

#include <math.h>
#include <string.h>

enum { EXPM_MOST = 9 };

typedef struct expm_system {
    int n;                          /* states, below EXPM_MOST */
    double A[EXPM_MOST][EXPM_MOST]; /* A[row][column] */
    double b[EXPM_MOST];
} expm_system;

typedef long double expm_matrix[EXPM_MOST][EXPM_MOST];

static inline void expm_multiply(int n, const expm_matrix X, const expm_matrix Y, expm_matrix Z)
{
    expm_matrix product = {{0}};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) product[i][j] += X[i][k] * Y[k][j];
        }
    }
    memcpy(Z, product, sizeof product);
}

/* x(t) from x(0); both n numbers, may be the same array. The state is extended by a constant 1 that
 * carries b. */
static inline void expm_solve(const expm_system *system, double t, const double *start, double *x)
{
    const int n = system->n, size = n + 1;
    expm_matrix E = {{0}}, term = {{0}}, A = {{0}};
    long double norm = 0.0L;
    for (int i = 0; i < n; ++i) {
        long double row = fabsl((long double)system->b[i] * t);
        for (int j = 0; j < n; ++j) {
            A[i][j] = (long double)system->A[i][j] * t;
            row += fabsl(A[i][j]);
        }
        A[i][n] = (long double)system->b[i] * t;
        norm = fmaxl(norm, row);
    }
    int halvings = 0;
    for (; norm > 0.25L; norm /= 2.0L) ++halvings;
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j) A[i][j] = ldexpl(A[i][j], -halvings);
        E[i][i] = term[i][i] = 1.0L;
    }
    for (int k = 1; k <= 20; ++k) {
        expm_multiply(size, (const long double(*)[EXPM_MOST])term,
                      (const long double(*)[EXPM_MOST])A, term);
        for (int i = 0; i < size; ++i) {
            for (int j = 0; j < size; ++j) E[i][j] += term[i][j] /= (long double)k;
        }
    }
    for (; halvings > 0; --halvings) {
        expm_multiply(size, (const long double(*)[EXPM_MOST])E, (const long double(*)[EXPM_MOST])E,
                      E);
    }
    double result[EXPM_MOST];
    for (int i = 0; i < n; ++i) {
        long double sum = E[i][n];
        for (int j = 0; j < n; ++j) sum += E[i][j] * (long double)start[j];
        result[i] = (double)sum;
    }
    memcpy(x, result, (size_t)n * sizeof *x);
}

#endif
