/* Comparison of doubles with a text that shows both values, and random numbers that repeat.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_CLOSE_H
#define TEST_CLOSE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

/* Fails unless |a - b| <= tolerance; NaN fails. */
#define assert_close(a, b, tolerance) assert_close_at((a), (b), (tolerance), #a, __FILE__, __LINE__)

static inline void assert_close_at(double a, double b, double tolerance, const char *what,
                                   const char *file, int line)
{
    if (fabs(a - b) <= tolerance) return;
    print_error("%s is %.17g, expected %.17g, off by %.3g > %.3g\n", what, a, b, fabs(a - b),
                tolerance);
    _fail(file, line);
}

/* Fails unless a < b; NaN fails. */
#define assert_less(a, b) assert_less_at((a), (b), #a, #b, __FILE__, __LINE__)

static inline void assert_less_at(double a, double b, const char *what, const char *bound,
                                  const char *file, int line)
{
    if (a < b) return;
    print_error("%s is %.17g, expected below %s = %.17g\n", what, a, bound, b);
    _fail(file, line);
}

static inline double test_largest(int n, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = x[k] != x[k] ? x[k] : fmax(value, fabs(x[k]));
    return value;
}

/* xorshift64*: the same numbers on every machine. */
typedef struct test_rng {
    uint64_t state;
} test_rng;

static inline test_rng test_seed(uint64_t seed)
{
    return (test_rng){seed * 0x9e3779b97f4a7c15u + 0x1234567u};
}

static inline double test_uniform(test_rng *rng) /* in [-1, 1) */
{
    rng->state ^= rng->state >> 12;
    rng->state ^= rng->state << 25;
    rng->state ^= rng->state >> 27;
    return (double)(rng->state * 0x2545f4914f6cdd1du >> 11) * 0x1p-52 - 1.0;
}

static inline int test_integer(test_rng *rng, int low, int high) /* low .. high, both included */
{
    const int value = low + (int)((test_uniform(rng) + 1.0) * 0.5 * (high - low + 1));
    return value > high ? high : value;
}

static inline void test_fill(test_rng *rng, int n, double *x)
{
    for (int k = 0; k < n; ++k) x[k] = test_uniform(rng);
}

#endif
