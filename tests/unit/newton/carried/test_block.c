/* The small systems of equations inside the Newton solver: against LAPACK, in units of every size,
 * and what counts as singular.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton/carried/block.h"
#include "oracle.h"

#include <float.h>
#include <stdlib.h>

enum { MOST = 12 };

typedef struct block {
    int n;
    double A[MOST * MOST], b[MOST], rows[MOST], columns[MOST], sizes[MOST];
    int pivots[MOST];
} block;

/* A random matrix and right-hand side, and the sums of its rows. */
static block random_block(int n, test_rng *rng)
{
    block x = {.n = n};
    test_fill(rng, n * n, x.A);
    test_fill(rng, n, x.b);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) x.sizes[i] += fabs(x.A[j * n + i]);
    }
    return x;
}

/* diag(row) A diag(column), with a right-hand side for the same solution over `column`. */
static void rescale(block *x, const double *row, const double *column)
{
    for (int i = 0; i < x->n; ++i) {
        for (int j = 0; j < x->n; ++j) x->A[j * x->n + i] *= row[i] * column[j];
        x->b[i] *= row[i];
        x->sizes[i] = 0.0;
        for (int j = 0; j < x->n; ++j) x->sizes[i] += fabs(x->A[j * x->n + i]);
    }
}

static bool factor(block *x)
{
    for (int i = 0; i < x->n; ++i) x->rows[i] = x->sizes[i], x->columns[i] = NAN;
    return mbsri_block_factor(x->n, x->A, x->rows, x->columns, x->pivots);
}

static void solutions_are_those_of_lapack_in_any_units(void **state)
{
    (void)state;
    test_rng rng = test_seed(1);
    for (int k = 0; k < 300; ++k) {
        block x = random_block(1 + k % MOST, &rng), copy = x;
        double row[MOST], column[MOST];
        test_solve(copy.n, copy.A, copy.b);
        /* powers of two, of any size but such that sums of rows stay finite */
        for (int i = 0; i < x.n; ++i) row[i] = ldexp(1.0, test_integer(&rng, -300, 300));
        const int spread = k % 3 == 0 ? 0 : k % 3 == 1 ? 15 : 400;
        /* the second matrix has columns far below the sums of its rows, which is all right as far
         * as 64 rounding errors */
        for (int i = 0; i < x.n; ++i) column[i] = ldexp(1.0, spread == 15 ? -7 * i / 2 : spread);
        rescale(&x, row, column);
        assert_true(factor(&x));
        mbsri_block_solve(x.n, x.A, x.rows, x.columns, x.pivots, x.b);
        const double size = 1.0 + test_largest(x.n, copy.b);
        for (int i = 0; i < x.n; ++i)
            assert_close(x.b[i] * column[i], copy.b[i], 1e-10 * size * size);
    }
}

static void nothing_to_solve(void **state)
{
    (void)state;
    block x = {.n = 0};
    assert_true(factor(&x));
    mbsri_block_solve(0, x.A, x.rows, x.columns, x.pivots, x.b);
}

static void dependent_columns_or_rows_are_singular(void **state)
{
    (void)state;
    test_rng rng = test_seed(2);
    for (int k = 0; k < 200; ++k) {
        block x = random_block(2 + k % 4, &rng);
        const int n = x.n, last = test_integer(&rng, 0, n - 1);
        int weight[MOST];
        /* whole numbers, so that the sums are exact */
        for (int i = 0; i < n * n; ++i) x.A[i] = test_integer(&rng, -9, 9);
        for (int i = 0; i < n; ++i) weight[i] = test_integer(&rng, -3, 3);
        /* a column, or a row, is a sum of the others */
        const int along = k % 2 ? 1 : n, across = k % 2 ? n : 1;
        for (int i = 0; i < n; ++i) {
            double sum = 0.0;
            for (int j = 0; j < n; ++j) {
                if (j != last) sum += weight[j] * x.A[j * along + i * across];
            }
            x.A[last * along + i * across] = sum;
        }
        for (int i = 0; i < n; ++i) {
            x.sizes[i] = 0.0;
            for (int j = 0; j < n; ++j) x.sizes[i] += fabs(x.A[j * n + i]);
        }
        assert_false(factor(&x));
    }
}

/* What is left of a row after cancellation counts by what was added up in it. */
static void cancelled_rows_and_columns_are_singular(void **state)
{
    (void)state;
    static const double large = 1.0 / (64.0 * DBL_EPSILON);
    for (int k = 0; k < 2; ++k) {
        block x = {.n = 2, .A = {1.0, 0.0, 0.0, 1.0}, .b = {3.0, 5.0}};
        x.sizes[0] = 1.0;
        x.sizes[1] = (k ? 1.001 : 0.999) * large;
        assert_int_equal(factor(&x), k == 0);
        if (k == 1) continue;
        mbsri_block_solve(2, x.A, x.rows, x.columns, x.pivots, x.b);
        assert_close(x.b[0], 3.0, 1e-15);
        assert_close(x.b[1], 5.0, 1e-15);
    }
    /* in a small column, small differences count */
    block small = {.n = 2, .A = {1.0, 1.0, 0.99e-13, 1e-13}, .b = {1.0, 2.0}, .sizes = {1.0, 1.0}};
    assert_true(factor(&small));
    mbsri_block_solve(2, small.A, small.rows, small.columns, small.pivots, small.b);
    assert_close(small.b[0], -98.0, 1e-9);
    assert_close(small.b[1] * 1e-15, 1.0, 1e-11);
    /* the second pivot: (1, 1; 1, 1 + e), e above or below the threshold */
    for (int k = 0; k < 2; ++k) {
        const double e = (k ? 50.0 : 400.0) * DBL_EPSILON;
        block x = {.n = 2, .A = {1.0, 1.0, 1.0, 1.0 + e}, .sizes = {2.0, 2.0}};
        assert_int_equal(factor(&x), k == 0);
    }
}

static void what_is_zero_or_not_finite_is_singular(void **state)
{
    (void)state;
    static const double bad[] = {0.0, NAN, INFINITY, -1.0};
    for (int k = 0; k < 4; ++k) {
        block x = {.n = 2, .A = {1.0, 0.0, 0.0, 1.0}, .sizes = {1.0, bad[k]}};
        assert_false(factor(&x));
    }
    for (int k = 0; k < 3; ++k) {
        block x = {.n = 2, .A = {1.0, 0.0, bad[k], bad[k]}, .sizes = {1.0, 1.0}};
        assert_false(factor(&x));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solutions_are_those_of_lapack_in_any_units),
        cmocka_unit_test(nothing_to_solve),
        cmocka_unit_test(dependent_columns_or_rows_are_singular),
        cmocka_unit_test(cancelled_rows_and_columns_are_singular),
        cmocka_unit_test(what_is_zero_or_not_finite_is_singular),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
