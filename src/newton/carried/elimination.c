/* A front: see elimination.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/elimination.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

typedef mbsri_elimination elimination;

void mbsri_elimination_begin(elimination *e)
{
    e->done = 0;
    for (int k = 0; k < e->size; ++k) e->row[k] = e->column[k] = k;
}

static double *entry(const elimination *e, int i, int j)
{
    return e->M + (size_t)j * (size_t)e->rows + i;
}

static int row_kind(const elimination *e, int i)
{
    return e->row_kind[e->row[i]];
}

static int column_kind(const elimination *e, int j)
{
    return e->column_kind[e->column[j]];
}

/* Entry (i, j) goes to the next place of the diagonal, and is eliminated. */
static void pivot(elimination *e, int i, int j)
{
    const int k = e->done++, size = e->rows, row = e->row[i], column = e->column[j];
    e->row[i] = e->row[k];
    e->row[k] = row;
    e->column[j] = e->column[k];
    e->column[k] = column;
    for (int l = 0; l < size && j != k; ++l) {
        const double x = *entry(e, l, j);
        *entry(e, l, j) = *entry(e, l, k);
        *entry(e, l, k) = x;
    }
    for (int l = 0; l < e->columns && i != k; ++l) {
        const double x = *entry(e, i, l);
        *entry(e, i, l) = *entry(e, k, l);
        *entry(e, k, l) = x;
    }
    double *factor = entry(e, 0, k);
    for (int l = k + 1; l < size; ++l) factor[l] /= factor[k];
    for (int l = k + 1; l < e->columns; ++l) {
        double *to = entry(e, 0, l);
        const double x = to[k];
        if (x == 0.0) continue;
        for (int r = k + 1; r < size; ++r) to[r] -= factor[r] * x;
    }
}

static double scaled(const elimination *e, int i, int j)
{
    return fabs(*entry(e, i, j)) * e->row_scale[e->row[i]] * e->column_scale[e->column[j]];
}

/* ---- loops that close ---- */

static double largest_in_row(const elimination *e, int i)
{
    double largest = 0.0;
    for (int j = e->done; j < e->size; ++j) {
        const double x = fabs(*entry(e, i, j)) * e->column_scale[e->column[j]];
        largest = x > largest ? x : largest;
    }
    return largest;
}

static double largest_in_column(const elimination *e, int j)
{
    double largest = 0.0;
    const double *column = entry(e, 0, j);
    for (int i = e->done; i < e->size; ++i) {
        const double x = fabs(column[i]) * e->row_scale[e->row[i]];
        largest = x > largest ? x : largest;
    }
    return largest;
}

/* A scale, whose largest entry without it this is, becomes nearer to what makes that 1: by the
 * root, so that neither side gets all of it, or exactly. True: it was within a factor 2. */
static bool adjust(double *scale, double largest, bool exactly)
{
    if (!(largest > 0.0)) return true;
    const double all = largest * *scale;
    *scale /= exactly ? all : sqrt(all);
    return all > 0.5 && all < 2.0;
}

/* Scales of all rows and columns that are left, so that the largest entry of each is about 1; with
 * those that wait, lest rounding errors beside them look large. */
static void equilibrate(elimination *e)
{
    for (int k = e->done; k < e->size; ++k)
        e->row_scale[e->row[k]] = e->column_scale[e->column[k]] = 1.0;
    bool last = false;
    for (int round = 0; round < 6; ++round) {
        bool even = true;
        const bool exactly = last || round == 5;
        for (int i = e->done; i < e->size; ++i)
            even = adjust(e->row_scale + e->row[i], largest_in_row(e, i), exactly) && even;
        for (int j = e->done; j < e->size; ++j)
            even = adjust(e->column_scale + e->column[j], largest_in_column(e, j), exactly) && even;
        if (exactly) return;
        last = even;
    }
}

/* Whether the entry, of a direction and a row of velocities that closes, is far smaller than those
 * of rows that wait: then these will hold it. */
static bool weak(const elimination *e, int i, int j)
{
    const bool row = row_kind(e, i) == MBSRI_HELD; /* of the balance, else of the motion */
    const double *units = row ? e->column_unit : e->row_unit;
    const int *number = row ? e->column : e->row;
    const double unit = units[number[row ? j : i]];
    double most = 0.0;
    if (!(unit > 0.0)) return true;
    for (int l = e->done; l < e->size; ++l) {
        const double other = units[number[l]];
        if ((row ? column_kind(e, l) : row_kind(e, l)) != MBSRI_WAITS || !(other > 0.0)) continue;
        most = fmax(most, fabs(row ? *entry(e, i, l) : *entry(e, l, j)) / other);
    }
    return fabs(*entry(e, i, j)) / unit < 1e-3 * most;
}

/* Whether entry (i, j) may be a pivot while others wait. A direction goes with a row of velocities
 * that holds it; one that none holds by then goes later. */
static bool settled(const elimination *e, int i, int j)
{
    const bool row = row_kind(e, i) == MBSRI_HELD, column = column_kind(e, j) == MBSRI_HELD;
    if (row && column) return false;
    return !(row || column) || !weak(e, i, j);
}

/* The largest entry that may be a pivot; false: there is none that is not rounding. */
static bool find(const elimination *e, bool strict, int *row, int *column)
{
    double largest = 1e-13;
    *row = -1;
    for (int j = e->done; j < e->size; ++j) {
        if (column_kind(e, j) == MBSRI_WAITS) continue;
        for (int i = e->done; i < e->size; ++i) {
            if (row_kind(e, i) == MBSRI_WAITS || !(scaled(e, i, j) > largest)) continue;
            if (strict && !settled(e, i, j)) continue;
            largest = scaled(e, i, j);
            *row = i;
            *column = j;
        }
    }
    return *row >= 0;
}

bool mbsri_eliminate_held(elimination *e, int delayed)
{
    int left = 0, row, column;
    bool waits = false, closes = false;
    for (int k = e->done; k < e->size; ++k) {
        waits = waits || row_kind(e, k) == MBSRI_WAITS;
        closes = closes || row_kind(e, k) == MBSRI_CLOSES;
        left += row_kind(e, k) != MBSRI_WAITS;
    }
    const int most = waits ? delayed : 0;
    if (left == 0 || (!closes && left <= most)) return true;
    equilibrate(e);
    while (left > 0) {
        bool found = find(e, waits, &row, &column);
        if (!found && left > most) found = find(e, false, &row, &column);
        if (!found) return left <= most;
        pivot(e, row, column);
        --left;
    }
    return true;
}
