/* Rank and null spaces of a matrix whose entries have errors: see reduction.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/reduction.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"

#include <float.h>
#include <math.h>

static const double clear = 10.0; /* how many times its error an entry has to be */

size_t mbsri_reduction_size(int n, int m)
{
    const size_t rows = (size_t)n, columns = (size_t)m, wide = rows + columns;
    return (2 * rows * wide + wide) * sizeof(double) +
           (2 * (rows < columns ? rows : columns) + columns) * sizeof(int) + wide * sizeof(bool);
}

void mbsri_reduction_place(mbsri_reduction *r, int n, int m, void *memory)
{
    const size_t rows = (size_t)n, columns = (size_t)m, wide = rows + columns,
                 most = rows < columns ? rows : columns;
    r->A = memory;
    r->error = r->A + rows * wide;
    r->rows = r->error + rows * wide;
    r->columns = r->rows + rows;
    r->pivot_row = (int *)(void *)(r->columns + columns);
    r->pivot_column = r->pivot_row + most;
    r->largest = r->pivot_column + most;
    r->row_taken = (bool *)(void *)(r->largest + columns);
    r->column_taken = r->row_taken + rows;
}

/* Notes the largest entry of column j in rows without pivot; of equal ones the last. */
static void find_largest(mbsri_reduction *r, int j)
{
    const double *a = r->A + j * r->n;
    double largest = 0.0;
    r->largest[j] = -1;
    for (int i = 0; i < r->n; ++i) {
        const double size = fabs(a[i]);
        if (r->row_taken[i] || size == 0.0 || size < (1.0 - 1e-9) * largest) continue;
        largest = size;
        r->largest[j] = i;
    }
}

/* Rows of A by their sizes, or to largest entries 1, then columns to largest entries 1, and the
 * errors likewise; beside it the unit matrix. */
static void prepare(mbsri_reduction *r, int n, int m, const double *sizes)
{
    r->n = n;
    r->m = m;
    r->rank = 0;
    for (int i = 0; i < n; ++i) {
        double size = 0.0;
        for (int j = 0; j < m && !sizes; ++j) size = fmax(size, fabs(r->A[j * n + i]));
        if (sizes) size = sizes[i];
        r->rows[i] = size > 0.0 ? 1.0 / size : 1.0;
        r->row_taken[i] = false;
    }
    for (int j = 0; j < m; ++j) {
        double *a = r->A + j * n, *e = r->error + j * n;
        for (int i = 0; i < n; ++i) a[i] *= r->rows[i], e[i] *= r->rows[i];
        const double size = mbsri_largest(n, a);
        r->columns[j] = size > 0.0 ? 1.0 / size : 1.0;
        for (int i = 0; i < n; ++i) a[i] *= r->columns[j], e[i] *= r->columns[j];
        r->column_taken[j] = false;
        find_largest(r, j);
    }
    mbsri_zero((size_t)n * (size_t)n, r->A + m * n);
    mbsri_zero((size_t)n * (size_t)n, r->error + m * n);
    for (int i = 0; i < n; ++i) r->A[(m + i) * n + i] = 1.0;
}

/* The largest entry that is not error; of equal ones the last. */
static bool find_pivot(const mbsri_reduction *r, int *row, int *column)
{
    double largest = 0.0;
    for (int j = 0; j < r->m; ++j) {
        if (r->column_taken[j] || r->largest[j] < 0) continue;
        const double size = fabs(r->A[j * r->n + r->largest[j]]);
        if (size < (1.0 - 1e-9) * largest) continue;
        largest = size;
        *row = r->largest[j];
        *column = j;
    }
    return largest > 0.0;
}

/* Column j of all rows but p less their numbers `factor` times that of row p, with the errors
 * `doubt` of the factors. */
static void subtract(mbsri_reduction *r, int j, int p, const double *factor, const double *doubt,
                     double small)
{
    double *a = r->A + j * r->n, *e = r->error + j * r->n;
    const double pivot = a[p], pivot_error = e[p];
    if (pivot == 0.0 && pivot_error == 0.0) return;
    for (int i = 0; i < r->n; ++i) {
        if (i == p || (factor[i] == 0.0 && doubt[i] == 0.0)) continue;
        const double part = factor[i] * pivot, size = fabs(a[i]) + fabs(part);
        if (part == 0.0 && pivot_error == 0.0) continue;
        a[i] -= part;
        e[i] += fabs(factor[i]) * pivot_error + doubt[i] * fabs(pivot) + DBL_EPSILON * size;
        if (fabs(a[i]) <= clear * e[i] || fabs(a[i]) <= small * size) a[i] = 0.0;
    }
    if (j < r->m) find_largest(r, j);
}

void mbsri_reduce(mbsri_reduction *r, int n, int m, int most, double small, const double *sizes)
{
    int p = 0, c = 0;
    prepare(r, n, m, sizes);
    while (r->rank < most && find_pivot(r, &p, &c)) {
        double *a = r->A + c * n, *e = r->error + c * n;
        const double pivot = a[p], share = e[p] / fabs(pivot);
        r->row_taken[p] = r->column_taken[c] = true;
        r->pivot_row[r->rank] = p;
        r->pivot_column[r->rank++] = c;
        for (int j = 0; j < n + m; ++j) {
            double *x = r->A + j * n + p, *x_error = r->error + j * n + p;
            *x /= pivot;
            *x_error = *x_error / fabs(pivot) + share * fabs(*x);
        }
        for (int j = 0; j < n + m; ++j) {
            if (j >= m || !r->column_taken[j]) subtract(r, j, p, a, e, small);
        }
        for (int i = 0; i < n; ++i) {
            if (i != p) a[i] = 0.0;
        }
    }
}

/* Number l of `count` rows or columns that are not taken. */
static int free_place(int count, const bool *taken, int l)
{
    int at = 0;
    for (; at < count; ++at) {
        if (!taken[at] && l-- == 0) break;
    }
    return at;
}

void mbsri_right_null(const mbsri_reduction *r, int l, double *z, double *error)
{
    const int n = r->n, j = free_place(r->m, r->column_taken, l);
    mbsri_zero((size_t)r->m, z);
    if (error) mbsri_zero((size_t)r->m, error);
    z[j] = r->columns[j];
    for (int k = 0; k < r->rank; ++k) {
        const int at = j * n + r->pivot_row[k], c = r->pivot_column[k];
        z[c] = -r->A[at] * r->columns[c];
        if (error) error[c] = r->error[at] * r->columns[c];
    }
}

/* Row i of L, of the unscaled A. */
static void left_row(const mbsri_reduction *r, int i, double *y, double *error)
{
    for (int k = 0; k < r->n; ++k) {
        const int at = (r->m + k) * r->n + i;
        y[k] = r->A[at] * r->rows[k];
        if (error) error[k] = r->error[at] * r->rows[k];
    }
}

void mbsri_left_null(const mbsri_reduction *r, int l, double *y, double *error)
{
    left_row(r, free_place(r->n, r->row_taken, l), y, error);
}

void mbsri_left_pivot(const mbsri_reduction *r, int l, double *y)
{
    left_row(r, r->pivot_row[l], y, NULL);
}

void mbsri_row_space(const mbsri_reduction *r, int l, double *rho)
{
    for (int j = 0; j < r->m; ++j) {
        rho[j] = r->column_taken[j] ? 0.0 : r->A[j * r->n + r->pivot_row[l]] * r->columns[j];
    }
    rho[r->pivot_column[l]] = r->columns[r->pivot_column[l]];
}
