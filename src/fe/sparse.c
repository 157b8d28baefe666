/* Symmetric sparse matrices: see sparse.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Entries are sorted by two passes of counting, first by row, then by column, and equal ones are
 * added. */
#include "fe/sparse.h"

#include "algebra/dense.h"
#include "base/error.h"

#include <limits.h>
#include <math.h>

static const double symmetric = 1e-9;

/* Entries as coordinates, in the lower triangle. */
typedef struct triplets {
    int count;
    int *row, *column;
    double *value;
} triplets;

static bool open_triplets(mbsri_arena *arena, size_t count, triplets *t)
{
    t->count = 0;
    t->row = mbsri_arena_take(arena, count * sizeof *t->row);
    t->column = mbsri_arena_take(arena, count * sizeof *t->column);
    t->value = mbsri_arena_take(arena, count * sizeof *t->value);
    return t->value != NULL;
}

static void add_triplet(triplets *t, int row, int column, double value)
{
    t->row[t->count] = row;
    t->column[t->count] = column;
    t->value[t->count++] = value;
}

/* to = from, stably sorted by key, which is 0 .. n - 1; at: n + 1 */
static void sort_by(int n, const int *key, const triplets *from, int *at, triplets *to)
{
    for (int k = 0; k <= n; ++k) at[k] = 0;
    for (int k = 0; k < from->count; ++k) ++at[key[k] + 1];
    for (int k = 0; k < n; ++k) at[k + 1] += at[k];
    for (int k = 0; k < from->count; ++k) {
        const int place = at[key[k]]++;
        to->row[place] = from->row[k];
        to->column[place] = from->column[k];
        to->value[place] = from->value[k];
    }
    to->count = from->count;
}

/* A of sorted entries. */
static void compress(int n, const triplets *t, mbsri_sparse *A)
{
    int used = 0, k = 0;
    A->n = n;
    for (int j = 0; j < n; ++j) {
        A->start[j] = used;
        A->row[used] = j;
        A->value[used++] = 0.0;
        for (; k < t->count && t->column[k] == j; ++k) {
            if (t->row[k] != A->row[used - 1]) {
                A->row[used] = t->row[k];
                A->value[used++] = 0.0;
            }
            A->value[used - 1] += t->value[k];
        }
    }
    A->start[n] = used;
}

/* A of the entries t, which are lost. */
static bool assemble(mbsri_arena *arena, int n, triplets *t, mbsri_sparse *A)
{
    mbsri_arena scratch;
    triplets sorted;
    const size_t most = (size_t)t->count + (size_t)n, columns = (size_t)n + 1;
    A->start = mbsri_arena_take(arena, columns * sizeof *A->start);
    A->row = mbsri_arena_take(arena, most * sizeof *A->row);
    A->value = mbsri_arena_take(arena, most * sizeof *A->value);
    mbsri_arena_open(&scratch, &arena->allocator);
    int *at = mbsri_arena_take(&scratch, columns * sizeof *at);
    const bool good = open_triplets(&scratch, (size_t)t->count, &sorted) && A->value;
    if (good) {
        sort_by(n, t->row, t, at, &sorted);
        sort_by(n, sorted.column, &sorted, at, t);
        compress(n, t, A);
    }
    mbsri_arena_close(&scratch);
    return good;
}

/* ---- what the caller gave ---- */

#define REFUSE(...) mbsri_fail_plain(error, MBSR_ERR_VALUE, "mbsr_fe_reduce: " __VA_ARGS__)

static int check_shape(const char *name, const mbsr_fe_matrix *A, mbsr_error *error)
{
    if (A->rows < 1 || A->entries > INT_MAX - (size_t)A->rows)
        return REFUSE(
            "%s.rows is %d, %s.entries %zu; they must be 1 or more, and at most %d in all", name,
            A->rows, name, A->entries, INT_MAX);
    if (!A->row || !A->value || (!A->start && !A->column))
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fe_reduce: %s.%s is NULL", name,
                                !A->row     ? "row"
                                : !A->value ? "value"
                                            : "start and column");
    if (!A->start) return MBSR_OK;
    if (A->start[0] != 0 || (size_t)A->start[A->rows] != A->entries)
        return REFUSE("%s.start goes from %d to %d, must go from 0 to %s.entries, %zu", name,
                      A->start[0], A->start[A->rows], name, A->entries);
    for (int j = 0; j < A->rows; ++j) {
        if (A->start[j] > A->start[j + 1])
            return REFUSE("%s.start[%d] is %d, less than the one before", name, j + 1,
                          A->start[j + 1]);
    }
    return MBSR_OK;
}

static int check_entry(const char *name, int n, int row, int column, double value,
                       mbsr_error *error)
{
    if (row < 0 || row >= n || column < 0 || column >= n)
        return REFUSE("%s has an entry at (%d,%d), but %d rows", name, row, column, n);
    if (!isfinite(value)) return REFUSE("%s(%d,%d) is %g", name, row, column, value);
    return MBSR_OK;
}

/* Shares the entries out: those below the diagonal, those above it transposed; the diagonal to
 * both. */
static int split_triangles(const char *name, const mbsr_fe_matrix *A, triplets *lower,
                           triplets *upper, mbsr_error *error)
{
    int j = 0;
    for (int k = 0; k < (int)A->entries; ++k) {
        while (A->start && A->start[j + 1] <= k) ++j;
        const int row = A->row[k], column = A->start ? j : A->column[k];
        const int status = check_entry(name, A->rows, row, column, A->value[k], error);
        if (status) return status;
        if (A->value[k] == 0.0) continue;
        if (row >= column) add_triplet(lower, row, column, A->value[k]);
        if (row <= column) add_triplet(upper, column, row, A->value[k]);
    }
    return MBSR_OK;
}

static double at_diagonal(const mbsri_sparse *A, int k)
{
    return fabs(A->value[A->start[k]]);
}

/* The value at (row, column) from place *k of that column on, 0 where there is none. */
static double look_up(const mbsri_sparse *A, int row, int column, int *k)
{
    while (*k < A->start[column + 1] && A->row[*k] < row) ++*k;
    return *k < A->start[column + 1] && A->row[*k] == row ? A->value[(*k)++] : 0.0;
}

/* A, the lower triangle, against B, the upper one transposed. */
static int compare_triangles(const char *name, const mbsri_sparse *A, const mbsri_sparse *B,
                             mbsr_error *error)
{
    for (int side = 0; side < 2; ++side) {
        const mbsri_sparse *one = side ? B : A, *two = side ? A : B;
        for (int j = 0; j < one->n; ++j) {
            int at = two->start[j];
            for (int k = one->start[j]; k < one->start[j + 1]; ++k) {
                const int i = one->row[k];
                const double a = one->value[k], b = look_up(two, i, j, &at),
                             size = sqrt(at_diagonal(A, i)) * sqrt(at_diagonal(A, j));
                if (fabs(a - b) > symmetric * (fabs(a) + fabs(b) + size))
                    return REFUSE("%s is not symmetric: (%d,%d) is %.10g, (%d,%d) is %.10g", name,
                                  i, j, side ? b : a, j, i, side ? a : b);
            }
        }
    }
    return MBSR_OK;
}

/* The first entry off the diagonal; t->count: there is none. */
static int off_diagonal(const triplets *t)
{
    int k = 0;
    while (k < t->count && t->row[k] == t->column[k]) ++k;
    return k;
}

/* A triangle has entries on one side only. */
static int check_side(const char *name, const triplets *lower, const triplets *upper,
                      mbsr_error *error)
{
    const int k = off_diagonal(lower), l = off_diagonal(upper);
    if (k == lower->count || l == upper->count) return MBSR_OK;
    return REFUSE("%s has entries on both sides of the diagonal, (%d,%d) and (%d,%d), but %s.whole "
                  "is 0",
                  name, lower->row[k], lower->column[k], upper->column[l], upper->row[l], name);
}

static int build_columns(mbsri_arena *arena, mbsri_arena *scratch, const char *name,
                         const mbsr_fe_matrix *given, mbsri_sparse *A, mbsr_error *error)
{
    triplets lower, upper;
    mbsri_sparse B;
    int status = MBSR_ERR_NO_MEMORY;
    if (open_triplets(scratch, given->entries, &lower) &&
        open_triplets(scratch, given->entries, &upper))
        status = split_triangles(name, given, &lower, &upper, error);
    if (!status && !given->whole) status = check_side(name, &lower, &upper, error);
    if (status) return status;
    const bool use_upper = !given->whole && off_diagonal(&upper) < upper.count;
    if (!assemble(arena, given->rows, use_upper ? &upper : &lower, A)) return MBSR_ERR_NO_MEMORY;
    if (!given->whole) return MBSR_OK;
    if (!assemble(scratch, given->rows, &upper, &B)) return MBSR_ERR_NO_MEMORY;
    return compare_triangles(name, A, &B, error);
}

int mbsri_sparse_build(mbsri_arena *arena, const char *name, const mbsr_fe_matrix *given,
                       mbsri_sparse *A, mbsr_error *error)
{
    mbsri_arena scratch;
    int status = check_shape(name, given, error);
    if (status) return status;
    mbsri_arena_open(&scratch, &arena->allocator);
    status = build_columns(arena, &scratch, name, given, A, error);
    mbsri_arena_close(&scratch);
    if (status == MBSR_ERR_NO_MEMORY)
        return mbsri_fail_plain(error, status, "mbsr_fe_reduce: no memory for %s of %zu entries",
                                name, given->entries);
    return status;
}

/* ---- use ---- */

void mbsri_sparse_multiply(const mbsri_sparse *A, int c, const double *X, double *Y)
{
    const size_t n = (size_t)A->n;
    mbsri_zero(n * (size_t)c, Y);
    for (int l = 0; l < c; ++l) {
        const double *x = X + n * (size_t)l;
        double *y = Y + n * (size_t)l;
        for (int j = 0; j < A->n; ++j) {
            int k = A->start[j];
            double sum = A->value[k] * x[j];
            for (++k; k < A->start[j + 1]; ++k) {
                y[A->row[k]] += A->value[k] * x[j];
                sum += A->value[k] * x[A->row[k]];
            }
            y[j] += sum;
        }
    }
}

void mbsri_sparse_multiply_sizes(const mbsri_sparse *A, const double *x, double *y)
{
    mbsri_zero((size_t)A->n, y);
    for (int j = 0; j < A->n; ++j) {
        for (int k = A->start[j]; k < A->start[j + 1]; ++k) {
            const double size = fabs(A->value[k]);
            y[j] += size * fabs(x[A->row[k]]);
            if (A->row[k] != j) y[A->row[k]] += size * fabs(x[j]);
        }
    }
}

bool mbsri_sparse_extract(mbsri_arena *arena, const mbsri_sparse *A, const int *place, int n,
                          mbsri_sparse *part)
{
    mbsri_arena scratch;
    triplets t;
    mbsri_arena_open(&scratch, &arena->allocator);
    bool good = open_triplets(&scratch, (size_t)A->start[A->n], &t);
    for (int j = 0; j < A->n && good; ++j) {
        for (int k = A->start[j]; k < A->start[j + 1]; ++k) {
            const int a = place[A->row[k]], b = place[j];
            if (a >= 0 && b >= 0) add_triplet(&t, a > b ? a : b, a > b ? b : a, A->value[k]);
        }
    }
    good = good && assemble(arena, n, &t, part);
    mbsri_arena_close(&scratch);
    return good;
}
