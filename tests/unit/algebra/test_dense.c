/* Small dense products, against sums written out with their definition; small integers, so every
 * check is exact.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"

#include "algebra/dense.h"

enum { R = 3, C = 4, L = 2, SIZE = 32 };
static const double guard = 777.0;

/* Integers in -8 .. 8, then guards. */
static void fill(test_rng *rng, int n, double *x)
{
    for (int k = 0; k < SIZE; ++k) x[k] = k < n ? (double)test_integer(rng, -8, 8) : guard;
}

static void check(int n, const double *x, const double *expected)
{
    for (int k = 0; k < n; ++k) assert_close(x[k], expected[k], 0.0);
    for (int k = n; k < SIZE; ++k) assert_close(x[k], guard, 0.0);
}

static void zero_and_copy_touch_n_numbers(void **state)
{
    (void)state;
    test_rng rng = test_seed(1);
    double x[SIZE], y[SIZE], zeros[SIZE] = {0};
    fill(&rng, 5, x);
    fill(&rng, 5, y);
    mbsri_copy(5, x, y);
    check(5, y, x);
    mbsri_zero(5, y);
    check(5, y, zeros);
    mbsri_copy(0, NULL, y);
    mbsri_zero(0, NULL);
}

static void dot_is_a_sum_of_products(void **state)
{
    (void)state;
    const double x[] = {1, 2, -3}, y[] = {4, -5, 6};
    assert_close(mbsri_dot(3, x, y), -24.0, 0.0);
    assert_close(mbsri_dot(0, NULL, NULL), 0.0, 0.0);
}

static void products_with_a_vector_add_to_the_result(void **state)
{
    (void)state;
    test_rng rng = test_seed(2);
    double A[SIZE], x[SIZE], y[SIZE], expected[SIZE];
    fill(&rng, R * C, A);
    fill(&rng, C, x);
    fill(&rng, R, y);
    for (int r = 0; r < R; ++r) {
        expected[r] = y[r];
        for (int c = 0; c < C; ++c) expected[r] += -2.0 * A[c * R + r] * x[c];
    }
    mbsri_ax(R, C, -2.0, A, x, y);
    check(R, y, expected);

    fill(&rng, R, x);
    fill(&rng, C, y);
    for (int c = 0; c < C; ++c) {
        expected[c] = y[c];
        for (int r = 0; r < R; ++r) expected[c] += -2.0 * A[c * R + r] * x[r];
    }
    mbsri_atx(R, C, -2.0, A, x, y);
    check(C, y, expected);
}

static void products_of_matrices_add_to_the_result(void **state)
{
    (void)state;
    test_rng rng = test_seed(3);
    double A[SIZE], B[SIZE], X[SIZE], expected[SIZE];
    /* X (R x C) += 3 A (R x L) B (L x C) */
    fill(&rng, R * L, A), fill(&rng, L * C, B), fill(&rng, R * C, X);
    memcpy(expected, X, sizeof X);
    for (int r = 0; r < R; ++r) {
        for (int c = 0; c < C; ++c) {
            for (int l = 0; l < L; ++l) expected[c * R + r] += 3.0 * A[l * R + r] * B[c * L + l];
        }
    }
    mbsri_ab(R, L, C, 3.0, A, B, X);
    check(R * C, X, expected);
    /* X (L x C) += 3 A^T B,  A R x L, B R x C */
    fill(&rng, R * L, A), fill(&rng, R * C, B), fill(&rng, L * C, X);
    memcpy(expected, X, sizeof X);
    for (int l = 0; l < L; ++l) {
        for (int c = 0; c < C; ++c) {
            for (int r = 0; r < R; ++r) expected[c * L + l] += 3.0 * A[l * R + r] * B[c * R + r];
        }
    }
    mbsri_atb(R, L, C, 3.0, A, B, X);
    check(L * C, X, expected);
    /* X (R x C) += 3 A B^T,  A R x L, B C x L */
    fill(&rng, R * L, A), fill(&rng, C * L, B), fill(&rng, R * C, X);
    memcpy(expected, X, sizeof X);
    for (int r = 0; r < R; ++r) {
        for (int c = 0; c < C; ++c) {
            for (int l = 0; l < L; ++l) expected[c * R + r] += 3.0 * A[l * R + r] * B[l * C + c];
        }
    }
    mbsri_abt(R, L, C, 3.0, A, B, X);
    check(R * C, X, expected);
}

static void symmetrising_takes_the_mean_of_mirrored_entries(void **state)
{
    (void)state;
    test_rng rng = test_seed(4);
    double A[SIZE], expected[SIZE];
    fill(&rng, 16, A);
    memcpy(expected, A, sizeof A);
    for (int j = 0; j < 4; ++j) {
        for (int k = 0; k < 4; ++k) expected[j * 4 + k] = (A[j * 4 + k] + A[k * 4 + j]) / 2.0;
    }
    mbsri_symmetrise(4, A);
    check(16, A, expected);
}

static void a_congruence_adds_the_transformed_matrix(void **state)
{
    (void)state;
    test_rng rng = test_seed(5);
    double A[SIZE], B[SIZE], X[SIZE], T[SIZE], expected[SIZE];
    fill(&rng, R * C, A), fill(&rng, R * R, B), fill(&rng, C * C, X), fill(&rng, R * C, T);
    mbsri_symmetrise(R, B);
    memcpy(expected, X, sizeof X);
    for (int a = 0; a < C; ++a) {
        for (int b = 0; b < C; ++b) {
            for (int r = 0; r < R; ++r) {
                for (int s = 0; s < R; ++s)
                    expected[b * C + a] += A[a * R + r] * B[s * R + r] * A[b * R + s];
            }
        }
    }
    mbsri_congruence(R, C, A, B, X, T);
    check(C * C, X, expected);
    assert_close(T[R * C], guard, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zero_and_copy_touch_n_numbers),
        cmocka_unit_test(dot_is_a_sum_of_products),
        cmocka_unit_test(products_with_a_vector_add_to_the_result),
        cmocka_unit_test(products_of_matrices_add_to_the_result),
        cmocka_unit_test(symmetrising_takes_the_mean_of_mirrored_entries),
        cmocka_unit_test(a_congruence_adds_the_transformed_matrix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
