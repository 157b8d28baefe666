/* Eigenvalues of largest size of an operator that is known by its products.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "linear/krylov.h"

#include "linear/lapack.h"

#include <math.h>
#include <string.h>

enum { ROWS = 256 }; /* of V, in a block */

static const int one = 1;

void mbsri_krylov_open(mbsri_krylov *z, mbsri_arena *arena, int n, int m)
{
    const size_t rows = (size_t)n, most = (size_t)m;
    z->n = n;
    z->m = z->limit = m;
    z->state = 12345;
    z->V = mbsri_arena_take(arena, rows * (most + 1) * sizeof(double));
    z->H = mbsri_arena_take(arena, (most + 1) * most * sizeof(double));
    z->T = mbsri_arena_take(arena, most * most * sizeof(double));
    z->Q = mbsri_arena_take(arena, most * most * sizeof(double));
    z->b = mbsri_arena_take(arena, most * sizeof(double));
    z->work = mbsri_arena_take(arena, (most + 1) * (ROWS + 8) * sizeof(double));
}

/* In four sums, which the compiler may take side by side. */
static double inner(int n, const double *restrict x, const double *restrict y)
{
    double sum[4] = {0.0};
    int k = 0;
    for (; k + 4 <= n; k += 4) {
        for (int i = 0; i < 4; ++i) sum[i] += x[k + i] * y[k + i];
    }
    for (; k < n; ++k) sum[0] += x[k] * y[k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static double euclidean(int n, const double *x)
{
    return sqrt(inner(n, x, x));
}

static void stretch(int n, double factor, double *x)
{
    for (int k = 0; k < n; ++k) x[k] *= factor;
}

/* x <- x - V part, and `next` = V^T x of what is left, rows by rows, which stay in the cache
 * between the two. part NULL: x stays. */
static void take_part(const mbsri_krylov *z, int k, const double *part, double *x, double *next)
{
    enum { AT_ONCE = 512 };
    const double plus = 1.0, minus = -1.0;
    memset(next, 0, (size_t)k * sizeof *next);
    for (int row = 0; row < z->n; row += AT_ONCE) {
        const int count = z->n - row < AT_ONCE ? z->n - row : AT_ONCE;
        if (part)
            dgemv_("N", &count, &k, &minus, z->V + row, &z->n, part, &one, &plus, x + row, &one, 1);
        dgemv_("T", &count, &k, &plus, z->V + row, &z->n, x + row, &one, &plus, next, &one, 1);
    }
}

/* x <- (1 - V V^T) x with the first k of V, twice where much goes; h += V^T x (may be NULL).
 * Returns the norm that is left. */
static double project_out(mbsri_krylov *z, int k, double *x, double *h)
{
    double before = euclidean(z->n, x), left = before, *part = z->work, *next = part + z->m + 1;
    if (k > 0) take_part(z, k, NULL, x, part);
    for (int pass = 0; pass < 3 && k > 0; ++pass) {
        take_part(z, k, part, x, next);
        for (int j = 0; j < k && h; ++j) h[j] += part[j];
        memcpy(part, next, (size_t)k * sizeof *part);
        left = euclidean(z->n, x);
        if (left > 0.7 * before) break;
        before = left;
    }
    return left;
}

/* Directions in which S is nilpotent, infinite eigenvalues of a pencil, are gone after as many
 * products as their index. */
int mbsri_krylov_begin(mbsri_krylov *z)
{
    enum { INDEX = 3 };
    const size_t n = (size_t)z->n;
    double *v = z->V + (size_t)z->k * n;
    for (size_t k = 0; k < n; ++k) {
        z->state = z->state * 1664525u + 1013904223u;
        v[k] = (double)(z->state >> 8) / 8388608.0 - 1.0;
    }
    double size = project_out(z, z->k, v, NULL), first = size;
    for (int k = 0; k < INDEX && size > 0.0; ++k) {
        stretch(z->n, 1.0 / size, v);
        const int status = z->apply(z->context, v, v);
        if (status) return status;
        first = euclidean(z->n, v);
        size = project_out(z, z->k, v, NULL);
    }
    z->exhausted = !(size > 1e-9 * first);
    if (!z->exhausted) stretch(z->n, 1.0 / size, v);
    for (int k = 0; k < z->k; ++k) z->H[(size_t)k * (size_t)(z->m + 1) + (size_t)z->k] = 0.0;
    return MBSR_OK;
}

int mbsri_krylov_grow(mbsri_krylov *z)
{
    const size_t n = (size_t)z->n, rows = (size_t)(z->m + 1);
    while (z->k < z->limit && !z->exhausted) {
        double *v = z->V + (size_t)z->k * n, *next = v + n, *h = z->H + (size_t)z->k * rows;
        int status = z->apply(z->context, v, next);
        if (status) return status;
        memset(h, 0, rows * sizeof *h);
        const double before = euclidean(z->n, next), size = project_out(z, ++z->k, next, h);
        if (size > 1e-10 * before) {
            stretch(z->n, 1.0 / size, next);
            h[z->k] = size;
        } else {
            status = mbsri_krylov_begin(z);
        }
        if (status) return status;
    }
    return MBSR_OK;
}

int mbsri_krylov_block(const mbsri_krylov *z, int k, double *re, double *im, double *left)
{
    const size_t m = (size_t)z->m;
    const double *t = z->T + (size_t)k * (m + 1);
    *re = t[0];
    *im = 0.0;
    *left = fabs(z->b[k]);
    if (k + 1 >= z->k || t[1] == 0.0) return k + 1;
    *im = sqrt(fabs(t[1])) * sqrt(fabs(t[m]));
    *left = hypot(z->b[k], z->b[k + 1]);
    return k + 2;
}

/* The place of the largest eigenvalue from `first` on. */
static int find_largest(const mbsri_krylov *z, int first)
{
    int best = first;
    double largest = -1.0;
    for (int k = first, next; k < z->k; k = next) {
        double re, im, left;
        next = mbsri_krylov_block(z, k, &re, &im, &left);
        /* equal ones stay in their order */
        if (!(hypot(re, im) > largest * (1.0 + 1e-14))) continue;
        largest = hypot(re, im);
        best = k;
    }
    return best;
}

bool mbsri_krylov_sort(mbsri_krylov *z)
{
    const size_t m = (size_t)z->m, rows = m + 1, k = (size_t)z->k;
    const int size = 8 * z->m;
    double *re = z->work + size, *im = re + m;
    int found = 0, info = 0;
    for (size_t j = 0; j < k; ++j) memcpy(z->T + j * m, z->H + j * rows, k * sizeof *z->T);
    if (k == 0) return true;
    dgees_("V", "N", NULL, &z->k, z->T, &z->m, &found, re, im, z->Q, &z->m, z->work, &size, NULL,
           &info, 1, 1);
    for (int at = 0; at < z->k && info == 0;) {
        double real, other, left;
        int from = find_largest(z, at) + 1, to = at + 1;
        if (from != to)
            dtrexc_("V", &z->k, z->T, &z->m, z->Q, &z->m, &from, &to, z->work, &info, 1);
        if (info == 1) info = 0; /* too close to be exchanged: they are equal */
        at = mbsri_krylov_block(z, at, &real, &other, &left);
    }
    for (size_t j = 0; j < k; ++j) {
        z->b[j] = 0.0;
        for (size_t i = 0; i < k; ++i) z->b[j] += z->H[i * rows + k] * z->Q[j * m + i];
    }
    return info == 0;
}

void mbsri_krylov_keep(mbsri_krylov *z, int k)
{
    const double plus = 1.0, none = 0.0;
    const size_t n = (size_t)z->n, m = (size_t)z->m, rows = m + 1;
    for (int row = 0; row < z->n; row += ROWS) {
        const int count = z->n - row < ROWS ? z->n - row : ROWS;
        if (k == 0) break;
        dgemm_("N", "N", &count, &k, &z->k, &plus, z->V + row, &z->n, z->Q, &z->m, &none, z->work,
               &count, 1, 1);
        for (int j = 0; j < k; ++j)
            memcpy(z->V + (size_t)j * n + row, z->work + j * count,
                   (size_t)count * sizeof *z->work);
    }
    if (k < z->k) memcpy(z->V + (size_t)k * n, z->V + (size_t)z->k * n, n * sizeof *z->V);
    memset(z->H, 0, rows * m * sizeof *z->H);
    for (size_t j = 0; j < (size_t)k; ++j) {
        memcpy(z->H + j * rows, z->T + j * m, (size_t)k * sizeof *z->H);
        z->H[j * rows + (size_t)k] = z->b[j];
    }
    z->k = k;
}

bool mbsri_krylov_vectors(mbsri_krylov *z, double *X)
{
    int found = 0, info = 0;
    if (z->k == 0) return true;
    dtrevc_("R", "A", NULL, &z->k, z->T, &z->m, NULL, &one, X, &z->k, &z->k, &found, z->work, &info,
            1, 1);
    return info == 0;
}
