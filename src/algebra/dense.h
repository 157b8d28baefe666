/* Small dense products, column-major without padding: y += s A x and its relatives.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * For blocks of 1 to about 12 rows a call of BLAS costs more than the product. */
#ifndef MBSRI_DENSE_H
#define MBSRI_DENSE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

static inline void mbsri_zero(size_t n, double *x)
{
    if (n > 0) memset(x, 0, n * sizeof *x);
}

static inline bool mbsri_is_zero(size_t n, const double *x)
{
    for (size_t k = 0; k < n; ++k) {
        if (x[k] != 0.0) return false;
    }
    return true;
}

static inline void mbsri_copy(size_t n, const double *x, double *y)
{
    if (n > 0) memcpy(y, x, n * sizeof *y);
}

static inline double mbsri_dot(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum;
}

/* y (r) += a (r) s, then += b (r) t */
static inline void mbsri_add_two(int r, const double *a, double s, const double *b, double t,
                                 double *y)
{
    for (int k = 0; k < r; ++k) y[k] = y[k] + a[k] * s + b[k] * t;
}

#if defined(MBSR_WITHOUT_VECTORS)

/* The same of long columns. */
static inline void mbsri_add_two_long(int r, const double *a, double s, const double *b, double t,
                                      double *y)
{
    mbsri_add_two(r, a, s, b, t, y);
}

/* a.x and b.x of long columns */
static inline void mbsri_dot_two_long(int r, const double *a, const double *b, const double *x,
                                      double *with_a, double *with_b)
{
    *with_a = mbsri_dot(r, a, x);
    *with_b = mbsri_dot(r, b, x);
}

/* y (2 pairs) += a */
static inline void mbsri_add_pairs(const int pairs, const double *a, double *y)
{
    for (int k = 0; k < 2 * pairs; ++k) y[k] += a[k];
}

/* a.b of two with six numbers */
static inline double mbsri_dot_six(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}

/* 0 x, added up: 0 where all are finite, else NaN */
static inline double mbsri_nothing_of(size_t n, const double *x)
{
    double sum = 0.0;
    for (size_t k = 0; k < n; ++k) sum += 0.0 * x[k];
    return sum;
}

/* y (2 pairs) += s A x of a matrix with few rows, 2 pairs x c, pairs <= 6 */
static inline void mbsri_add_columns(const int pairs, int c, double s, const double *A,
                                     const double *x, double *y)
{
    for (int l = 0; l < c; ++l) {
        for (int k = 0; k < 2 * pairs; ++k) y[k] += s * x[l] * A[l * 2 * pairs + k];
    }
}

/* y (2 pairs) += |A| |x| */
static inline void mbsri_add_sizes(const int pairs, int c, const double *A, const double *x,
                                   double *y)
{
    for (int l = 0; l < c; ++l) {
        for (int k = 0; k < 2 * pairs; ++k) y[k] += fabs(x[l]) * fabs(A[l * 2 * pairs + k]);
    }
}

/* Whether two rows of 2 pairs numbers are the same. */
static inline bool mbsri_same(const int pairs, const double *a, const double *b)
{
    bool same = true;
    for (int k = 0; k < 2 * pairs; ++k) same = same && !(a[k] != b[k]);
    return same;
}

/* y (r) -= four columns (r) times the numbers x, one after the other */
static inline void mbsri_subtract_four(int r, const double *const column[4], const double x[4],
                                       double *y)
{
    for (int k = 0; k < r; ++k)
        y[k] = y[k] - column[0][k] * x[0] - column[1][k] * x[1] - column[2][k] * x[2] -
               column[3][k] * x[3];
}

#else

/* Two numbers anywhere among others. */
typedef double mbsri_pair __attribute__((vector_size(16), aligned(8), may_alias));

static inline mbsri_pair *mbsri_pair_at(double *x)
{
    return (mbsri_pair *)(void *)x;
}

static inline mbsri_pair mbsri_pair_of(const double *x)
{
    return *(const mbsri_pair *)(const void *)x;
}

/* The same of long columns. */
static inline void mbsri_add_two_long(int r, const double *a, double s, const double *b, double t,
                                      double *y)
{
    const mbsri_pair ss = {s, s}, tt = {t, t};
    int k = 0;
    for (; k < r - 3; k += 4) {
        const mbsri_pair low = mbsri_pair_of(y + k) + mbsri_pair_of(a + k) * ss,
                         high = mbsri_pair_of(y + k + 2) + mbsri_pair_of(a + k + 2) * ss;
        *mbsri_pair_at(y + k) = low + mbsri_pair_of(b + k) * tt;
        *mbsri_pair_at(y + k + 2) = high + mbsri_pair_of(b + k + 2) * tt;
    }
    for (; k < r; ++k) y[k] = y[k] + a[k] * s + b[k] * t;
}

/* a.x and b.x of long columns */
static inline void mbsri_dot_two_long(int r, const double *a, const double *b, const double *x,
                                      double *with_a, double *with_b)
{
    mbsri_pair sum = {0.0, 0.0}, other = {0.0, 0.0};
    int k = 0;
    for (; k < r - 1; k += 2) {
        const mbsri_pair xx = mbsri_pair_of(x + k);
        sum += mbsri_pair_of(a + k) * xx;
        other += mbsri_pair_of(b + k) * xx;
    }
    *with_a = sum[0] + sum[1];
    *with_b = other[0] + other[1];
    if (k < r) *with_a += a[k] * x[k], *with_b += b[k] * x[k];
}

static inline void mbsri_add_pairs(const int pairs, const double *a, double *y)
{
    for (int k = 0; k < pairs; ++k)
        *mbsri_pair_at(y + 2 * k) = mbsri_pair_of(y + 2 * k) + mbsri_pair_of(a + 2 * k);
}

static inline double mbsri_dot_six(const double *a, const double *b)
{
    const mbsri_pair sum = mbsri_pair_of(a) * mbsri_pair_of(b) +
                           mbsri_pair_of(a + 2) * mbsri_pair_of(b + 2) +
                           mbsri_pair_of(a + 4) * mbsri_pair_of(b + 4);
    return sum[0] + sum[1];
}

static inline double mbsri_nothing_of(size_t n, const double *x)
{
    const mbsri_pair none = {0.0, 0.0};
    mbsri_pair sum = none, other = none;
    size_t k = 0;
    for (; k + 8 <= n; k += 8) {
        sum += none * mbsri_pair_of(x + k);
        other += none * mbsri_pair_of(x + k + 2);
        sum += none * mbsri_pair_of(x + k + 4);
        other += none * mbsri_pair_of(x + k + 6);
    }
    sum += other;
    double last = sum[0] + sum[1];
    for (; k < n; ++k) last += 0.0 * x[k];
    return last;
}

static inline void mbsri_add_columns(const int pairs, int c, double s, const double *A,
                                     const double *x, double *y)
{
    mbsri_pair sum[6];
    for (int k = 0; k < pairs; ++k) sum[k] = mbsri_pair_of(y + 2 * k);
    for (int l = 0; l < c; ++l, A += 2 * pairs) {
        const mbsri_pair xx = {s * x[l], s * x[l]};
        for (int k = 0; k < pairs; ++k) sum[k] += xx * mbsri_pair_of(A + 2 * k);
    }
    for (int k = 0; k < pairs; ++k) *mbsri_pair_at(y + 2 * k) = sum[k];
}

typedef long long mbsri_mask __attribute__((vector_size(16)));

static inline void mbsri_add_sizes(const int pairs, int c, const double *A, const double *x,
                                   double *y)
{
    const mbsri_mask size = {0x7fffffffffffffff, 0x7fffffffffffffff};
    mbsri_pair sum[6];
    for (int k = 0; k < pairs; ++k) sum[k] = mbsri_pair_of(y + 2 * k);
    for (int l = 0; l < c; ++l, A += 2 * pairs) {
        const mbsri_pair xx = {fabs(x[l]), fabs(x[l])};
        for (int k = 0; k < pairs; ++k)
            sum[k] += xx * (mbsri_pair)((mbsri_mask)mbsri_pair_of(A + 2 * k) & size);
    }
    for (int k = 0; k < pairs; ++k) *mbsri_pair_at(y + 2 * k) = sum[k];
}

static inline bool mbsri_same(const int pairs, const double *a, const double *b)
{
    mbsri_mask other = {0, 0};
    for (int k = 0; k < pairs; ++k) other |= mbsri_pair_of(a + 2 * k) != mbsri_pair_of(b + 2 * k);
    return (other[0] | other[1]) == 0;
}

static inline void mbsri_subtract_four(int r, const double *const column[4], const double x[4],
                                       double *y)
{
    const mbsri_pair a = {x[0], x[0]}, b = {x[1], x[1]}, c = {x[2], x[2]}, d = {x[3], x[3]};
    int k = 0;
    for (; k + 1 < r; k += 2) {
        mbsri_pair sum = mbsri_pair_of(y + k) - mbsri_pair_of(column[0] + k) * a;
        sum -= mbsri_pair_of(column[1] + k) * b;
        sum -= mbsri_pair_of(column[2] + k) * c;
        *mbsri_pair_at(y + k) = sum - mbsri_pair_of(column[3] + k) * d;
    }
    for (; k < r; ++k)
        y[k] = y[k] - column[0][k] * x[0] - column[1][k] * x[1] - column[2][k] * x[2] -
               column[3][k] * x[3];
}

#endif

/* y (r) += s A (r x c) x (c); two columns at a time */
static inline void mbsri_ax(int r, int c, double s, const double *A, const double *x, double *y)
{
    int j = 0;
    for (; j < c - 1; j += 2) {
        const double *a = A + (size_t)j * (size_t)r;
        mbsri_add_two(r, a, s * x[j], a + r, s * x[j + 1], y);
    }
    if (j >= c) return;
    const double *a = A + (size_t)j * (size_t)r, xj = s * x[j];
    for (int k = 0; k < r; ++k) y[k] += a[k] * xj;
}

/* y (c) += s A^T x (r),  A r x c; of two columns at a time neither sum waits for the other */
static inline void mbsri_atx(int r, int c, double s, const double *A, const double *x, double *y)
{
    int j = 0;
    for (; j < c - 1; j += 2) {
        const double *a = A + (size_t)j * (size_t)r, *b = a + r;
        double sum = 0.0, other = 0.0;
        for (int k = 0; k < r; ++k) sum += a[k] * x[k], other += b[k] * x[k];
        y[j] += s * sum;
        y[j + 1] += s * other;
    }
    if (j < c) y[j] += s * mbsri_dot(r, A + (size_t)j * (size_t)r, x);
}

/* These two, where r is six mostly. */
static inline void mbsri_ax_often(int r, int c, double s, const double *A, const double *x,
                                  double *y)
{
    if (r == 6 && c == 6)
        mbsri_add_columns(3, 6, s, A, x, y);
    else if (r == 6)
        mbsri_add_columns(3, c, s, A, x, y);
    else
        mbsri_ax(r, c, s, A, x, y);
}

static inline void mbsri_atx_often(int r, int c, double s, const double *A, const double *x,
                                   double *y)
{
    if (r != 6) {
        mbsri_atx(r, c, s, A, x, y);
        return;
    }
    for (int j = 0; j < c; ++j) y[j] += s * mbsri_dot_six(A + 6 * (size_t)j, x);
}

/* These two with many rows. */
static inline void mbsri_ax_long(int r, int c, double s, const double *A, const double *x,
                                 double *y)
{
    int j = 0;
    for (; j < c - 1; j += 2) {
        const double *a = A + (size_t)j * (size_t)r;
        mbsri_add_two_long(r, a, s * x[j], a + r, s * x[j + 1], y);
    }
    if (j < c) mbsri_ax(r, 1, s * x[j], A + (size_t)j * (size_t)r, &(double){1.0}, y);
}

static inline void mbsri_atx_long(int r, int c, double s, const double *A, const double *x,
                                  double *y)
{
    int j = 0;
    for (; j < c - 1; j += 2) {
        const double *a = A + (size_t)j * (size_t)r;
        double sum, other;
        mbsri_dot_two_long(r, a, a + r, x, &sum, &other);
        y[j] += s * sum;
        y[j + 1] += s * other;
    }
    if (j < c) y[j] += s * mbsri_dot(r, A + (size_t)j * (size_t)r, x);
}

/* C (r x c) += s A (r x k) B (k x c) */
static inline void mbsri_ab(int r, int k, int c, double s, const double *A, const double *B,
                            double *C)
{
    for (int j = 0; j < c; ++j)
        mbsri_ax(r, k, s, A, B + (size_t)j * (size_t)k, C + (size_t)j * (size_t)r);
}

/* C (k x c) += s A^T B,  A r x k, B r x c */
static inline void mbsri_atb(int r, int k, int c, double s, const double *A, const double *B,
                             double *C)
{
    for (int j = 0; j < c; ++j)
        mbsri_atx(r, k, s, A, B + (size_t)j * (size_t)r, C + (size_t)j * (size_t)k);
}

/* C (r x c) += s A B^T,  A r x k, B c x k */
static inline void mbsri_abt(int r, int k, int c, double s, const double *A, const double *B,
                             double *C)
{
    for (int l = 0; l < k; ++l) {
        const double *a = A + (size_t)l * (size_t)r, *b = B + (size_t)l * (size_t)c;
        for (int j = 0; j < c; ++j) {
            const double bj = s * b[j];
            double *column = C + (size_t)j * (size_t)r;
            if (r == 6) {
                mbsri_add_columns(3, 1, bj, a, &(double){1.0}, column);
                continue;
            }
            for (int i = 0; i < r; ++i) column[i] += a[i] * bj;
        }
    }
}

/* C (c x c) += A^T B A with symmetric B (r x r), A r x c; T: r x c of scratch. */
static inline void mbsri_congruence(int r, int c, const double *A, const double *B, double *C,
                                    double *T)
{
    mbsri_zero((size_t)r * (size_t)c, T);
    mbsri_ab(r, r, c, 1.0, B, A, T);
    mbsri_atb(r, c, c, 1.0, A, T, C);
}

/* Row and column j of the same, up to the diagonal. */
static inline void mbsri_even_row(int n, int j, double *A)
{
    for (int k = 0; k < j; ++k) {
        const size_t jk = (size_t)k * (size_t)n + (size_t)j, kj = (size_t)j * (size_t)n + (size_t)k;
        A[jk] = A[kj] = 0.5 * (A[jk] + A[kj]);
    }
}

/* A := (A + A^T) / 2,  n x n */
static inline void mbsri_symmetrise(int n, double *A)
{
    if (n == 6) { /* row by row known to the compiler */
        mbsri_even_row(6, 1, A);
        mbsri_even_row(6, 2, A);
        mbsri_even_row(6, 3, A);
        mbsri_even_row(6, 4, A);
        mbsri_even_row(6, 5, A);
        return;
    }
    for (int j = 0; j < n; ++j) mbsri_even_row(n, j, A);
}

#endif
