/* Normal and static modes of a beam: see beam_modes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With K = L L^T the eigenvectors y of L^-1 M L^-T y = mu y give the modes x = L^-T y, x^T K x = 1,
 * with mu = 1 / omega^2; parts that have no mass are those of mu = 0. Static modes X = K^-1 F keep
 * X - sum_j x_j (x_j^T F), which is K-orthogonal to the normal modes; their own small eigenproblem,
 * first of X^T K X, then of the mass in what that leaves, makes them independent and diagonal. */
#include "flexible/beam_modes.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "algebra/lapack.h"

#include <math.h>

static const double none = 1e-13;      /* mu beside the largest one: no mass */
static const double dependent = 1e-10; /* eigenvalues of static modes scaled to 1 */

size_t mbsri_beam_work(int free, int loads)
{
    const size_t n = (size_t)free, m = (size_t)loads;
    return 2 * n * n + 2 * n + 3 * n * m + 3 * m * m + 3 * m + n +
           (size_t)mbsri_lapack_syev_work(free > loads ? free : loads);
}

static void transpose(int n, double *A)
{
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < j; ++k) {
            const double held = A[j * n + k];
            A[j * n + k] = A[k * n + j];
            A[k * n + j] = held;
        }
    }
}

/* x <- L^-T x */
static void solve_transposed(int n, const double *L, double *x)
{
    for (int k = n - 1; k >= 0; --k) {
        for (int j = k + 1; j < n; ++j) x[k] -= L[k * n + j] * x[j];
        x[k] /= L[k * n + k];
    }
}

/* A new mode, x over the free dofs, with its largest number positive. */
static void keep_mode(mbsri_beam *b, const double *x, double mu)
{
    double *mode = b->mode + (size_t)b->dofs * (size_t)b->modes, largest = 0.0;
    mbsri_zero((size_t)b->dofs, mode);
    for (int k = 0; k < b->free; ++k) {
        mode[b->dof[k]] = x[k];
        if (fabs(x[k]) > 1.000001 * fabs(largest)) largest = x[k];
    }
    for (int k = 0; k < b->dofs && largest < 0.0; ++k) mode[k] = -mode[k];
    b->flexibility[b->modes++] = mu;
}

/* Normal modes; x (free x free) gets all of them, the lowest last, mu theirs. L: factor of K. */
static int normal_modes(mbsri_beam *b, const double *L, double *x, double *mu, double *work)
{
    const int n = b->free;
    mbsri_copy((size_t)n * (size_t)n, b->M, x);
    mbsri_divide_by_cholesky(n, n, L, x);
    transpose(n, x);
    mbsri_divide_by_cholesky(n, n, L, x);
    if (mbsri_lapack_syev(n, x, mu, work, mbsri_lapack_syev_work(n)) != 0) return MBSR_ERR_NUMERICS;
    for (int k = 0; k < n; ++k) solve_transposed(n, L, x + n * k);
    for (int k = n - 1; k >= 0 && b->modes < b->def->modes; --k) {
        const double omega = b->def->frequency;
        if (!(mu[k] > none * mu[n - 1]) || mu[k] * omega * omega < 1.0) break;
        keep_mode(b, x + n * k, mu[k]);
    }
    b->normal = b->modes;
    return MBSR_OK;
}

/* Residual attachment modes X (free x m) for unit loads at the loaded nodes, scaled to x^T K x = 1.
 * Returns m. */
static int attachment_modes(const mbsri_beam *b, const double *L, const double *x, double *X)
{
    const int n = b->free;
    int m = 0;
    for (int l = 0; l < b->def->loaded; ++l) {
        for (int k = 0; k < n; ++k) {
            if (b->dof[k] / MBSRI_BEAM_NODE != b->def->node[l]) continue;
            double *column = X + n * m;
            mbsri_zero((size_t)n, column);
            column[k] = 1.0;
            mbsri_divide_by_cholesky(1, n, L, column);
            solve_transposed(n, L, column);
            const double whole = column[k];
            for (int j = 0; j < b->normal; ++j) {
                const double *mode = x + n * (n - 1 - j);
                mbsri_ax(n, 1, -mode[k], mode, &(double){1.0}, column);
            }
            if (!(column[k] > 1e-12 * whole)) continue;
            const double scale = 1.0 / sqrt(column[k]);
            for (int j = 0; j < n; ++j) column[j] *= scale;
            ++m;
        }
    }
    return m;
}

/* C (c x c) = X^T A X, A n x n; AX: n x c. */
static void project_matrix(int n, int c, const double *A, const double *X, double *AX, double *C)
{
    mbsri_zero((size_t)n * (size_t)c, AX);
    mbsri_ab(n, n, c, 1.0, A, X, AX);
    mbsri_zero((size_t)c * (size_t)c, C);
    mbsri_atb(n, c, c, 1.0, X, AX, C);
}

static int static_modes(mbsri_beam *b, const double *L, const double *x, double mu_largest,
                        double *memory)
{
    const int n = b->free, most = MBSRI_BEAM_NODE * b->def->loaded;
    double *X = memory, *AX = X + (size_t)n * (size_t)most, *Z = AX + (size_t)n * (size_t)most,
           *C = Z + (size_t)n * (size_t)most, *lambda = C + (size_t)most * (size_t)most,
           *work = lambda + most;
    const int m = attachment_modes(b, L, x, X);
    if (m == 0) return MBSR_OK;
    project_matrix(n, m, b->K, X, AX, C);
    if (mbsri_lapack_syev(m, C, lambda, work, mbsri_lapack_syev_work(m)) != 0)
        return MBSR_ERR_NUMERICS;
    int left = 0;
    for (int k = 0; k < m; ++k) {
        if (!(lambda[k] > dependent * lambda[m - 1])) continue;
        double *z = Z + n * left++;
        mbsri_zero((size_t)n, z);
        mbsri_ax(n, m, 1.0 / sqrt(lambda[k]), X, C + m * k, z);
    }
    project_matrix(n, left, b->M, Z, AX, C);
    if (mbsri_lapack_syev(left, C, lambda, work, mbsri_lapack_syev_work(left)) != 0)
        return MBSR_ERR_NUMERICS;
    for (int k = left - 1; k >= 0; --k) {
        mbsri_zero((size_t)n, X);
        mbsri_ax(n, left, 1.0, Z, C + left * k, X);
        keep_mode(b, X, lambda[k] > none * mu_largest ? lambda[k] : 0.0);
    }
    return MBSR_OK;
}

int mbsri_beam_find_modes(mbsri_beam *b)
{
    const size_t n = (size_t)b->free;
    double *L = b->work, *x = L + n * n, *mu = x + n * n, *work = mu + n;
    b->modes = b->normal = 0;
    if (n == 0) return MBSR_OK;
    mbsri_copy(n * n, b->K, L);
    if (!mbsri_cholesky(b->free, L)) return MBSR_ERR_VALUE;
    int status = normal_modes(b, L, x, mu, work);
    if (!status) status = static_modes(b, L, x, mu[n - 1], work);
    return status;
}
