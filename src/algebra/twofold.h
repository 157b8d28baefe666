/* Arithmetic in twofold precision: a number as the sum of two, about 32 digits.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The error of a sum or a product of two numbers is a number itself (Knuth 1969, Dekker 1971):
 *
 *   a + b = s + e,  s = fl(a + b),  e = (a - (s - (s - a))) + (b - (s - a))
 *   a b = p + e,    p = fl(a b),    e from the halves of the digits of a and b
 *
 * In files whose compiler may merge a product and a sum the results are the same or better. Numbers
 * beyond 1e300 overflow in products. */
#ifndef MBSRI_TWOFOLD_H
#define MBSRI_TWOFOLD_H

#include <math.h>
#include <stddef.h>

typedef struct mbsri_two {
    double hi, lo;
} mbsri_two;

static inline mbsri_two mbsri_two_of(double a)
{
    return (mbsri_two){a, 0.0};
}

static inline double mbsri_two_value(mbsri_two a)
{
    return a.hi + a.lo;
}

/* a + b exactly */
static inline mbsri_two mbsri_two_sum(double a, double b)
{
    const double s = a + b, part = s - a;
    return (mbsri_two){s, (a - (s - part)) + (b - part)};
}

/* The same where |a| >= |b|. */
static inline mbsri_two mbsri_two_renew(double a, double b)
{
    const double s = a + b;
    return (mbsri_two){s, b - (s - a)};
}

/* a b exactly */
static inline mbsri_two mbsri_two_product(double a, double b)
{
    const double split = 134217729.0; /* 2^27 + 1 */
    const double A = split * a, B = split * b;
    const double a1 = A - (A - a), a2 = a - a1, b1 = B - (B - b), b2 = b - b1;
    const double p = a * b;
    return (mbsri_two){p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
}

static inline mbsri_two mbsri_two_add(mbsri_two a, mbsri_two b)
{
    const mbsri_two s = mbsri_two_sum(a.hi, b.hi), t = mbsri_two_sum(a.lo, b.lo);
    const mbsri_two r = mbsri_two_renew(s.hi, s.lo + t.hi);
    return mbsri_two_renew(r.hi, r.lo + t.lo);
}

static inline mbsri_two mbsri_two_negative(mbsri_two a)
{
    return (mbsri_two){-a.hi, -a.lo};
}

static inline mbsri_two mbsri_two_subtract(mbsri_two a, mbsri_two b)
{
    return mbsri_two_add(a, mbsri_two_negative(b));
}

/* a b with a number b */
static inline mbsri_two mbsri_two_scale(mbsri_two a, double b)
{
    const mbsri_two p = mbsri_two_product(a.hi, b);
    return mbsri_two_renew(p.hi, p.lo + a.lo * b);
}

static inline mbsri_two mbsri_two_times(mbsri_two a, mbsri_two b)
{
    const mbsri_two p = mbsri_two_product(a.hi, b.hi);
    return mbsri_two_renew(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline mbsri_two mbsri_two_divide(mbsri_two a, mbsri_two b)
{
    const double q = a.hi / b.hi;
    const mbsri_two r = mbsri_two_subtract(a, mbsri_two_scale(b, q));
    return mbsri_two_renew(q, mbsri_two_value(r) / b.hi);
}

/* of a > 0 */
static inline mbsri_two mbsri_two_root(mbsri_two a)
{
    const double x = sqrt(a.hi);
    const mbsri_two r = mbsri_two_subtract(a, mbsri_two_product(x, x));
    return mbsri_two_renew(x, 0.5 * mbsri_two_value(r) / x);
}

/* y (r) += s A (r x c, column-major) x with numbers x, and A^T x with numbers A. */
static inline void mbsri_two_ax(int r, int c, double s, const mbsri_two *A, const double *x,
                                mbsri_two *y)
{
    for (int j = 0; j < c; ++j) {
        if (x[j] == 0.0) continue;
        for (int k = 0; k < r; ++k)
            y[k] = mbsri_two_add(y[k],
                                 mbsri_two_scale(A[(size_t)j * (size_t)r + (size_t)k], s * x[j]));
    }
}

static inline void mbsri_two_atx(int r, int c, double s, const double *A, const mbsri_two *x,
                                 mbsri_two *y)
{
    for (int j = 0; j < c; ++j) {
        for (int k = 0; k < r; ++k) {
            const double a = s * A[(size_t)j * (size_t)r + (size_t)k];
            if (a != 0.0) y[j] = mbsri_two_add(y[j], mbsri_two_scale(x[k], a));
        }
    }
}

static inline void mbsri_two_zero(size_t n, mbsri_two *x)
{
    for (size_t k = 0; k < n; ++k) x[k] = (mbsri_two){0.0, 0.0};
}

#endif
