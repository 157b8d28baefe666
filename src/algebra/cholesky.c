/* Cholesky factors of small matrices.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/cholesky.h"

#include <math.h>

bool mbsri_cholesky(int n, double *A)
{
    for (int k = 0; k < n; ++k) {
        for (int j = k; j < n; ++j) {
            for (int l = 0; l < k; ++l) A[k * n + j] -= A[l * n + j] * A[l * n + k];
        }
        if (!(A[k * n + k] > 0.0)) return false;
        const double pivot = sqrt(A[k * n + k]);
        for (int j = k; j < n; ++j) A[k * n + j] /= pivot;
    }
    return true;
}

void mbsri_divide_by_cholesky(int r, int n, const double *L, double *X)
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < k; ++l) {
            for (int i = 0; i < r; ++i) X[k * r + i] -= X[l * r + i] * L[l * n + k];
        }
        for (int i = 0; i < r; ++i) X[k * r + i] /= L[k * n + k];
    }
}
