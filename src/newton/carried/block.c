/* A small system of linear equations: see block.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/block.h"

#include <float.h>
#include <math.h>

/* Rows by what was added up in them, so that what is left of a row by rounding stays small; then
 * columns to a largest entry of 1. */
static bool scale(int n, double *A, double *rows, double *columns)
{
    for (int i = 0; i < n; ++i) {
        if (!(rows[i] > 0.0) || !isfinite(rows[i])) return false;
        rows[i] = 1.0 / rows[i];
        for (int j = 0; j < n; ++j) A[j * n + i] *= rows[i];
    }
    for (int j = 0; j < n; ++j) {
        double largest = 0.0;
        for (int i = 0; i < n; ++i) largest = fmax(largest, fabs(A[j * n + i]));
        if (!(largest > 64.0 * DBL_EPSILON) || !isfinite(largest)) return false;
        columns[j] = 1.0 / largest;
        for (int i = 0; i < n; ++i) A[j * n + i] *= columns[j];
    }
    return true;
}

static void exchange(int n, double *A, int i, int k)
{
    for (int j = 0; j < n && i != k; ++j) {
        const double x = A[j * n + i];
        A[j * n + i] = A[j * n + k];
        A[j * n + k] = x;
    }
}

bool mbsri_block_factor(int n, double *A, double *rows, double *columns, int *pivots)
{
    if (!scale(n, A, rows, columns)) return false;
    for (int k = 0; k < n; ++k) {
        int p = k;
        for (int i = k + 1; i < n; ++i) {
            if (fabs(A[k * n + i]) > fabs(A[k * n + p])) p = i;
        }
        pivots[k] = p;
        exchange(n, A, k, p);
        const double pivot = A[k * n + k];
        if (!(fabs(pivot) > 64.0 * DBL_EPSILON)) return false;
        for (int i = k + 1; i < n; ++i) A[k * n + i] /= pivot;
        for (int j = k + 1; j < n; ++j) {
            const double factor = A[j * n + k];
            for (int i = k + 1; i < n; ++i) A[j * n + i] -= A[k * n + i] * factor;
        }
    }
    return true;
}

void mbsri_block_solve(int n, const double *A, const double *rows, const double *columns,
                       const int *pivots, double *x)
{
    for (int i = 0; i < n; ++i) x[i] *= rows[i];
    for (int k = 0; k < n; ++k) {
        const double value = x[pivots[k]];
        x[pivots[k]] = x[k];
        x[k] = value;
    }
    for (int k = 0; k < n; ++k) {
        for (int i = k + 1; i < n; ++i) x[i] -= A[k * n + i] * x[k];
    }
    for (int k = n - 1; k >= 0; --k) {
        x[k] /= A[k * n + k];
        for (int i = 0; i < k; ++i) x[i] -= A[k * n + i] * x[k];
    }
    for (int i = 0; i < n; ++i) x[i] *= columns[i];
}
