/* Small eigenproblems by Jacobi rotations against LAPACK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "algebra/jacobi.h"
#include "algebra/lapack.h"

#include <math.h>

/* B^T B of rank r, entries of very different sizes where `scaled`. */
static void make(test_rng *rng, int n, int r, int scaled, double *A)
{
    double B[36], size[6];
    test_fill(rng, 36, B);
    for (int k = 0; k < n; ++k) size[k] = scaled ? pow(10.0, 4.0 * test_uniform(rng)) : 1.0;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
            A[j * n + k] = 0.0;
            for (int l = 0; l < r; ++l) A[j * n + k] += B[6 * l + j] * B[6 * l + k];
            A[j * n + k] *= size[j] * size[k];
        }
    }
}

static void check(int n, const double *A)
{
    double X[36], lambda[6], Y[36], expected[6], work[210], size = 0.0;
    for (int k = 0; k < n * n; ++k) {
        X[k] = Y[k] = A[k];
        size = fmax(size, fabs(A[k]));
    }
    assert_int_equal(mbsri_jacobi(n, X, lambda), 0);
    assert_int_equal(mbsri_lapack_syev(n, Y, expected, work, 210), 0);
    for (int k = 0; k < n; ++k) {
        assert_close(lambda[k], expected[n - 1 - k], 6e-15 * size);
        for (int j = 0; j < n; ++j) {
            /* X is orthonormal, and A X = X diag(lambda) */
            double product = 0.0, image = 0.0;
            for (int l = 0; l < n; ++l) {
                product += X[k * n + l] * X[j * n + l];
                image += A[l * n + j] * X[k * n + l];
            }
            assert_close(product, j == k ? 1.0 : 0.0, 6e-15);
            assert_close(image, lambda[k] * X[k * n + j], 8e-15 * size);
        }
    }
}

static void eigenvalues_and_vectors_are_those_of_lapack(void **state)
{
    (void)state;
    test_rng rng = test_seed(8);
    for (int round = 0; round < 3000; ++round) {
        double A[36];
        const int n = 1 + round % MBSRI_JACOBI_MAX;
        make(&rng, n, 1 + round / 6 % n, round % 2, A);
        check(n, A);
        if (round % 10) continue;
        /* so small or large that squares of the entries are 0 or infinite */
        for (int k = 0; k < 36; ++k) A[k] *= round % 20 ? 1e-240 : 1e240;
        check(n, A);
    }
}

static void repeated_zero_and_diagonal_ones(void **state)
{
    (void)state;
    const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero[9] = {0},
                 order[9] = {1, 0, 0, 0, 3, 0, 0, 0, 2}, twice[9] = {2, 1, 1, 1, 2, 1, 1, 1, 2},
                 negative[4] = {0, 1, 1, 0};
    check(3, unit);
    check(3, zero);
    check(3, order);
    check(3, twice);
    check(2, negative);
    double nan[4] = {NAN, 1, 1, 2}, lambda[2];
    (void)mbsri_jacobi(2, nan, lambda); /* ends */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eigenvalues_and_vectors_are_those_of_lapack),
        cmocka_unit_test(repeated_zero_and_diagonal_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
