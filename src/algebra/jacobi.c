/* Eigenvalues of small symmetric matrices by Jacobi rotations.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/jacobi.h"

#include "algebra/dense.h"
#include "base/inlined.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Sizes are known to the compiler, which unrolls the loops. */

/* a, b <- c a - s b, s a + c b */
MBSRI_INLINE void turn(double c, double s, double *a, double *b)
{
    const double was = *a;
    *a = c * was - s * *b;
    *b = s * was + c * *b;
}

/* A <- J^T A J, of which the lower triangle is kept (A[p * n + q], p <= q), and X <- X J with the
 * rotation in the plane (p, q) that makes A_pq zero (Golub and Van Loan, Matrix Computations, 8.5).
 */
MBSRI_INLINE void rotate(int n, int p, int q, double *A, double *X)
{
    const double apq = A[p * n + q], twice = 2.0 * apq, gap = A[q * n + q] - A[p * n + p];
    /* tangent of the smaller angle: twice / (gap +- hypot(gap, twice)) */
    const double root = sqrt(gap * gap + twice * twice), t = twice / (gap + copysign(root, gap));
    const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
    A[p * n + p] -= t * apq;
    A[q * n + q] += t * apq;
    A[p * n + q] = 0.0;
    for (int k = 0; k < p; ++k) turn(c, s, A + k * n + p, A + k * n + q);
    for (int k = p + 1; k < q; ++k) turn(c, s, A + p * n + k, A + k * n + q);
    for (int k = q + 1; k < n; ++k) turn(c, s, A + p * n + k, A + q * n + k);
    for (int k = 0; k < n; ++k) turn(c, s, X + p * n + k, X + q * n + k);
}

/* Eigenvalues descending, by exchanging columns of X (n x c). */
static void sort_eigenvalues(int n, int c, double *X, double *lambda)
{
    for (int k = 0; k < c; ++k) {
        int largest = k;
        for (int l = k + 1; l < c; ++l) largest = lambda[l] > lambda[largest] ? l : largest;
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

/* Returns whether it ended. */
MBSRI_INLINE bool diagonalise(int n, double least, double *A, double *X)
{
    enum { SWEEPS = 30 };
    bool turned = true;
    for (int sweep = 0; sweep < SWEEPS && turned; ++sweep) {
        turned = false;
        for (int p = 0; p < n; ++p) {
            for (int q = p + 1; q < n; ++q) {
                if (fabs(A[p * n + q]) <= least) continue;
                rotate(n, p, q, A, X);
                turned = true;
            }
        }
    }
    return !turned;
}

static bool diagonalise_any(int n, double least, double *A, double *X)
{
    switch (n) {
    case 2: return diagonalise(2, least, A, X);
    case 3: return diagonalise(3, least, A, X);
    case 4: return diagonalise(4, least, A, X);
    case 6: return diagonalise(6, least, A, X);
    default: return diagonalise(n, least, A, X);
    }
}

int mbsri_jacobi(int n, double *A, double *lambda)
{
    double X[MBSRI_JACOBI_MAX * MBSRI_JACOBI_MAX] = {0.0}, size = 0.0;
    for (int k = 0; k < n; ++k) X[k * (n + 1)] = 1.0;
    for (int k = 0; k < n * n; ++k) size = fmax(size, fabs(A[k]));
    /* squares must not overflow, or vanish */
    const double unit = size > 0.0 && !(size > 1e-100 && size < 1e100) ? size : 1.0;
    for (int k = 0; k < n * n && unit != 1.0; ++k) A[k] /= unit;
    const bool ended = diagonalise_any(n, 0.01 * DBL_EPSILON * (size / unit), A, X);
    for (int k = 0; k < n; ++k) lambda[k] = unit * A[k * (n + 1)];
    for (int k = 0; k < n * n; ++k) A[k] = X[k];
    sort_eigenvalues(n, n, A, lambda);
    return !ended;
}

/* Makes columns x and y (n) orthogonal by a rotation; false where they are. */
static bool part(int n, double *x, double *y)
{
    const double a = mbsri_dot(n, x, x), b = mbsri_dot(n, y, y), product = mbsri_dot(n, x, y);
    if (!(fabs(product) > 4e-16 * sqrt(a) * sqrt(b))) return false;
    const double theta = (b - a) / (2.0 * product),
                 t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + hypot(theta, 1.0)),
                 c = 1.0 / sqrt(1.0 + t * t), s = t * c;
    for (int k = 0; k < n; ++k) turn(c, s, x + k, y + k);
    return true;
}

int mbsri_orthogonalise(int n, int c, double *A, double *lambda)
{
    enum { SWEEPS = 40 };
    bool turned = true;
    for (int sweep = 0; sweep < SWEEPS && turned; ++sweep) {
        turned = false;
        for (int p = 0; p < c; ++p) {
            for (int q = p + 1; q < c; ++q) turned = part(n, A + p * n, A + q * n) || turned;
        }
    }
    for (int l = 0; l < c; ++l) lambda[l] = mbsri_dot(n, A + l * n, A + l * n);
    sort_eigenvalues(n, c, A, lambda);
    return turned;
}
