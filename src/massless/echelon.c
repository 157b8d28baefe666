/* A basis with few entries: Gauss-Jordan elimination of columns with complete pivoting.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/echelon.h"

#include <math.h>

/* Of what was added up to an entry. Eigenvectors come as exact as that beside their length. */
static const double nothing = 1e-13;

/* Row of the largest entry of columns from `first` on, which is brought to column `first`. */
static int bring_pivot(int n, int k, int first, double *X)
{
    int row = 0, column = first;
    for (int c = first; c < k; ++c) {
        for (int r = 0; r < n; ++r) {
            if (fabs(X[c * n + r]) > fabs(X[column * n + row])) row = r, column = c;
        }
    }
    for (int r = 0; r < n; ++r) {
        const double x = X[first * n + r];
        X[first * n + r] = X[column * n + r];
        X[column * n + r] = x;
    }
    return row;
}

void mbsri_echelon(int n, int k, double *X)
{
    for (int first = 0; first < k; ++first) {
        double *x = X + first * n;
        const int row = bring_pivot(n, k, first, X);
        const double pivot = x[row];
        if (pivot == 0.0) return;
        for (int r = 0; r < n; ++r) x[r] = r == row ? 1.0 : x[r] / pivot;
        for (int c = 0; c < k; ++c) {
            double *y = X + c * n;
            const double share = y[row];
            if (c == first) continue;
            for (int r = 0; r < n; ++r) {
                const double part = share * x[r], size = fabs(y[r]) + fabs(part);
                y[r] -= part;
                if (fabs(y[r]) <= nothing * size) y[r] = 0.0;
            }
            y[row] = 0.0;
        }
    }
    for (int c = 0; c < k; ++c) {
        for (int r = 0; r < n; ++r) {
            if (fabs(X[c * n + r]) <= nothing) X[c * n + r] = 0.0;
        }
    }
}
