/* Eigenvalues of small symmetric matrices by Jacobi rotations.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/jacobi.h"

#include <float.h>
#include <math.h>

/* A <- J^T A J and X <- X J with the rotation in the plane (p, q) that makes A_pq zero (Golub and
 * Van Loan, Matrix Computations, 8.5). */
static void rotate(int n, int p, int q, double *A, double *X)
{
    const double apq = A[q * n + p], theta = (A[q * n + q] - A[p * n + p]) / (2.0 * apq);
    const double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(1.0 + theta * theta));
    const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
    for (int k = 0; k < n; ++k) {
        const double a = A[p * n + k], b = A[q * n + k];
        A[p * n + k] = c * a - s * b;
        A[q * n + k] = s * a + c * b;
    }
    for (int k = 0; k < n; ++k) {
        const double a = A[k * n + p], b = A[k * n + q];
        A[k * n + p] = c * a - s * b;
        A[k * n + q] = s * a + c * b;
    }
    A[q * n + p] = A[p * n + q] = 0.0;
    for (int k = 0; k < n; ++k) {
        const double a = X[p * n + k], b = X[q * n + k];
        X[p * n + k] = c * a - s * b;
        X[q * n + k] = s * a + c * b;
    }
}

/* Eigenvalues descending, by exchanging columns. */
static void sort(int n, double *X, double *lambda)
{
    for (int k = 0; k < n; ++k) {
        int largest = k;
        for (int l = k + 1; l < n; ++l) largest = lambda[l] > lambda[largest] ? l : largest;
        if (largest == k) continue;
        const double value = lambda[k];
        lambda[k] = lambda[largest];
        lambda[largest] = value;
        for (int j = 0; j < n; ++j) {
            const double entry = X[k * n + j];
            X[k * n + j] = X[largest * n + j];
            X[largest * n + j] = entry;
        }
    }
}

int mbsri_jacobi(int n, double *A, double *lambda)
{
    enum { SWEEPS = 30 };
    double X[MBSRI_JACOBI_MAX * MBSRI_JACOBI_MAX] = {0.0}, size = 0.0;
    for (int k = 0; k < n; ++k) X[k * (n + 1)] = 1.0;
    for (int k = 0; k < n * n; ++k) size = fmax(size, fabs(A[k]));
    int rotations = 1;
    for (int sweep = 0; sweep < SWEEPS && rotations > 0; ++sweep) {
        rotations = 0;
        for (int p = 0; p < n; ++p) {
            for (int q = p + 1; q < n; ++q) {
                if (fabs(A[q * n + p]) <= 0.01 * DBL_EPSILON * size) continue;
                rotate(n, p, q, A, X);
                ++rotations;
            }
        }
    }
    for (int k = 0; k < n; ++k) lambda[k] = A[k * (n + 1)];
    for (int k = 0; k < n * n; ++k) A[k] = X[k];
    sort(n, A, lambda);
    return rotations > 0;
}
