/* Pivots of a front: see pivots.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rows and columns are scaled so that the largest sums in N are about 1, and the largest entry of M
 * so scaled is the next pivot: relative to what was added up in it, whatever the units. What is
 * small, since terms cancel, is left to a later front, where more is known: a massless direction
 * that a loop holds, a multiplier with too few rates passed, an inertia that a spring of negative
 * stiffness takes away.
 *
 * What is left of an entry is told from zero by what was added up in that entry, not by the rest of
 * its row and column: beside a mass, a spring is K / (c^2 M), which is below rounding for a large c
 * or in units of short times, and all that determines a direction without mass. */
#include "newton/front/pivots.h"

#include "algebra/dense.h"
#include "newton/front/front.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

typedef mbsri_front_pivots pivots;

enum { ROUNDS = 6 };

static const double good = 1e-3, fair = 1e-6, rounding = 64.0 * DBL_EPSILON, noise = 1e-13;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double *entry(const pivots *p, double *A, int i, int j)
{
    return A + (size_t)j * (size_t)p->stride + i;
}

static int row_kind(const pivots *p, int i)
{
    return p->row_kind[p->row[i]];
}

static int column_kind(const pivots *p, int j)
{
    return p->column_kind[p->column[j]];
}

static void swap(double *a, double *b)
{
    const double x = *a;
    *a = *b;
    *b = x;
}

static void swap_numbers(int *list, int a, int b)
{
    const int x = list[a];
    list[a] = list[b];
    list[b] = x;
}

/* Exchanges rows i, k and columns j, k of A. */
static void exchange(const pivots *p, double *A, int rows, int columns, int i, int j, int k)
{
    for (int l = 0; l < rows && j != k; ++l) swap(entry(p, A, l, j), entry(p, A, l, k));
    for (int l = 0; l < columns && i != k; ++l) swap(entry(p, A, i, l), entry(p, A, k, l));
}

/* Entry (i, j) goes to the next place of the diagonal, and is eliminated: in columns of unknowns,
 * and in all where the front is watched. */
static void pivot(pivots *p, int i, int j)
{
    const int k = p->done++, columns = p->watched ? p->columns : p->size;
    exchange(p, p->M, p->rows, p->columns, i, j, k);
    exchange(p, p->N, p->watched ? p->rows : p->size, p->watched ? p->columns : p->size, i, j, k);
    swap_numbers(p->row, i, k);
    swap_numbers(p->column, j, k);
    swap(p->row_scale + i, p->row_scale + k);
    swap(p->column_scale + j, p->column_scale + k);
    double *factor = entry(p, p->M, 0, k);
    const double by = 1.0 / factor[k];
    for (int l = k + 1; l < p->rows; ++l) factor[l] *= by;
    for (int l = k + 1; l < columns; ++l) {
        double *to = entry(p, p->M, 0, l);
        const double x = to[k];
        if (x == 0.0) continue;
        for (int r = k + 1; r < p->rows; ++r) to[r] -= factor[r] * x;
    }
}

/* Subtracts `count` columns, 4 at most, times the numbers x, from y: one after the other. */
static void subtract(int rows, int count, const double *const column[4], const double x[4],
                     double *y)
{
    if (count == 4) {
        mbsri_subtract_four(rows, column, x, y);
        return;
    }
    for (int k = 0; k < count; ++k) {
        for (int l = 0; l < rows; ++l) y[l] -= column[k][l] * x[k];
    }
}

/* The columns of the border, each once for all pivots. */
static void pivot_border(const pivots *p)
{
    const int done = p->done;
    for (int l = p->size; l < p->columns; ++l) {
        double *to = entry(p, p->M, 0, l);
        const double *column[4];
        double x[4];
        int count = 0;
        for (int k = 0; k < done; ++k) {
            const double *factor = entry(p, p->M, 0, k);
            if (to[k] == 0.0) continue;
            for (int r = k + 1; r < done; ++r) to[r] -= factor[r] * to[k];
            column[count] = factor + done;
            x[count++] = to[k];
            if (count < 4) continue;
            subtract(p->rows - done, count, column, x, to + done);
            count = 0;
        }
        subtract(p->rows - done, count, column, x, to + done);
    }
}

/* As the elimination of pivot k changed M, what is added up in N. */
static void add_up(pivots *p, int k)
{
    const double *factor = entry(p, p->M, 0, k);
    const int columns = p->watched ? p->columns : p->size;
    for (int l = k + 1; l < columns; ++l) {
        const double x = fabs(*entry(p, p->M, k, l));
        const int rows = p->watched && (l < p->size || p->lacks_mass) ? p->rows : p->size;
        double *to = entry(p, p->N, 0, l);
        for (int r = k + 1; r < rows && x > 0.0; ++r) to[r] += fabs(factor[r]) * x;
    }
}

static bool together(int row, int column)
{
    if (row == MBSRI_FRONT_PLACE || column == MBSRI_FRONT_PLACE) return row == column;
    if (row == MBSRI_FRONT_ETA || column == MBSRI_FRONT_ETA) return row == column;
    return (row == MBSRI_FRONT_OWN || row == MBSRI_FRONT_LAMBDA) &&
           (column == MBSRI_FRONT_OWN || column == MBSRI_FRONT_LAMBDA);
}

static double scaled(const pivots *p, int i, int j)
{
    return fabs(*entry(p, p->M, i, j)) * p->row_scale[i] * p->column_scale[j];
}

/* The largest entry above `least` that may be a pivot, of q' alone or of the rest; false: there is
 * none. */
static bool find(const pivots *p, bool places, double least, int *row, int *column)
{
    *row = -1;
    for (int j = p->done; j < p->size; ++j) {
        for (int i = p->done; i < p->size; ++i) {
            if (!(scaled(p, i, j) > least) || !together(row_kind(p, i), column_kind(p, j)) ||
                places != (row_kind(p, i) == MBSRI_FRONT_PLACE))
                continue;
            least = scaled(p, i, j);
            *row = i;
            *column = j;
        }
    }
    return *row >= 0;
}

/* The largest of those of which more than rounding is left, however small beside its row and
 * column: what is small from the beginning, since nothing moves the mass, cancels nowhere. Where
 * rounding of those that go together has decided otherwise, eta and lambda may be left of each
 * other's rows. */
static bool find_whole(const pivots *p, int *row, int *column)
{
    double least = 0.0;
    *row = -1;
    for (int j = p->done; j < p->size && p->watched; ++j) {
        for (int i = p->done; i < p->size; ++i) {
            if (!(scaled(p, i, j) > least) || row_kind(p, i) == MBSRI_FRONT_PLACE ||
                column_kind(p, j) == MBSRI_FRONT_PLACE ||
                !(fabs(*entry(p, p->M, i, j)) > noise * *entry(p, p->N, i, j)))
                continue;
            least = scaled(p, i, j);
            *row = i;
            *column = j;
        }
    }
    return *row >= 0;
}

/* ---- q' ---- */

/* Scales of the rows q' along dq alone. */
static void scale_places(pivots *p)
{
    for (int i = 0; i < p->size; ++i) p->row_scale[i] = 0.0;
    for (int j = 0; j < p->size; ++j) {
        for (int i = 0; i < p->size && column_kind(p, j) == MBSRI_FRONT_PLACE; ++i)
            p->row_scale[i] = larger(p->row_scale[i], *entry(p, p->N, i, j));
    }
    for (int i = 0; i < p->size; ++i) {
        p->row_scale[i] = p->row_scale[i] > 0.0 ? 1.0 / p->row_scale[i] : 0.0;
        p->column_scale[i] = 1.0;
    }
}

/* dq goes first: c - d(q')/dq is small beside c for an unlucky c, or where a loop, whose rows other
 * places have taken, leaves nothing of it. It is a pivot again when more has been passed. */
static void eliminate_places(pivots *p)
{
    int row, column;
    scale_places(p);
    while (find(p, true, rounding, &row, &column)) {
        pivot(p, row, column);
        add_up(p, p->done - 1);
    }
}

/* ---- scales ---- */

/* A scale whose largest entry without it this is becomes nearer to what makes that 1. */
static bool adjust(double *scale, double largest, bool exactly)
{
    if (!(largest > 0.0)) return true;
    const double all = largest * *scale;
    *scale /= exactly ? all : sqrt(all);
    return all > 0.5 && all < 2.0;
}

/* N becomes how large an entry is, or was before terms cancelled. */
static void take_sizes(pivots *p, int rows, int columns)
{
    for (int j = p->done; j < columns; ++j) {
        const double *M = entry(p, p->M, 0, j);
        double *N = entry(p, p->N, 0, j);
        for (int i = p->done; i < rows; ++i) N[i] = larger(fabs(M[i]), N[i]);
    }
}

static bool adjust_rows(pivots *p, int rows, int columns, bool exactly)
{
    bool even = true;
    for (int i = p->done; i < rows; ++i) p->largest[i] = 0.0;
    for (int j = p->done; j < columns; ++j) {
        const double *N = entry(p, p->N, 0, j), scale = p->column_scale[j];
        for (int i = p->done; i < rows; ++i) p->largest[i] = larger(N[i] * scale, p->largest[i]);
    }
    for (int i = p->done; i < rows; ++i)
        even = adjust(p->row_scale + i, p->largest[i], exactly) && even;
    return even;
}

/* The largest of n products. Four at a time: one alone would wait for the last. */
static double largest_product(int n, const double *x, const double *y)
{
    double most[4] = {0.0};
    int i = 0;
    for (; i + 4 <= n; i += 4) {
        for (int l = 0; l < 4; ++l) most[l] = larger(x[i + l] * y[i + l], most[l]);
    }
    for (; i < n; ++i) most[0] = larger(x[i] * y[i], most[0]);
    return larger(larger(most[0], most[1]), larger(most[2], most[3]));
}

static bool adjust_columns(pivots *p, int rows, int columns, bool exactly)
{
    const int done = p->done;
    bool even = true;
    for (int j = done; j < columns; ++j) {
        const double *N = entry(p, p->N, done, j);
        const double largest = largest_product(rows - done, N, p->row_scale + done);
        even = adjust(p->column_scale + j, largest, exactly) && even;
    }
    return even;
}

/* Of a watched front with the border, lest what is nothing beside that looks large. */
static void equilibrate(pivots *p)
{
    const int rows = p->watched ? p->rows : p->size, columns = p->watched ? p->columns : p->size;
    for (int i = p->done; i < rows; ++i) p->row_scale[i] = 1.0;
    for (int j = p->done; j < columns; ++j) p->column_scale[j] = 1.0;
    bool last = columns == p->done + 1;
    take_sizes(p, rows, columns);
    for (int round = 0; round < ROUNDS; ++round) {
        const bool exactly = last || round == ROUNDS - 1;
        const bool even_rows = adjust_rows(p, rows, columns, exactly),
                   even = adjust_columns(p, rows, columns, exactly) && even_rows;
        if (exactly) return;
        last = even;
    }
}

/* ---- the rest ---- */

/* What is left of what has cancelled becomes zero, in the rows and columns of unknowns. */
static void flush(pivots *p)
{
    for (int j = p->done; j < p->columns; ++j) {
        const int rows = j < p->size ? p->rows : p->size;
        double *M = entry(p, p->M, 0, j);
        const double *N = entry(p, p->N, 0, j);
        for (int i = p->done; i < rows; ++i) M[i] = fabs(M[i]) < noise * N[i] ? 0.0 : M[i];
    }
}

/* In the border only what rounding alone leaves: springs that dampers outweigh stand there as well.
 */
static void flush_border(pivots *p)
{
    for (int j = p->size; j < p->columns && p->lacks_mass; ++j) {
        double *M = entry(p, p->M, 0, j);
        const double *N = entry(p, p->N, 0, j);
        for (int i = p->size; i < p->rows; ++i) M[i] = fabs(M[i]) < rounding * N[i] ? 0.0 : M[i];
    }
}

/* A row that is nothing along the unknowns, and whose rest is nothing beside what was added up in
 * it. */
static void flush_row(pivots *p, int i)
{
    double left = 0.0, sum = 0.0;
    for (int j = p->done; j < p->columns; ++j) {
        const double size = fabs(*entry(p, p->M, i, j)), scale = p->column_scale[j];
        if (j < p->size && size > 0.0) return;
        left = larger(left, size * scale);
        sum = larger(sum, *entry(p, p->N, i, j) * scale);
    }
    for (int j = p->size; j < p->columns && left < noise * sum; ++j) *entry(p, p->M, i, j) = 0.0;
}

/* Likewise. */
static void flush_column(pivots *p, int j)
{
    double left = 0.0, sum = 0.0;
    for (int i = p->done; i < p->rows; ++i) {
        const double size = fabs(*entry(p, p->M, i, j)), scale = p->row_scale[i];
        if (i < p->size && size > 0.0) return;
        left = larger(left, size * scale);
        sum = larger(sum, *entry(p, p->N, i, j) * scale);
    }
    for (int i = p->size; i < p->rows && left < noise * sum; ++i) *entry(p, p->M, i, j) = 0.0;
}

bool mbsri_front_eliminate(pivots *p)
{
    const double least = p->scarce ? fair : good;
    int pending = 0, row, column;
    for (int j = 0; j < p->size; ++j) pending += column_kind(p, j) == MBSRI_FRONT_PENDING;
    p->done = 0;
    if (p->watched) flush(p);
    eliminate_places(p);
    equilibrate(p);
    while (p->size - p->done > pending) {
        bool found = find(p, false, least, &row, &column);
        if (!found && p->size - p->done - pending <= p->delayed) break;
        if (!found && !find(p, false, rounding, &row, &column) &&
            !find(p, true, rounding, &row, &column) && !find_whole(p, &row, &column))
            return false;
        pivot(p, row, column);
        if (p->watched) add_up(p, p->done - 1);
    }
    if (!p->watched) {
        pivot_border(p);
        return true;
    }
    flush(p);
    flush_border(p);
    for (int k = p->done; k < p->size; ++k) {
        flush_row(p, k);
        flush_column(p, k);
    }
    return true;
}
