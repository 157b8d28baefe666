/* Tables as functions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "tables/table.h"

#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "tables/slopes.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { MOST_COLUMNS = 256 };

struct mbsr_table {
    mbsr_allocator allocator;
    int points, columns;
    mbsr_table_kind kind;
    mbsr_table_beyond beyond;
    double *x; /* points */
    double *value,
        *slope; /* points x columns; linear tables: slope of the piece that begins there */
    double number[];
};

mbsr_table_def mbsr_default_table_def(void)
{
    return (mbsr_table_def){.cookie = MBSRI_COOKIE, .columns = 1};
}

int mbsr_table_definition(const mbsr_table *table, mbsr_table_def *data)
{
    if (!table || !data) return MBSR_ERR_NULL;
    *data = (mbsr_table_def){.cookie = MBSRI_COOKIE,
                             .points = table->points,
                             .x = table->x,
                             .columns = table->columns,
                             .value = table->value,
                             .kind = table->kind,
                             .beyond = table->beyond,
                             .allocator = table->allocator};
    return MBSR_OK;
}

int mbsri_table_columns(const mbsr_table *table)
{
    return table ? table->columns : -1;
}

int mbsri_table_refuse(const mbsr_table *table, int columns, char text[MBSR_TEXT_SIZE])
{
    if (!table) {
        mbsri_print(text, MBSR_TEXT_SIZE, "user is NULL, must be the table");
        return MBSR_ERR_NULL;
    }
    mbsri_print(text, MBSR_TEXT_SIZE, "its table has %d columns, must have %d", table->columns,
                columns);
    return MBSR_ERR_VALUE;
}

/* ---- creation ---- */

static int check_points(const mbsr_table_def *def, mbsr_error *error)
{
    for (int k = 0; k < def->points; ++k) {
        if (!isfinite(def->x[k]))
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_table_create: x[%d] is %g", k, def->x[k]);
        if (k > 0 && !(def->x[k] > def->x[k - 1])) {
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_table_create: x[%d] is %.17g, not above x[%d], which is %.17g",
                              k, def->x[k], k - 1, def->x[k - 1]);
        }
        for (int c = 0; c < def->columns; ++c) {
            const double value = def->value[(size_t)k * (size_t)def->columns + (size_t)c];
            if (isfinite(value)) continue;
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_table_create: value[%d] is %g (point %d, column %d)",
                              k * def->columns + c, value, k, c);
        }
    }
    return MBSR_OK;
}

static int check_table_def(const mbsr_table_def *def, mbsr_error *error)
{
    if (def->cookie != MBSRI_COOKIE) {
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: def was not made by mbsr_default_table_def");
    }
    if (def->points < 2)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: points is %d, must be 2 or more", def->points);
    if (def->columns < 1 || def->columns > MOST_COLUMNS) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: columns is %d, must be 1 .. %d", def->columns,
                          MOST_COLUMNS);
    }
    if ((int)def->kind < MBSR_TABLE_LINEAR || (int)def->kind > MBSR_TABLE_SPLINE) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: kind is %d, must be LINEAR, MONOTONE or SPLINE",
                          (int)def->kind);
    }
    if ((int)def->beyond < MBSR_TABLE_CONSTANT || (int)def->beyond > MBSR_TABLE_REFUSE) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: beyond is %d, must be CONSTANT, STRAIGHT or REFUSE",
                          (int)def->beyond);
    }
    if (!def->x || !def->value) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: %s is NULL", !def->x ? "x" : "value");
    }
    if ((def->allocator.allocate == NULL) != (def->allocator.release == NULL)) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: allocator has one of its two functions only");
    }
    return check_points(def, error);
}

/* work: points numbers. */
static int find_point_slopes(mbsr_table *t, double *work, mbsr_error *error)
{
    const int n = t->points, columns = t->columns;
    for (int c = 0; c < columns; ++c) {
        double *m = t->slope + c, *v = t->value + c;
        if (t->kind == MBSR_TABLE_MONOTONE) mbsri_monotone_slopes(n, columns, t->x, v, m);
        if (t->kind == MBSR_TABLE_SPLINE) mbsri_spline_slopes(n, columns, t->x, v, m, work);
        if (t->kind == MBSR_TABLE_LINEAR) mbsri_secants(n, columns, t->x, v, m);
        for (int k = 0; k < n; ++k) {
            if (isfinite(m[(ptrdiff_t)k * columns])) continue;
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_table_create: the slope at x[%d] = %.17g, column %d, overflows",
                              k, t->x[k], c);
        }
    }
    return MBSR_OK;
}

int mbsr_table_create(const mbsr_table_def *def, mbsr_table **table, mbsr_error *error)
{
    if (table) *table = NULL;
    if (!def || !table) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: %s is NULL", !def ? "def" : "table");
    }
    int status = check_table_def(def, error);
    if (status) return status;
    const size_t n = (size_t)def->points, entries = n * (size_t)def->columns;
    mbsr_table *t =
        mbsri_allocate(&def->allocator, sizeof *t + (2 * n + 2 * entries) * sizeof(double));
    if (!t) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_table_create: no memory for %d points", def->points);
    }
    t->allocator = def->allocator;
    t->points = def->points;
    t->columns = def->columns;
    t->kind = def->kind;
    t->beyond = def->beyond;
    t->x = t->number;
    t->value = t->x + n;
    t->slope = t->value + entries;
    memcpy(t->x, def->x, n * sizeof *t->x);
    memcpy(t->value, def->value, entries * sizeof *t->value);
    status = find_point_slopes(t, t->slope + entries, error);
    if (status)
        mbsr_table_destroy(t);
    else
        *table = t;
    return status;
}

void mbsr_table_destroy(mbsr_table *table)
{
    if (!table) return;
    const mbsr_allocator allocator = table->allocator;
    mbsri_release(&allocator, table);
}

/* ---- values ---- */

/* The first point above x; `points` if there is none. */
static int find_above(const mbsr_table *t, double x)
{
    int low = 0, high = t->points;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (t->x[middle] > x)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* The piece with x[k] <= x < x[k + 1]; those at the ends go on. */
static int find_piece(const mbsr_table *t, double x)
{
    const int k = find_above(t, x) - 1;
    return k < 0 ? 0 : k > t->points - 2 ? t->points - 2 : k;
}

/* Value and derivatives of column c at x in piece k: v + s (m + s (c2 + s c3)), s = x - x[k]. */
static void at(const mbsr_table *t, int k, int c, double x, double out[3])
{
    const ptrdiff_t left = (ptrdiff_t)k * t->columns + c, right = left + t->columns;
    const double h = t->x[k + 1] - t->x[k], s = x - t->x[k], m = t->slope[left],
                 d = (t->value[right] - t->value[left]) / h;
    const bool straight = t->kind == MBSR_TABLE_LINEAR;
    const double c2 = straight ? 0.0 : (3.0 * d - 2.0 * m - t->slope[right]) / h,
                 c3 = straight ? 0.0 : (m + t->slope[right] - 2.0 * d) / (h * h);
    out[0] = t->value[left] + s * (m + s * (c2 + s * c3));
    out[1] = m + s * (2.0 * c2 + s * 3.0 * c3);
    out[2] = 2.0 * c2 + 6.0 * s * c3;
}

/* The same anywhere; `end`: -1 before the first point, 1 behind the last, else 0. */
static void column_at(const mbsr_table *t, int k, int end, int c, double x, double out[3])
{
    if (end == 0) {
        at(t, k, c, x, out);
        return;
    }
    const int point = end < 0 ? 0 : t->points - 1;
    const bool straight = t->beyond == MBSR_TABLE_STRAIGHT;
    const ptrdiff_t entry = (ptrdiff_t)point * t->columns + c;
    out[1] = straight ? t->slope[entry] : 0.0;
    out[0] = t->value[entry] + (straight ? out[1] * (x - t->x[point]) : 0.0);
    out[2] = 0.0;
}

int mbsr_table_value(const mbsr_table *table, double x, double *value, double *first,
                     double *second)
{
    const mbsr_table *t = table;
    if (!t) return MBSR_ERR_NULL;
    if (!isfinite(x)) return MBSR_NOT_FINITE;
    const int end = x < t->x[0] ? -1 : x > t->x[t->points - 1] ? 1 : 0;
    if (end != 0 && t->beyond == MBSR_TABLE_REFUSE) return MBSR_ERR_VALUE;
    const int k = find_piece(t, x);
    for (int write = 0; write < 2; ++write) {
        for (int c = 0; c < t->columns; ++c) {
            double out[3];
            column_at(t, k, end, c, x, out);
            if (!isfinite(out[0]) || !isfinite(out[1]) || !isfinite(out[2])) return MBSR_NOT_FINITE;
            if (write && value) value[c] = out[0];
            if (write && first) first[c] = out[1];
            if (write && second) second[c] = out[2];
        }
    }
    return MBSR_OK;
}

/* ---- kinks ---- */

/* The lowest derivative that jumps at point k; 0: none. Lines whose slopes differ by rounding are
 * one. */
static int jumps(const mbsr_table *t, int k)
{
    const bool end = k == 0 || k == t->points - 1, linear = t->kind == MBSR_TABLE_LINEAR;
    if (end && t->beyond == MBSR_TABLE_REFUSE) return 1;
    for (int c = 0; c < t->columns && (linear || end); ++c) {
        const double *m = t->slope + (ptrdiff_t)k * t->columns + c;
        const double right = *m, left = end ? 0.0 : m[-(ptrdiff_t)t->columns];
        if (end && t->beyond == MBSR_TABLE_STRAIGHT) continue;
        if (fabs(right - left) > 1e-12 * (fabs(right) + fabs(left))) return 1;
    }
    return linear ? 0 : end || t->kind == MBSR_TABLE_MONOTONE ? 2 : 3;
}

int mbsr_table_kink(const mbsr_table *table, double x, int direction, double *next, int *derivative)
{
    const mbsr_table *t = table;
    if (!t || !next || !derivative) return MBSR_ERR_NULL;
    if (isnan(x)) return MBSR_NOT_FINITE;
    if (direction != 1 && direction != -1) return MBSR_ERR_VALUE;
    int k = find_above(t, x);
    if (direction < 0) k -= k > 0 && t->x[k - 1] == x ? 2 : 1;
    while (k >= 0 && k < t->points && jumps(t, k) == 0) k += direction;
    const bool found = k >= 0 && k < t->points;
    *next = found ? t->x[k] : direction > 0 ? INFINITY : -INFINITY;
    *derivative = found ? jumps(t, k) : 1;
    return MBSR_OK;
}

/* ---- as motions and forces ---- */

int mbsr_table_motion(void *table, double t, double *s, double *sdot, double *sddot)
{
    return mbsr_table_value(table, t, s, sdot, sddot);
}

int mbsr_table_force(void *table, double t, int n, double *value)
{
    const mbsr_table *of = table;
    if (of && n != of->columns) return MBSR_ERR_VALUE;
    return mbsr_table_value(of, t, value, NULL, NULL);
}
