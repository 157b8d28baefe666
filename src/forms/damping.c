/* Whether the slopes of forces determine velocities.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A matrix A with errors up to E, entry by entry, is regular with every matrix in that range if the
 * spectral radius of |A^-1| E is below 1 (Rump, Verification methods, Acta Numerica 19, 2010). Its
 * largest row sum bounds the radius, after A has been scaled to unit rows and columns. */
#include "forms/damping.h"

#include "algebra/differences.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"

#include <math.h>

/* How many times its error a slope has to be. */
static const double clear = 10.0;

/* Rows, then columns of A to largest entries 1, and E likewise; false where one is zero. */
static bool scale_damping(int n, double *A, double *E, double *row, double *column, int *weakest)
{
    for (int c = 0; c < n; ++c) {
        *weakest = c;
        if (mbsri_largest(n, A + c * n) == 0.0) return false;
    }
    *weakest = 0;
    for (int r = 0; r < n; ++r) {
        double size = 0.0;
        for (int c = 0; c < n; ++c) size = fmax(size, fabs(A[c * n + r]));
        if (size == 0.0) return false;
        row[r] = 1.0 / size;
        for (int c = 0; c < n; ++c) A[c * n + r] *= row[r], E[c * n + r] *= row[r];
    }
    for (int c = 0; c < n; ++c) {
        column[c] = 1.0 / mbsri_largest(n, A + c * n);
        for (int r = 0; r < n; ++r) A[c * n + r] *= column[c], E[c * n + r] *= column[c];
    }
    return true;
}

bool mbsri_invert_within(int n, double *A, double *E, int *pivots, double *work, int *weakest)
{
    double *row = work, *column = row + n, *rest = column + n, *sums = rest;
    if (!scale_damping(n, A, E, row, column, weakest)) return false;
    if (n == 1) {
        A[0] = 1.0 / A[0];
    } else if (!(mbsri_lapack_inverse(n, A, pivots, rest) > 0.0)) {
        return false;
    }
    for (int r = 0; r < n; ++r) sums[r] = 0.0;
    for (int c = 0; c < n; ++c) {
        for (int r = 0; r < n; ++r) sums[r] += E[c * n + r];
    }
    double worst = -1.0;
    for (int r = 0; r < n; ++r) {
        double sum = 0.0;
        for (int c = 0; c < n; ++c) sum += fabs(A[c * n + r]) * sums[c];
        if (sum <= worst) continue;
        worst = sum;
        *weakest = r;
    }
    if (!(clear * worst < 1.0)) return false;
    for (int c = 0; c < n; ++c) {
        for (int r = 0; r < n; ++r) A[c * n + r] *= column[r] * row[c];
    }
    return true;
}

/* A slope at longer steps that contradicts the one found at shorter ones belongs to another branch
 * of the law. */
double mbsri_best_slope(int count, int stride, const double *slopes, const double *sizes,
                        double share, double unit, double *error)
{
    double best = INFINITY, slope = 0.0, before = 0.0, least = INFINITY;
    for (int k = 0; k < count; ++k, share *= 10.0) {
        const double now = slopes[k * stride],
                     noise = mbsri_slope_noise(count, k, stride, slopes, sizes[k * stride], share,
                                               unit),
                     change = noise + fabs(now - before);
        if (slope != 0.0 && fabs(now - slope) > clear * best + change) break;
        least = fmin(least, noise);
        before = now;
        if (!(change < best) || !(fabs(now) > clear * noise)) continue;
        best = change;
        slope = now;
        *error = noise;
    }
    if (slope == 0.0) *error = least;
    return slope;
}
