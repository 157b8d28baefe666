/* Ranks of velocities that are linear in a few rates, and random choices of the scenes they are
 * told of.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SPAN_H
#define TEST_SPAN_H

#include "expect.h"

#include <stdbool.h>

enum { TEST_SPAN_MOST = 42 };

/* What rows of n numbers span; doubtful: some row was neither in the span nor at least `clear` out
 * of it. */
typedef struct test_span {
    double v[TEST_SPAN_MOST][TEST_SPAN_MOST]; /* orthonormal */
    double length[TEST_SPAN_MOST];            /* of what each was when it was added */
    int count, n;
    double clear;
    bool doubtful;
} test_span;

/* What is left of a row (n) beside the span; its length. */
double test_span_beside(const test_span *p, double *row);

/* Adds rows, the one that is farthest off first; rows: what is left of them. */
void test_span_widen(test_span *p, int count, double rows[][TEST_SPAN_MOST]);

/* True for a share of the draws. */
static inline bool test_chance(test_rng *rng, double share)
{
    return test_uniform(rng) < 2.0 * share - 1.0;
}

/* Between 10^low and 10^high, by decades. */
static inline double test_decades(test_rng *rng, double low, double high)
{
    return pow(10.0, low + 0.5 * (high - low) * (1.0 + test_uniform(rng)));
}

#endif
