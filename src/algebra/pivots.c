/* Symmetric elimination in a small dense matrix: see pivots.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/pivots.h"

#include "algebra/dense.h"

#include <math.h>

static const double NOTHING = 1e-11; /* of a number in scaled rows and columns */
/* A pivot beside what its row has of unknowns that wait, and of accelerations */
static const double BESIDE = 1e-2, BESIDE_LOADS = 1e-6;

/* Scales with which the largest of the sizes of each row is about 1 (Ruiz 2001), whatever the order
 * of the rows; rows of zeros keep 1. */
static void find_scale(mbsri_pivots *f)
{
    const int n = f->size, N = n + f->d;
    const double *sizes = f->sizes;
    for (int i = 0; i < n; ++i) f->scale[i] = 1.0;
    for (int sweep = 0; sweep < 3; ++sweep) {
        for (int i = 0; i < n; ++i) {
            const double *column = sizes + (size_t)i * (size_t)N;
            double largest = 0.0;
            for (int j = 0; j < n; ++j) {
                const double size = column[j] * f->scale[i] * f->scale[j];
                largest = size > largest ? size : largest;
            }
            f->value[i] = largest;
        }
        for (int i = 0; i < n; ++i) {
            if (f->value[i] > 0.0) f->scale[i] /= sqrt(f->value[i]);
        }
    }
}

static void swap(double *a, double *b)
{
    const double value = *a;
    *a = *b;
    *b = value;
}

/* Exchanges unknowns i and j. */
static void exchange_unknowns(mbsri_pivots *f, int i, int j)
{
    const int N = f->size + f->d;
    double *sizes = f->sizes;
    if (i == j) return;
    for (int k = 0; k < N; ++k) swap(f->A + i * N + k, f->A + j * N + k);
    for (int k = 0; k < N; ++k) swap(f->A + k * N + i, f->A + k * N + j);
    for (int k = 0; k < N; ++k) swap(sizes + i * N + k, sizes + j * N + k);
    for (int k = 0; k < N; ++k) swap(sizes + k * N + i, sizes + k * N + j);
    swap(f->scale + i, f->scale + j);
    const int id = f->id[i];
    f->id[i] = f->id[j];
    f->id[j] = id;
}

static double scaled_entry(const mbsri_pivots *f, int i, int j)
{
    return fabs(f->A[j * (f->size + f->d) + i]) * f->scale[i] * f->scale[j];
}

/* The least pivot of row i: a small one would leave large numbers beside it to cancel further on.
 */
static double least(const mbsri_pivots *f, int i)
{
    const int N = f->size + f->d;
    const double *A = f->A + (size_t)i * (size_t)N, *sizes = f->sizes + (size_t)i * (size_t)N;
    double waiting = 0.0, load = 0.0;
    for (int j = f->complete; j < f->size; ++j) {
        const double entry = fabs(A[j]) * f->scale[j];
        waiting = entry > waiting ? entry : waiting;
    }
    for (int j = f->size; j < N; ++j) {
        const double share = sizes[j] > 0.0 ? fabs(A[j]) / sizes[j] : 0.0;
        load = share > load ? share : load;
    }
    waiting *= BESIDE * f->scale[i];
    load *= BESIDE_LOADS;
    return waiting > load ? waiting : load;
}

/* The next pivot: i == j, or a pair; false where there is none. */
static bool find_next_pivot(const mbsri_pivots *f, int *i, int *j)
{
    static const double single = 0.64; /* (1 + sqrt(17)) / 8, which bounds growth */
    double best = NOTHING, pair = NOTHING;
    int k = -1, l = -1, at = -1;
    for (int c = f->pivots; c < f->complete; ++c) {
        const double own = scaled_entry(f, c, c), bound = least(f, c);
        if (own > best && own >= bound) best = own, at = c;
        for (int r = c + 1; r < f->complete; ++r) {
            const double entry = scaled_entry(f, r, c);
            if (entry > pair && entry >= bound && entry >= least(f, r)) pair = entry, k = c, l = r;
        }
    }
    *i = *j = at;
    if (k >= 0 && (at < 0 || best < single * pair)) *i = k, *j = l;
    return *i >= 0;
}

/* The row of L for r and t beside the pivot [a b; b c], or for r beside a. */
static void divide_by_pivot(int width, double a, double b, double c, double r, double t, double *l,
                            double *k)
{
    const double det = a * c - b * b;
    *l = width > 1 ? (c * r - b * t) / det : r / a;
    *k = width > 1 ? (a * t - b * r) / det : 0.0;
}

enum { BLOCK = 48 }; /* rows at a time: what they need stays near */

/* Columns i of rows [from, to) behind a pivot whose columns are x and y (NULL: single), with their
 * rows of L l and k. */
static inline void subtract_rows(mbsri_pivots *f, int first, int from, int to, const double *x,
                                 const double *y, const double *l, const double *k)
{
    const int N = f->size + f->d;
    for (int i = first; i < to; ++i) {
        const int start = i > from ? i : from;
        double *column = f->A + (size_t)i * (size_t)N, *size = f->sizes + (size_t)i * (size_t)N;
        const double s = x[i], t = y ? y[i] : 0.0;
        for (int j = start; j < to; ++j) {
            const double part = l[j - from] * s, other = y ? k[j - from] * t : 0.0,
                         entry = column[j] - (part + other),
                         sum = size[j] + (fabs(part) + fabs(other));
            size[j] = sum;
            column[j] = fabs(entry) <= MBSRI_PIVOTS_ROUNDING * sum ? 0.0 : entry;
        }
        for (int j = start; j < to; ++j) {
            f->A[(size_t)j * (size_t)N + (size_t)i] = column[j];
            f->sizes[(size_t)j * (size_t)N + (size_t)i] = size[j];
        }
    }
}

/* Rows and columns behind the pivot (1 or 2 of them): A - L D L^T, without what is rounding in it.
 */
static void subtract_pivot(mbsri_pivots *f, int width)
{
    const int N = f->size + f->d, p = f->pivots, first = p + width;
    double *x = f->A + (size_t)p * (size_t)N, *y = width > 1 ? x + N : x, l[BLOCK], k[BLOCK];
    const double a = x[p], b = width > 1 ? x[p + 1] : 0.0, c = width > 1 ? y[p + 1] : 1.0;
    f->across[p] = b;
    if (width > 1) f->across[p + 1] = 0.0;
    for (int from = first; from < N; from += BLOCK) {
        const int to = from + BLOCK < N ? from + BLOCK : N;
        for (int j = from; j < to; ++j)
            divide_by_pivot(width, a, b, c, x[j], y[j], l + (j - from), k + (j - from));
        if (width > 1)
            subtract_rows(f, first, from, to, x, y, l, k);
        else
            subtract_rows(f, first, from, to, x, NULL, l, k);
    }
    for (int j = first; j < N; ++j) {
        divide_by_pivot(width, a, b, c, x[j], y[j], l, k);
        x[j] = l[0];
        if (width > 1) y[j] = k[0];
    }
    f->pivots += width;
}

static bool nothing_left(const mbsri_pivots *f, int i)
{
    const int n = f->size, N = n + f->d;
    const double *A = f->A + (size_t)i * (size_t)N, *sizes = f->sizes + (size_t)i * (size_t)N;
    for (int j = f->pivots; j < n; ++j) {
        if (!(fabs(A[j]) * f->scale[i] * f->scale[j] <= NOTHING)) return false;
    }
    for (int j = n; j < N; ++j) {
        if (!(fabs(A[j]) <= 10.0 * NOTHING * sizes[j])) return false;
    }
    return true;
}

void mbsri_pivots_eliminate(mbsri_pivots *f)
{
    int i, j;
    f->pivots = f->left = f->idles = 0;
    find_scale(f);
    while (find_next_pivot(f, &i, &j)) {
        const int p = f->pivots;
        exchange_unknowns(f, p, i);
        if (i != j) exchange_unknowns(f, p + 1, j);
        subtract_pivot(f, i == j ? 1 : 2);
    }
    for (i = f->pivots; i < f->complete; ++i) {
        if (nothing_left(f, i)) exchange_unknowns(f, f->pivots + f->left++, i);
    }
}

/* Entry i of the pivots' solution, without right-hand side unless s is given. */
static void solve_pivots(const mbsri_pivots *f, const double *s, const double *a, double *x)
{
    const int n = f->size, N = n + f->d;
    for (int p = f->pivots - 1; p >= 0; --p) {
        const bool second = p > 0 && f->across[p - 1] != 0.0;
        const int first = second ? p - 1 : p;
        const double b = f->across[first], d0 = f->A[first * (N + 1)],
                     d1 = b != 0.0 ? f->A[(first + 1) * (N + 1)] : 1.0;
        double r[2] = {s ? s[f->id[first]] : 0.0, s && b != 0.0 ? s[f->id[first + 1]] : 0.0};
        const double det = d0 * d1 - b * b;
        const double z =
            b != 0.0 ? (second ? d0 * r[1] - b * r[0] : d1 * r[0] - b * r[1]) / det : r[0] / d0;
        const double *L = f->A + p * N;
        const int from = b != 0.0 ? first + 2 : p + 1;
        double sum = z;
        for (int i = from; i < n; ++i) sum -= L[i] * x[i];
        for (int i = 0; i < f->d && a; ++i) sum -= L[n + i] * a[i];
        x[p] = sum;
    }
}

static double share_of_unknown(const mbsri_pivots *f, int i)
{
    const int id = f->id[i];
    if (id >= f->shared) return 0.0;
    return f->share[id] > 0.0 ? f->share[id] : 1.0;
}

void mbsri_pivots_find_idle(mbsri_pivots *f, const bool *wanted)
{
    double *work = f->value;
    const int n = f->size, last = f->pivots + f->left;
    for (int l = 0; l < f->left; ++l) {
        if (!wanted[l]) continue;
        double *y = f->idle + f->idles * n;
        mbsri_zero((size_t)n, work);
        work[f->pivots + l] = 1.0;
        solve_pivots(f, NULL, NULL, work);
        for (int i = 0; i < n; ++i) y[i] = i < last ? work[i] * share_of_unknown(f, i) : 0.0;
        for (int turn = 0; turn < 2; ++turn) {
            for (int k = 0; k < f->idles; ++k) {
                const double *z = f->idle + k * n, part = mbsri_dot(n, z, y);
                for (int i = 0; i < n; ++i) y[i] -= part * z[i];
            }
        }
        const double length = sqrt(mbsri_dot(n, y, y));
        for (int i = 0; i < n; ++i) y[i] /= length;
        ++f->idles;
    }
}

void mbsri_pivots_forward(const mbsri_pivots *f, double *s, double *fbar)
{
    const int n = f->size, N = n + f->d;
    for (int p = 0; p < f->pivots; ++p) {
        const double *L = f->A + p * N, value = s[f->id[p]];
        for (int i = f->across[p] != 0.0 ? p + 2 : p + 1; i < n; ++i) s[f->id[i]] -= L[i] * value;
        for (int i = 0; i < f->d; ++i) fbar[i] += L[n + i] * value;
    }
}

void mbsri_pivots_backward(const mbsri_pivots *f, const double *s, const double *a, double *v)
{
    double *work = f->value;
    const int n = f->size, last = f->pivots + f->left;
    for (int i = f->pivots; i < last; ++i) work[i] = 0.0;
    for (int i = last; i < n; ++i) work[i] = v[f->id[i]];
    solve_pivots(f, s, a, work);
    for (int l = 0; l < f->idles; ++l) {
        const double *z = f->idle + l * n;
        double part = 0.0;
        for (int i = 0; i < last; ++i) part += z[i] * work[i] * share_of_unknown(f, i);
        for (int i = 0; i < last; ++i) {
            const double share = share_of_unknown(f, i);
            if (share > 0.0) work[i] -= part * z[i] / share;
        }
    }
    for (int i = 0; i < last; ++i) v[f->id[i]] = work[i];
}
