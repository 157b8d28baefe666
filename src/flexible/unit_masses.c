/* What makes modal masses 1: see unit_masses.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Scaled to unit diagonal, Mf of the modes with mass is L L^T, and R = diag(Mf)^(-1/2) L^-T. Its
 * inverse is no larger than ||L^-1||_1 ||L^-1||_inf. */
#include "flexible/unit_masses.h"

#include "algebra/dense.h"

#include <float.h>
#include <math.h>

/* Cholesky's pivots from here on lose no more than six digits. */
static const double least_pivot = 1e-6;

/* R (its upper triangle) column by column from L^-1, whose row k is column k of L^-T. */
static bool fill_root(const mbsr_flex *f, double *R)
{
    const int n = f->n;
    for (int k = 0; k < n; ++k) {
        double *column = R + (size_t)k * (size_t)n, left = 1.0;
        const double *Mf = f->Mf + (size_t)k * (size_t)f->m, own = Mf[k];
        mbsri_zero((size_t)n, column);
        if (own == 0.0) continue;
        /* row k of L times those of L^-T before: L_k = R_before^T (Mf)_k */
        for (int j = 0; j < k; ++j) {
            const double *before = R + (size_t)j * (size_t)n;
            const double entry = mbsri_dot(j + 1, before, Mf) / sqrt(own);
            left -= entry * entry;
            mbsri_ax(j + 1, 1, -entry, before, &(double){1.0}, column);
        }
        if (!(left > least_pivot)) return false;
        column[k] = 1.0 / sqrt(own);
        for (int j = 0; j <= k; ++j) column[j] /= sqrt(left);
    }
    return true;
}

/* ||L^-1||_1 ||L^-1||_inf */
static double spread_of(const mbsr_flex *f)
{
    const int n = f->n;
    double rows = 1.0, columns = 1.0;
    for (int k = 0; k < n; ++k) {
        double row = 0.0, column = 0.0;
        for (int j = 0; j < n; ++j) {
            const double *R = f->root;
            row += fabs(R[(size_t)k * (size_t)n + (size_t)j]) * sqrt(f->Mf[j * (f->m + 1)]);
            column += fabs(R[(size_t)j * (size_t)n + (size_t)k]) * sqrt(f->Mf[k * (f->m + 1)]);
        }
        rows = fmax(rows, row), columns = fmax(columns, column);
    }
    return rows * columns;
}

static bool is_diagonal(const mbsr_flex *f)
{
    for (int b = 0; b < f->n; ++b) {
        for (int a = 0; a < b; ++a) {
            const double size = sqrt(f->Mf[a * (f->m + 1)]) * sqrt(f->Mf[b * (f->m + 1)]);
            if (fabs(f->Mf[b * f->m + a]) > DBL_EPSILON * size) return false;
        }
    }
    return true;
}

void mbsri_flex_find_root(mbsr_flex *f)
{
    f->massive = 0;
    for (int a = 0; a < f->n; ++a) f->massive += f->Mf[a * (f->m + 1)] > 0.0;
    if (f->r > 0 || !fill_root(f, f->root)) {
        f->root = NULL;
        return;
    }
    f->spread = spread_of(f);
    f->diagonal = is_diagonal(f);
}

void mbsri_flex_to_unit_masses(const mbsr_flex *f, int columns, const double *x, double *y)
{
    const int n = f->n;
    for (int c = 0; c < columns; ++c, x += n, y += n) {
        if (f->diagonal) {
            for (int k = 0; k < n; ++k) y[k] = f->root[k * (n + 1)] * x[k];
            continue;
        }
        int k = 0;
        for (; k < n - 1; k += 2) { /* the second column is one longer */
            const double *r = f->root + k * n;
            mbsri_dot_two_long(k + 1, r, r + n, x, y + k, y + k + 1);
            y[k + 1] += r[n + k + 1] * x[k + 1];
        }
        if (k < n) y[k] = mbsri_dot(k + 1, f->root + k * n, x);
    }
}

void mbsri_flex_from_unit_masses(const mbsr_flex *f, const double *x, double *y)
{
    const int n = f->n;
    if (f->diagonal) {
        for (int k = 0; k < n; ++k) y[k] = f->root[k * (n + 1)] * x[k];
        return;
    }
    mbsri_zero((size_t)n, y);
    int k = 0;
    for (; k < n - 1; k += 2) {
        const double *r = f->root + k * n;
        mbsri_add_two_long(k + 1, r, x[k], r + n, x[k + 1], y);
        y[k + 1] += r[n + k + 1] * x[k + 1];
    }
    if (k < n) mbsri_ax(k + 1, 1, x[k], f->root + k * n, &(double){1.0}, y);
}
