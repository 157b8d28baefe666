/* The wrappers around LAPACK on matrices whose results are known.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"

#include "algebra/lapack.h"

#include <string.h>

enum { WORK = 400 };

static void eigenvalues_come_in_ascending_order_with_their_vectors(void **state)
{
    (void)state;
    /* eigenvalues 1, 3 and 5 with the vectors (1,-1,0), (1,1,0), (0,0,1); only the lower triangle
     * is read */
    double A[9] = {2, 1, 0, 99, 2, 0, 99, 99, 5}, w[3], work[WORK];
    const int lwork = mbsri_lapack_syev_work(3);
    assert_in_range(lwork, 8, WORK);
    assert_int_equal(mbsri_lapack_syev(3, A, w, work, lwork), 0);
    assert_close(w[0], 1.0, 1e-14);
    assert_close(w[1], 3.0, 1e-14);
    assert_close(w[2], 5.0, 1e-14);
    const double r = sqrt(0.5);
    assert_close(A[0] * -A[1], 0.5, 1e-14);
    assert_close(A[2], 0.0, 1e-14);
    assert_close(A[3] * A[4], 0.5, 1e-14);
    assert_close(fabs(A[3]), r, 1e-14);
    assert_close(fabs(A[8]), 1.0, 1e-14);
}

static void one_workspace_serves_all_smaller_matrices(void **state)
{
    (void)state;
    double A[64], w[8], work[WORK];
    const int lwork = mbsri_lapack_syev_work(8);
    assert_in_range(lwork, 23, WORK);
    for (int n = 1; n <= 8; ++n) {
        for (int k = 0; k < n * n; ++k) A[k] = k % (n + 1) ? 1.0 : (double)n;
        assert_int_equal(mbsri_lapack_syev(n, A, w, work, lwork), 0);
        for (int k = 0; k < n - 1; ++k) assert_close(w[k], n - 1.0, 1e-13);
        assert_close(w[n - 1], 2.0 * n - 1.0, 1e-13);
    }
    assert_true(mbsri_lapack_syev_work(0) >= 1);
}

static void the_inverse_comes_with_its_condition(void **state)
{
    (void)state;
    /* [1 2; 3 4] by columns; 1-norms 6 and 7/2 */
    double A[4] = {1, 3, 2, 4}, work[8];
    int pivots[2];
    assert_close(mbsri_lapack_inverse(2, A, pivots, work), 1.0 / 21.0, 1e-15);
    const double expected[4] = {-2.0, 1.5, 1.0, -0.5};
    for (int k = 0; k < 4; ++k) assert_close(A[k], expected[k], 1e-14);

    double one[1] = {-4.0};
    assert_close(mbsri_lapack_inverse(1, one, pivots, work), 1.0, 0.0);
    assert_close(one[0], -0.25, 0.0);
}

static void a_singular_matrix_has_reciprocal_condition_zero(void **state)
{
    (void)state;
    double zero[1] = {0.0}, A[4] = {1, 2, 2, 4}, work[8];
    int pivots[2];
    assert_close(mbsri_lapack_inverse(1, zero, pivots, work), 0.0, 0.0);
    assert_close(mbsri_lapack_inverse(2, A, pivots, work), 0.0, 0.0);
    /* regular, but so close that the condition shows it */
    double near[4] = {1, 1, 1, 1 + 1e-12};
    const double rcond = mbsri_lapack_inverse(2, near, pivots, work);
    assert_close(rcond, 2.5e-13, 1e-16);
}

static void least_squares_solves_tall_systems(void **state)
{
    (void)state;
    /* a line through (0,1), (1,2), (2,5): 2/3 + 2 x */
    double A[6] = {1, 1, 1, 0, 1, 2}, b[3] = {1, 2, 5}, work[WORK];
    int pivots[2], rank = -1;
    const int lwork = mbsri_lapack_gelsy_work(3, 2);
    assert_in_range(lwork, 1, WORK);
    assert_int_equal(mbsri_lapack_gelsy(3, 2, A, b, 1e-9, pivots, &rank, work, lwork), 0);
    assert_int_equal(rank, 2);
    assert_close(b[0], 2.0 / 3.0, 1e-14);
    assert_close(b[1], 2.0, 1e-14);
}

static void least_squares_sees_dependent_columns(void **state)
{
    (void)state;
    /* both columns (1,2,3): rank 1, the shortest solution of b = (2,4,6) is (1,1) */
    double A[6] = {1, 2, 3, 1, 2, 3}, b[3] = {2, 4, 6}, work[WORK];
    int pivots[2] = {1, 1}, rank = -1;
    const int lwork = mbsri_lapack_gelsy_work(3, 2);
    assert_int_equal(mbsri_lapack_gelsy(3, 2, A, b, 1e-9, pivots, &rank, work, lwork), 0);
    assert_int_equal(rank, 1);
    assert_close(b[0], 1.0, 1e-14);
    assert_close(b[1], 1.0, 1e-14);

    double zero[6] = {0}, c[3] = {1, 2, 3};
    assert_int_equal(mbsri_lapack_gelsy(3, 2, zero, c, 1e-9, pivots, &rank, work, lwork), 0);
    assert_int_equal(rank, 0);
    assert_close(c[0], 0.0, 0.0);
    assert_close(c[1], 0.0, 0.0);
}

/* Pivots left by another call would fix the small column in front and drop the large one. */
static void the_largest_column_counts_whatever_the_pivots_were(void **state)
{
    (void)state;
    double A[4] = {1e-12, 0, 0, 1}, b[2] = {0, 3}, work[WORK];
    int pivots[2] = {1, 1}, rank = -1;
    const int lwork = mbsri_lapack_gelsy_work(2, 2);
    assert_int_equal(mbsri_lapack_gelsy(2, 2, A, b, 1e-9, pivots, &rank, work, lwork), 0);
    assert_int_equal(rank, 1);
    assert_close(b[0], 0.0, 1e-11);
    assert_close(b[1], 3.0, 1e-13);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eigenvalues_come_in_ascending_order_with_their_vectors),
        cmocka_unit_test(one_workspace_serves_all_smaller_matrices),
        cmocka_unit_test(the_inverse_comes_with_its_condition),
        cmocka_unit_test(a_singular_matrix_has_reciprocal_condition_zero),
        cmocka_unit_test(least_squares_solves_tall_systems),
        cmocka_unit_test(least_squares_sees_dependent_columns),
        cmocka_unit_test(the_largest_column_counts_whatever_the_pivots_were),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
