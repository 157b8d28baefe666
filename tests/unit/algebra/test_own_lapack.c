/* The library's own LAPACK routines: what defines their results, and the digits of LAPACK, on
 * random matrices of many sizes, graded, singular, and near the limits of the exponent.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"

#include "algebra/lapack.h"

#define MBSR_OWN_LAPACK
#include "algebra/fortran.h"

#include <stdbool.h>
#include <string.h>

enum { MOST = 24, CELLS = MOST * MOST, WORK = 4 * CELLS };
typedef enum kind {
    PLAIN,
    SYMMETRIC,
    GRADED,
    SINGULAR,
    RANK_ONE,
    HUGE_ENTRIES,
    TINY_ENTRIES,
    KINDS
} kind;

/* n x n, n <= MOST; symmetric where asked for. */
static void make(kind k, bool symmetric, int n, uint64_t seed, double *A)
{
    test_rng rng = test_seed(seed);
    const double unit = k == HUGE_ENTRIES ? 1e300 : k == TINY_ENTRIES ? 1e-300 : 1.0;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const double entry = unit * test_uniform(&rng), grade = pow(10.0, -0.5 * (i + j));
            A[i + j * n] = k == GRADED ? grade * entry : entry;
        }
    }
    for (int i = 0; i < n && k == SINGULAR && n > 1; ++i) A[i + (n - 1) * n] = A[i];
    for (int i = 0; i < n && k == SINGULAR && n > 1; ++i) A[n - 1 + i * n] = A[i * n];
    for (int j = 0; j < n && k == RANK_ONE; ++j) {
        for (int i = 0; i < n; ++i) A[i + j * n] = sin(1.0 + i) * sin(1.0 + j);
    }
    for (int j = 0; j < n && symmetric; ++j) {
        for (int i = 0; i < j; ++i) A[i + j * n] = A[j + i * n];
    }
}

static double largest(int n, const double *x)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k]));
    return most;
}

/* C = A B or A^T B, n x n. */
static void multiply(const char *transposed, int n, const double *A, const double *B, double *C)
{
    const double one = 1.0, zero = 0.0;
    dgemm_(transposed, "N", &n, &n, &n, &one, A, &n, B, &n, &zero, C, &n, 1, 1);
}

static void assert_orthogonal(int n, const double *Q)
{
    double product[CELLS];
    multiply("T", n, Q, Q, product);
    for (int k = 0; k < n * n; ++k) assert_close(product[k], k % (n + 1) ? 0.0 : 1.0, 1e-13);
}

static void eigenvectors_diagonalise(void **state)
{
    (void)state;
    for (int n = 1; n <= MOST; ++n) {
        for (kind k = PLAIN; k < KINDS; ++k) {
            double A[CELLS], Q[CELLS], AQ[CELLS], w[MOST], expected[MOST], work[WORK],
                theirs[CELLS];
            int info = 0;
            const int lwork = WORK;
            make(k, true, n, (uint64_t)(100 * n + (int)k), A);
            memcpy(Q, A, sizeof Q);
            memcpy(theirs, A, sizeof theirs);
            dsyev_("V", "L", &n, Q, &n, w, work, &lwork, &info, 1, 1);
            assert_int_equal(info, 0);
            assert_orthogonal(n, Q);
            multiply("N", n, A, Q, AQ);
            const double size = largest(n * n, A) * n;
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i)
                    assert_close(AQ[i + j * n], w[j] * Q[i + j * n], 1e-14 * size);
                assert_true(j == 0 || w[j] >= w[j - 1]);
            }
            assert_int_equal(mbsri_lapack_syev(n, theirs, expected, work, WORK), 0);
            for (int j = 0; j < n; ++j) assert_close(w[j], expected[j], 1e-14 * size);
        }
    }
}

static void singular_vectors_make_up_the_matrix(void **state)
{
    (void)state;
    for (int n = 1; n <= MOST; ++n) {
        for (kind k = PLAIN; k < KINDS; ++k) {
            double A[CELLS], B[CELLS], s[MOST], U[CELLS], Vt[CELLS], work[WORK], expected[MOST],
                alone[MOST], C[CELLS];
            int info = 0;
            const int lwork = WORK;
            make(k, false, n, (uint64_t)(300 * n + (int)k), A);
            memcpy(B, A, sizeof B);
            dgesvd_("A", "A", &n, &n, B, &n, s, U, &n, Vt, &n, work, &lwork, &info, 1, 1);
            assert_int_equal(info, 0);
            assert_orthogonal(n, U);
            assert_orthogonal(n, Vt);
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) B[j + i * n] = s[j] * Vt[j + i * n];
                assert_true(j == 0 || s[j] <= s[j - 1]);
            }
            multiply("N", n, U, B, C);
            for (int j = 0; j < n * n; ++j) assert_close(C[j], A[j], 1e-14 * n * s[0]);
            memcpy(B, A, sizeof B);
            dgesvd_("N", "N", &n, &n, B, &n, alone, NULL, &n, NULL, &n, work, &lwork, &info, 1, 1);
            memcpy(B, A, sizeof B);
            assert_int_equal(mbsri_lapack_singular_values(n, B, expected, work, WORK), 0);
            for (int j = 0; j < n; ++j) {
                assert_close(s[j], expected[j], 1e-14 * n * s[0]);
                assert_close(alone[j], s[j], 1e-15 * n * s[0]);
            }
        }
    }
}

static void inverses_and_their_norms(void **state)
{
    (void)state;
    for (int n = 1; n <= MOST; ++n) {
        double A[CELLS], B[CELLS], C[CELLS], work[WORK];
        int pivots[MOST], theirs[MOST], info = 0;
        const int lwork = WORK;
        make(PLAIN, false, n, (uint64_t)(500 + n), A);
        memcpy(B, A, sizeof B);
        memcpy(C, A, sizeof C);
        const double norm = dlange_("1", &n, &n, A, &n, work, 1);
        dgetrf_(&n, &n, B, &n, pivots, &info);
        assert_int_equal(info, 0);
        dgetri_(&n, B, &n, pivots, work, &lwork, &info);
        assert_int_equal(info, 0);
        const double inverse = dlange_("1", &n, &n, B, &n, work, 1),
                     rcond = mbsri_lapack_inverse(n, C, theirs, work);
        assert_close(1.0 / (norm * inverse), rcond, 1e-12);
        for (int k = 0; k < n * n; ++k) assert_close(B[k], C[k], 1e-14 / rcond * largest(n * n, C));
        multiply("N", n, A, B, C);
        for (int k = 0; k < n * n; ++k) assert_close(C[k], k % (n + 1) ? 0.0 : 1.0, 1e-14 / rcond);
    }
    double singular[4] = {1.0, 2.0, 2.0, 4.0};
    int pivots[2], info = 0;
    const int two = 2;
    dgetrf_(&two, &two, singular, &two, pivots, &info);
    assert_int_equal(info, 2);
}

static void cholesky_factors_solve(void **state)
{
    (void)state;
    for (int n = 1; n <= MOST; ++n) {
        double G[CELLS], A[CELLS], X[CELLS], B[CELLS];
        int info = 0;
        make(PLAIN, false, n, (uint64_t)(700 + n), G);
        multiply("T", n, G, G, A);
        for (int k = 0; k < n; ++k) A[k * (n + 1)] += 1.0;
        memcpy(G, A, sizeof G);
        make(PLAIN, false, n, (uint64_t)(800 + n), B);
        memcpy(X, B, sizeof X);
        dpotrf_("L", &n, G, &n, &info, 1);
        assert_int_equal(info, 0);
        dpotrs_("L", &n, &n, G, &n, X, &n, &info, 1);
        multiply("N", n, A, X, G);
        for (int k = 0; k < n * n; ++k) assert_close(G[k], B[k], 1e-13 * n);
    }
    double indefinite[4] = {1.0, 2.0, 2.0, 1.0};
    int info = 0;
    const int two = 2;
    dpotrf_("L", &two, indefinite, &two, &info, 1);
    assert_int_equal(info, 2);
}

/* r x c, of rank `rank`: least squares of least norm. */
static void solve_least_squares(int r, int c, int rank, uint64_t seed)
{
    enum { ROOM = 12 * 12 };
    double L[ROOM], R[ROOM], A[ROOM], B[ROOM], C[ROOM], b[12], x[12], y[12], work[4 * ROOM];
    int pivots[12] = {0}, found = 0, theirs = 0, info = 0;
    const int one = 1, longer = r > c ? r : c, lwork = 4 * ROOM;
    const double rcond = 1e-10, unit = 1.0, zero = 0.0;
    test_rng rng = test_seed(seed);
    for (int k = 0; k < r * rank; ++k) L[k] = test_uniform(&rng);
    for (int k = 0; k < rank * c; ++k) R[k] = test_uniform(&rng);
    for (int k = 0; k < r; ++k) x[k] = y[k] = b[k] = test_uniform(&rng);
    dgemm_("N", "N", &r, &c, &rank, &unit, L, &r, R, &rank, &zero, A, &r, 1, 1);
    memcpy(B, A, sizeof B);
    memcpy(C, A, sizeof C);
    dgelsy_(&r, &c, &one, B, &r, x, &longer, pivots, &rcond, &found, work, &lwork, &info);
    assert_int_equal(info, 0);
    assert_int_equal(found, rank);
    assert_int_equal(mbsri_lapack_gelsy(r, c, C, y, rcond, pivots, &theirs, work, lwork), 0);
    assert_int_equal(theirs, rank);
    for (int k = 0; k < c; ++k) assert_close(x[k], y[k], 1e-9 * (1.0 + largest(c, y)));
}

static void least_squares_have_least_norm(void **state)
{
    (void)state;
    for (int r = 1; r <= 12; ++r) {
        for (int c = 1; c <= 12; ++c) {
            for (int rank = 1; rank <= (r < c ? r : c); rank += 2)
                solve_least_squares(r, c, rank, (uint64_t)(1000 + 100 * r + 10 * c + rank));
        }
    }
}

static void zero_is_served(void **state)
{
    (void)state;
    double A[9] = {0.0}, s[3], U[9], Vt[9], work[40], w[3], b[3] = {1.0, 2.0, 3.0};
    const int n = 3, lwork = 40, one = 1;
    const double rcond = 1e-12;
    int info = 0, rank = 7, pivots[3] = {0};
    dgesvd_("A", "A", &n, &n, A, &n, s, U, &n, Vt, &n, work, &lwork, &info, 1, 1);
    assert_int_equal(info, 0);
    assert_orthogonal(3, U);
    assert_orthogonal(3, Vt);
    dsyev_("V", "L", &n, A, &n, w, work, &lwork, &info, 1, 1);
    assert_orthogonal(3, A);
    for (int k = 0; k < 9; ++k) A[k] = 0.0;
    dgelsy_(&n, &n, &one, A, &n, b, &n, pivots, &rcond, &rank, work, &lwork, &info);
    assert_int_equal(rank, 0);
    for (int k = 0; k < 3; ++k) {
        assert_close(s[k], 0.0, 0.0);
        assert_close(w[k], 0.0, 0.0);
        assert_close(b[k], 0.0, 0.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eigenvectors_diagonalise),
        cmocka_unit_test(singular_vectors_make_up_the_matrix),
        cmocka_unit_test(inverses_and_their_norms),
        cmocka_unit_test(cholesky_factors_solve),
        cmocka_unit_test(least_squares_have_least_norm),
        cmocka_unit_test(zero_is_served),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
