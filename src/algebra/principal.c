/* Springs and dampers by matrices: see principal.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The matrix is scaled to a unit diagonal, A = S A^ S, so that units do not decide what is zero,
 * and A^ = V w V^T. Of a stiffness energies are |T g|^2 / 2 with T = w^(1/2) V^T S, of a compliance
 * with T = w^(-1/2) V^T S^-1; B is the right inverse of T. The rotation Q^T T that makes B^T D B
 * diagonal leaves the energy as it is. */
#include "algebra/principal.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"

#include <math.h>
#include <stdbool.h>

enum { MOST = MBSRI_PRINCIPAL_MOST };

static const double zero = 1e-12; /* of eigenvalues of a matrix with unit diagonal */

/* A = V diag(w) V^T; of a diagonal matrix in the order of its entries. */
static bool eigenvectors_of(int n, double *A, double *w)
{
    double work[3 * MOST], largest = 0.0, across = 0.0;
    for (int k = 0; k < n * n; ++k) {
        double *at = k % (n + 1) == 0 ? &largest : &across;
        *at = fmax(*at, fabs(A[k]));
    }
    if (across > 1e-13 * largest) return mbsri_lapack_syev(n, A, w, work, 3 * n) == 0;
    for (int k = 0; k < n; ++k) w[k] = A[k * n + k];
    for (int k = 0; k < n * n; ++k) A[k] = k % (n + 1) == 0 ? 1.0 : 0.0;
    return true;
}

/* The rows T (row by row) that have an energy, then those of w = 0; and B, column by column. */
static bool split(int n, const double *A, bool compliance, mbsri_principal *out, double *B)
{
    double S[MOST], V[MOST * MOST], w[MOST];
    int rigid = 0;
    for (int k = 0; k < n; ++k) S[k] = A[k * n + k] > 0.0 ? sqrt(A[k * n + k]) : 1.0;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) V[j * n + k] = A[j * n + k] / S[j] / S[k];
    }
    if (!eigenvectors_of(n, V, w)) return false;
    out->rows = 0;
    for (int k = 0; k < n; ++k) {
        if (w[k] < -1e-10) return false;
        const double root = w[k] > zero ? compliance ? 1.0 / sqrt(w[k]) : sqrt(w[k]) : 1.0;
        const int at = w[k] > zero ? out->rows++ : n - ++rigid;
        for (int j = 0; j < n; ++j) {
            const double scale = compliance ? 1.0 / S[j] : S[j];
            out->T[at * n + j] = root * V[k * n + j] * scale;
            B[at * n + j] = V[k * n + j] / (root * scale);
        }
    }
    return true;
}

/* x^T D y */
static double form_product(int n, const double *D, const double *x, const double *y)
{
    double Dy[MOST] = {0.0};
    mbsri_ax(n, n, 1.0, D, y, Dy);
    return mbsri_dot(n, x, Dy);
}

/* T <- Q^T T, and what D does along each row. */
static bool rotate_rows(int n, const double *D, const double *B, mbsri_principal *out)
{
    const int rows = out->rows;
    double E[MOST * MOST], turned[MOST * MOST] = {0.0};
    for (int j = 0; j < rows; ++j) {
        for (int k = 0; k < rows; ++k)
            E[j * rows + k] = D ? form_product(n, D, B + j * n, B + k * n) : 0.0;
    }
    if (!eigenvectors_of(rows, E, out->damping)) return false;
    double largest = 0.0;
    for (int k = 0; k < rows; ++k) largest = fmax(largest, out->damping[k]);
    for (int j = 0; j < rows; ++j) {
        if (out->damping[j] < -1e-10 * largest) return false;
        out->damping[j] = fmax(0.0, out->damping[j]);
        mbsri_ax(n, rows, 1.0, out->T, E + j * rows, turned + j * n);
    }
    mbsri_copy((size_t)(rows * n), turned, out->T);
    return true;
}

/* Rows of length 1; whether none is within 1e-4 of the span of others. */
static bool normalise_rows(int n, int rows, mbsri_principal *out)
{
    double gram[MOST * MOST], w[MOST];
    for (int k = 0; k < rows; ++k) {
        double *T = out->T + k * n;
        const double square = mbsri_dot(n, T, T), length = sqrt(square);
        for (int j = 0; j < n; ++j) T[j] /= length;
        out->stiffness[k] = k < out->rows ? square : 0.0;
        out->damping[k] = k < out->rows ? square * out->damping[k] : 0.0;
    }
    for (int j = 0; j < rows; ++j) {
        for (int k = 0; k < rows; ++k)
            gram[j * rows + k] = mbsri_dot(n, out->T + j * n, out->T + k * n);
    }
    if (!eigenvectors_of(rows, gram, w)) return false;
    for (int k = 0; k < rows; ++k) {
        if (!(w[k] > 1e-8)) return false;
    }
    return true;
}

mbsri_principal_fault mbsri_principal_stiffness(int n, const double *K, const double *D,
                                                mbsri_principal *out)
{
    double B[MOST * MOST], largest = 0.0;
    if (!split(n, K, false, out, B)) return MBSRI_PRINCIPAL_INDEFINITE;
    for (int k = 0; k < n && D; ++k)
        largest = fmax(largest, form_product(n, D, B + k * n, B + k * n));
    for (int k = out->rows; k < n && D; ++k) {
        if (form_product(n, D, B + k * n, B + k * n) > 1e-12 * largest)
            return MBSRI_PRINCIPAL_LOOSE;
    }
    if (!rotate_rows(n, D, B, out)) return MBSRI_PRINCIPAL_DAMPING;
    return normalise_rows(n, out->rows, out) ? MBSRI_PRINCIPAL_GOOD : MBSRI_PRINCIPAL_SKEW;
}

mbsri_principal_fault mbsri_principal_compliance(int n, const double *A, const double *D,
                                                 mbsri_principal *out)
{
    double B[MOST * MOST];
    if (!split(n, A, true, out, B)) return MBSRI_PRINCIPAL_INDEFINITE;
    if (!rotate_rows(n, D, B, out)) return MBSRI_PRINCIPAL_DAMPING;
    const bool good = normalise_rows(n, n, out);
    out->rows = n;
    return good ? MBSRI_PRINCIPAL_GOOD : MBSRI_PRINCIPAL_SKEW;
}
