/* Small eigenproblems by Jacobi rotations against LAPACK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "algebra/jacobi.h"
#include "algebra/lapack.h"

#include <math.h>
#include <string.h>

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

/* Of columns of very different sizes. */
static void columns_become_orthogonal_however_small(void **state)
{
    (void)state;
    test_rng rng = test_seed(9);
    for (int round = 0; round < 500; ++round) {
        double A[24], B[24], lambda[4];
        const int n = 6, c = 1 + round % 4;
        test_fill(&rng, 24, A);
        for (int l = 0; l < c; ++l) {
            const double size = pow(10.0, 6.0 * test_uniform(&rng));
            for (int k = 0; k < n; ++k) A[l * n + k] *= size;
        }
        memcpy(B, A, sizeof B);
        assert_int_equal(mbsri_orthogonalise(n, c, A, lambda), 0);
        for (int l = 0; l < c; ++l) {
            if (l > 0) assert_true(lambda[l] <= lambda[l - 1]);
            for (int k = 0; k < l; ++k) {
                double product = 0.0;
                for (int r = 0; r < n; ++r) product += A[l * n + r] * A[k * n + r];
                assert_close(product, 0.0, 4e-15 * sqrt(lambda[l] * lambda[k]));
            }
        }
        /* A A^T = B B^T, row by row */
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
                double is = 0.0, was = 0.0, size = 0.0;
                for (int l = 0; l < c; ++l) {
                    is += A[l * n + j] * A[l * n + k];
                    was += B[l * n + j] * B[l * n + k];
                    size += B[l * n + j] * B[l * n + j] + B[l * n + k] * B[l * n + k];
                }
                assert_close(is, was, 1e-14 * size);
            }
        }
    }
}

/* Orthogonal columns whose squared lengths are 2 + 1e-6 and 2e-16. */
static void small_eigenvalues_keep_their_digits(void **state)
{
    (void)state;
    double A[6] = {1.0, 1.0, 1e-3, 1e-8, -1e-8, 0.0}, lambda[2];
    assert_int_equal(mbsri_orthogonalise(3, 2, A, lambda), 0);
    assert_close(lambda[0], 2.000001, 1e-14);
    assert_close(lambda[1], 2e-16, 1e-30);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_become_orthogonal_however_small),
        cmocka_unit_test(small_eigenvalues_keep_their_digits),
        cmocka_unit_test(eigenvalues_and_vectors_are_those_of_lapack),
        cmocka_unit_test(repeated_zero_and_diagonal_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
