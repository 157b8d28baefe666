/* Whether modal data are those of a body: see check.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The integrals are those of some field and some mass if the Gram matrix of its components is
 * positive semi-definite,
 *
 *   G = int g g^T,   g = (1, x, Phi_1, ..., Phi_n, chi_1, ..., chi_r)
 *
 * and then M(s) is so for every s. Rotary inertia adds Mf_ab - tr P_ab, which has to be
 * positive semi-definite by itself. */
#include "flexible/check.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"

#include <math.h>

static const double tolerance = 1e-9; /* of matrices scaled to unit diagonal */

#define REFUSE(status, ...) mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

static int check_matrix_finite(const char *name, size_t rows, size_t columns, const double *x,
                               mbsr_error *error)
{
    for (size_t k = 0; k < rows * columns; ++k) {
        if (!isfinite(x[k]))
            return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_create: %s(%d,%d) is %g", name,
                          (int)(k % rows), (int)(k / rows), x[k]);
    }
    return MBSR_OK;
}

/* A (n x n) symmetric, its entries against least[] of what their rows and columns have besides. */
static int check_symmetric(const char *name, int n, const double *A, mbsr_error *error)
{
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < j; ++k) {
            const double a = A[j * n + k], b = A[k * n + j],
                         size = fabs(a) + fabs(b) +
                                sqrt(fabs(A[j * n + j])) * sqrt(fabs(A[k * n + k]));
            if (fabs(a - b) > tolerance * size)
                return REFUSE(MBSR_ERR_VALUE,
                              "mbsr_flex_create: %s is not symmetric: (%d,%d) is %g, (%d,%d) is %g",
                              name, k, j, a, j, k, b);
        }
    }
    return MBSR_OK;
}

/* A (n x n) symmetric and, scaled to unit diagonal, without eigenvalues below -tolerance; scale (n;
 * NULL: its own diagonal): what counts as 1. work: n x n + n, then LAPACK's. */
static int check_semidefinite(const char *name, const char *why, int n, const double *A,
                              const double *scale, double *work, mbsr_error *error)
{
    double *S = work, *w = S + (size_t)n * (size_t)n, *rest = w + n;
    const int status = check_symmetric(name, n, A, error);
    if (status || n == 0) return status;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
            const double size = scale ? sqrt(scale[j]) * sqrt(scale[k])
                                      : sqrt(fabs(A[j * n + j])) * sqrt(fabs(A[k * n + k]));
            if (size == 0.0 && A[j * n + k] != 0.0)
                return REFUSE(MBSR_ERR_VALUE,
                              "mbsr_flex_create: %s is indefinite: (%d,%d) is %g beside a zero "
                              "on the diagonal; %s",
                              name, k, j, A[j * n + k], why);
            S[j * n + k] = size > 0.0 ? A[j * n + k] / size : 0.0;
        }
    }
    if (mbsri_lapack_syev(n, S, w, rest, mbsri_lapack_syev_work(n)) != 0)
        return REFUSE(MBSR_ERR_NUMERICS, "mbsr_flex_create: the eigenvalues of %s did not converge",
                      name);
    if (w[0] >= -tolerance) return MBSR_OK;
    return REFUSE(MBSR_ERR_VALUE,
                  "mbsr_flex_create: %s is indefinite: scaled to unit diagonal its lowest "
                  "eigenvalue is %.3g; %s",
                  name, w[0], why);
}

/* G, (4 + 3 n) x (4 + 3 n). */
static void fill_gram(const mbsr_flex *f, double *G)
{
    const int n = 3 * f->m, size = 4 + n;
    G[0] = f->mass;
    for (int j = 0; j < 3; ++j) {
        G[1 + j] = G[(size_t)size * (size_t)(1 + j)] = f->c0[j];
        for (int k = 0; k < 3; ++k)
            G[(size_t)size * (size_t)(1 + j) + 1 + (size_t)k] = f->N0[3 * j + k];
    }
    for (int j = 0; j < n; ++j) {
        double *column = G + (size_t)size * (size_t)(4 + j);
        column[0] = G[4 + j] = f->Ct0[j];
        for (int k = 0; k < 3; ++k)
            column[1 + k] = G[(size_t)size * (size_t)(1 + k) + 4 + (size_t)j] = f->P0[3 * j + k];
        mbsri_copy((size_t)n, f->P + (size_t)n * (size_t)j, column + 4);
    }
}

/* Mf less the traces of P; what rounding leaves of zero is zero. */
static void fill_rotary(const mbsr_flex *f, double *A)
{
    const int n = f->m;
    for (int b = 0; b < n; ++b) {
        for (int a = 0; a < n; ++a) {
            const double *P = f->P + (size_t)(3 * n) * (size_t)(3 * b) + 3 * (size_t)a;
            A[b * n + a] = f->Mf[b * n + a] - (P[0] + P[3 * n + 1] + P[6 * n + 2]);
        }
    }
}

/* Y_k beside its largest entry; it may be indefinite. */
static int check_dependence(const mbsr_flex *f, int k, mbsr_error *error)
{
    const int n = f->n;
    const double *Y = f->Y + (size_t)(n * n) * (size_t)k;
    double largest = 0.0;
    for (int l = 0; l < n * n; ++l) largest = fmax(largest, fabs(Y[l]));
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < a; ++b) {
            if (fabs(Y[a * n + b] - Y[b * n + a]) > tolerance * largest)
                return REFUSE(MBSR_ERR_VALUE,
                              "mbsr_flex_create: Y of dependent shape %d is not symmetric: (%d,%d) "
                              "is %g, (%d,%d) is %g",
                              k, b, a, Y[a * n + b], a, b, Y[b * n + a]);
        }
    }
    return MBSR_OK;
}

static int check_matrices(const mbsr_flex *f, double *work, mbsr_error *error)
{
    const int n = f->n, m = f->m, size = 4 + 3 * m;
    double *A = work, *scale = A + (size_t)size * (size_t)size, *rest = scale + m;
    int status =
        check_semidefinite("K", "the body would have no stable shape", n, f->K, NULL, rest, error);
    if (!status)
        status = check_semidefinite("D", "damping would feed energy", n, f->D, NULL, rest, error);
    if (!status) status = check_symmetric("N0", 3, f->N0, error);
    if (!status) status = check_symmetric("P", 3 * m, f->P, error);
    if (!status) status = check_symmetric("Mf", m, f->Mf, error);
    for (int k = 0; k < f->r && !status; ++k) status = check_dependence(f, k, error);
    if (status) return status;
    fill_gram(f, A);
    status = check_semidefinite(
        "the Gram matrix of (1, x, Phi)",
        "mass, c0, N0, Ct0, P0 and P are not integrals of one field over one mass", size, A, NULL,
        rest, error);
    if (status) return status;
    fill_rotary(f, A);
    for (int a = 0; a < m; ++a) scale[a] = fabs(f->Mf[a * m + a]);
    return check_semidefinite("Mf less the traces of P",
                              "the kinetic energy of the modes is less than that of their "
                              "displacements",
                              m, A, scale, rest, error);
}

static int check_marker(const mbsr_flex *f, int k, mbsr_error *error)
{
    const mbsr_flex_marker *marker = f->marker + k;
    const size_t entries = 3 * (size_t)f->m;
    if (!mbsri_finite(3, marker->frame.x) || !mbsri_finite(9, marker->frame.R) ||
        !mbsri_finite(entries, marker->Phi) || !mbsri_finite(entries, marker->Psi))
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_create: marker[%d] has numbers that are not finite", k);
    const double defect = mbsri_frame_defect(marker->frame.R);
    if (defect <= 1e-6) return MBSR_OK;
    return REFUSE(MBSR_ERR_VALUE,
                  "mbsr_flex_create: the axes of marker[%d] are not orthonormal and right-handed "
                  "(by %.2g)",
                  k, defect);
}

int mbsri_flex_check(const mbsr_flex *f, mbsr_error *error)
{
    const size_t n = (size_t)f->n, m = (size_t)f->m, size = 4 + 3 * m;
    int status = check_matrix_finite("mass", 1, 1, &f->mass, error);
    if (!status) status = check_matrix_finite("c0", 3, 1, f->c0, error);
    if (!status) status = check_matrix_finite("N0", 3, 3, f->N0, error);
    if (!status) status = check_matrix_finite("Ct0", 3, m, f->Ct0, error);
    if (!status) status = check_matrix_finite("P0", 3, 3 * m, f->P0, error);
    if (!status) status = check_matrix_finite("P", 3 * m, 3 * m, f->P, error);
    if (!status) status = check_matrix_finite("Mf", m, m, f->Mf, error);
    if (!status) status = check_matrix_finite("K", n, n, f->K, error);
    if (!status) status = check_matrix_finite("D", n, n, f->D, error);
    if (!status) status = check_matrix_finite("Y", n, n * (size_t)f->r, f->Y, error);
    for (int k = 0; k < f->markers && !status; ++k) status = check_marker(f, k, error);
    if (!status && f->mass < 0.0)
        status = REFUSE(MBSR_ERR_VALUE, "mbsr_flex_create: mass is %g, negative", f->mass);
    if (status) return status;
    const size_t doubles = 2 * size * size + size + m + (size_t)mbsri_lapack_syev_work((int)size);
    double *work = mbsri_allocate(&f->allocator, doubles * sizeof *work);
    if (!work) return REFUSE(MBSR_ERR_NO_MEMORY, "mbsr_flex_create: no memory to check the data");
    status = check_matrices(f, work, error);
    mbsri_release(&f->allocator, work);
    return status;
}
