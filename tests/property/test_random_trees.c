/* Random trees: recursions against the dense oracle and against each other.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Bodies of dimension 1 to 12, joints with 0 to d degrees of freedom, masses of every rank, about
 * half of them deficient, so that deficient bodies are adjacent more often than not. */
#include "duration.h"
#include "oracle.h"

#include "assembly/data.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

#define TREES (test_long() ? 600 : test_seeds_short(150, 300))
enum { MOST = 256 };

/* One tree in a random state; u and q in one array, as the oracle wants them. */
typedef struct state {
    test_tree tree;
    test_oracle oracle;
    int n;
    double *u, *q, *udot, *tau, *residual, *other;
} state;

static test_tree_opt options(int seed, double deficient)
{
    return (test_tree_opt){.seed = (uint64_t)seed,
                           .bodies = 1 + seed % 12,
                           .max_d = seed % 7 == 0 ? 12 : 6,
                           .welds = 1,
                           .deficient = deficient,
                           .bend = 0.1,
                           .moving_root = seed % 3 == 0};
}

static const double time_now = 0.3; /* the oracle's */

static void setup(state *s, test_tree_opt opt)
{
    test_tree_make(&s->tree, opt);
    s->n = s->tree.nu;
    assert_true(s->n <= MOST);
    s->u = calloc(6 * MOST, sizeof(double));
    s->q = s->u + s->n;
    s->udot = s->u + 2 * MOST;
    s->tau = s->u + 3 * MOST;
    s->residual = s->u + 4 * MOST;
    s->other = s->u + 5 * MOST;
    test_rng rng = test_seed(opt.seed + 1000);
    test_fill(&rng, 2 * s->n, s->u);
    test_fill(&rng, s->n, s->udot);
    mbsr_data *d = s->tree.data;
    mbsri_data_poison(d);
    assert_int_equal(mbsr_stage_positions(s->tree.model, d, time_now, s->q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(s->tree.model, d, s->u), MBSR_OK);
    test_oracle_make(&s->oracle, &s->tree, s->u);
}

static void teardown(state *s)
{
    test_oracle_free(&s->oracle);
    test_tree_free(&s->tree);
    free(s->u);
}

/* Size that rounding errors of a result of this tree may have. */
static double rounding(const state *s)
{
    return 1e-12 * (1.0 + test_largest(s->n * s->n, s->oracle.mass));
}

static void inverse(state *s, const double *udot, double *tau)
{
    mbsri_data_poison(s->tree.data);
    assert_int_equal(
        mbsr_inverse_dynamics(s->tree.model, s->tree.data, time_now, s->q, s->u, udot, NULL, tau),
        MBSR_OK);
}

static void recursive(state *s, const double *udot, const double *tau, double *residual)
{
    mbsri_data_poison(s->tree.data);
    const int status = mbsr_recursive_residual(s->tree.model, s->tree.data, time_now, s->q, s->u,
                                               udot, tau, residual);
    if (status) print_error("%s\n", mbsr_data_error(s->tree.data)->text);
    assert_int_equal(status, MBSR_OK);
}

/* Smallest scaled eigenvalue that counted as not zero: rounding errors grow with its reciprocal. */
static double smallest_kept(const state *s)
{
    double value = 1.0;
    for (int i = 0; i < s->tree.N; ++i) {
        mbsr_rank_info info;
        assert_int_equal(mbsr_body_rank(s->tree.model, s->tree.data, i, &info), MBSR_OK);
        if (info.rank > 0) value = fmin(value, info.smallest_kept);
    }
    return value;
}

static void mass_matrix_is_that_of_the_dense_equations(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, options(seed, 0.5));
        double *matrix = calloc((size_t)(s.n * s.n) + 1, sizeof(double));
        assert_int_equal(mbsr_mass_matrix(s.tree.model, s.tree.data, matrix), MBSR_OK);
        for (int k = 0; k < s.n * s.n; ++k) assert_close(matrix[k], s.oracle.mass[k], rounding(&s));
        free(matrix);
        teardown(&s);
    }
}

/* tau = B^T M (B u' + bII): no recursion in it. */
static void inverse_dynamics_is_that_of_the_dense_equations(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, options(seed, 0.5));
        const test_oracle *o = &s.oracle;
        inverse(&s, s.udot, s.tau);
        double *A = calloc((size_t)o->v + 1, sizeof(double)),
               *MA = calloc((size_t)o->v + 1, sizeof(double));
        for (int r = 0; r < o->v; ++r) {
            A[r] = o->bII[r];
            for (int c = 0; c < o->n; ++c) A[r] += o->B[c * o->v + r] * s.udot[c];
        }
        for (int c = 0; c < o->v; ++c) {
            for (int r = 0; r < o->v; ++r) MA[r] += o->M[c * o->v + r] * A[c];
        }
        for (int c = 0; c < o->n; ++c) {
            double tau = 0.0;
            for (int r = 0; r < o->v; ++r) tau += o->B[c * o->v + r] * MA[r];
            assert_close(s.tau[c], tau, 10.0 * rounding(&s) * (1.0 + test_largest(o->v, A)));
        }
        free(A);
        free(MA);
        teardown(&s);
    }
}

static void forward_dynamics_of_regular_trees_is_the_dense_solution(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES / 2; ++seed) {
        state s;
        setup(&s, options(seed, 0.0));
        /* M u' = tau - (bias torque) */
        inverse(&s, s.udot, s.tau);
        memset(s.residual, 0, sizeof(double) * (size_t)s.n);
        inverse(&s, s.residual, s.other);
        for (int k = 0; k < s.n; ++k) s.other[k] = s.tau[k] - s.other[k];
        double *matrix = calloc((size_t)(s.n * s.n) + 1, sizeof(double));
        memcpy(matrix, s.oracle.mass, sizeof(double) * (size_t)(s.n * s.n));
        test_solve(s.n, matrix, s.other);
        mbsri_data_poison(s.tree.data);
        assert_int_equal(
            mbsr_forward_dynamics(s.tree.model, s.tree.data, time_now, s.q, s.u, s.tau, s.residual),
            MBSR_OK);
        /* what both must give back is the acceleration the forces were made from */
        double tolerance = 1e-13 * (1.0 + test_largest(s.n, s.tau)) / smallest_kept(&s);
        for (int k = 0; k < s.n; ++k) {
            tolerance = fmax(tolerance, 10.0 * fabs(s.other[k] - s.udot[k]));
        }
        for (int k = 0; k < s.n; ++k) assert_close(s.residual[k], s.udot[k], tolerance);
        free(matrix);
        teardown(&s);
    }
}

static void recursive_residual_vanishes_where_inverse_dynamics_does(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, options(seed, 0.5));
        inverse(&s, s.udot, s.tau);
        recursive(&s, s.udot, s.tau, s.residual);
        const double tolerance = 1e-13 * (1.0 + test_largest(s.n, s.tau)) / smallest_kept(&s);
        for (int k = 0; k < s.n; ++k) assert_close(s.residual[k], 0.0, tolerance);
        teardown(&s);
    }
}

/* Both residuals are affine in u'. The recursive one's matrix R has the rank of the mass matrix,
 * and R z = 0 for every null vector z of the mass matrix: so it vanishes nowhere else. */
static void recursive_residual_has_the_null_space_of_the_mass_matrix(void **unused)
{
    (void)unused;
    int deficient = 0;
    for (int seed = 1; seed <= TREES / 2; ++seed) {
        state s;
        setup(&s, options(seed, 0.5));
        const int n = s.n;
        double *R = calloc((size_t)(n * n) + 1, sizeof(double));
        double *step = s.other;
        memset(step, 0, sizeof(double) * (size_t)n);
        recursive(&s, step, NULL, s.residual);
        for (int c = 0; c < n; ++c) {
            step[c] = 1.0;
            recursive(&s, step, NULL, R + c * n);
            step[c] = 0.0;
            for (int k = 0; k < n; ++k) R[c * n + k] -= s.residual[k];
        }
        int all[MOST];
        for (int k = 0; k < n; ++k) all[k] = k;
        const int rank = test_rank(&s.oracle, n, all, NULL);
        assert_int_equal(rank, mbsr_total_rank(s.tree.model, s.tree.data));
        deficient += rank < n;
        test_rng rng = test_seed((uint64_t)seed);
        for (int trial = 0; trial < 3 && rank < n; ++trial) {
            double z[MOST];
            test_fill(&rng, n, z);
            test_null_projection(n, s.oracle.mass, rank, z);
            for (int k = 0; k < n; ++k) {
                double product = 0.0;
                for (int c = 0; c < n; ++c) product += R[c * n + k] * z[c];
                assert_close(product, 0.0, 1e-9 * (1.0 + test_largest(n * n, R)));
            }
        }
        assert_int_equal(test_singular_rank(n, R), rank);
        free(R);
        teardown(&s);
    }
    assert_true(deficient > TREES / 8);
}

/* D_i is what is left of the mass matrix of the subtree of i when its successors are eliminated, so
 * rank D_i = rank(subtree with i) - rank(subtree without i). */
static void ranks_are_those_of_the_dense_mass_matrix(void **unused)
{
    (void)unused;
    double kept = 1.0, dropped = 0.0;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, options(seed, 0.5));
        recursive(&s, s.udot, NULL, s.residual);
        for (int i = 0; i < s.tree.N; ++i) {
            int below[MOST], count = 0, first, n;
            for (int j = 0; j < s.tree.N; ++j) {
                int k = j;
                while (k >= 0 && k != i) k = s.tree.parent[k];
                assert_int_equal(mbsr_body_coordinates(s.tree.model, j, NULL, NULL, &first, &n),
                                 MBSR_OK);
                for (int c = 0; k == i && j != i && c < n; ++c) below[count++] = first + c;
            }
            const int without = test_rank(&s.oracle, count, below, NULL);
            assert_int_equal(mbsr_body_coordinates(s.tree.model, i, NULL, NULL, &first, &n),
                             MBSR_OK);
            for (int c = 0; c < n; ++c) below[count++] = first + c;
            const int with = test_rank(&s.oracle, count, below, NULL);
            mbsr_rank_info info;
            assert_int_equal(mbsr_body_rank(s.tree.model, s.tree.data, i, &info), MBSR_OK);
            assert_int_equal(info.n, n);
            assert_int_equal(info.rank, with - without);
            if (info.rank > 0) kept = fmin(kept, info.smallest_kept);
            dropped = fmax(dropped, info.largest_dropped);
        }
        teardown(&s);
    }
    /* the tolerance 1e-12 stands in a wide gap */
    assert_less(dropped, 5e-14);
    assert_less(1e-10, kept);
}

static void numbering_does_not_matter(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES / 2; ++seed) {
        test_tree_opt opt = options(seed, 0.5);
        opt.forces = 1;
        state a, b;
        setup(&a, opt);
        opt.shuffle = 1;
        test_tree_make(&b.tree, opt);
        b.n = b.tree.nu;
        assert_int_equal(a.n, b.n);
        double x[3 * MOST], rb[MOST];
        for (int id = 0; id < b.tree.N; ++id) {
            int from, to, n;
            assert_int_equal(
                mbsr_body_coordinates(a.tree.model, b.tree.label[id], NULL, NULL, &from, &n),
                MBSR_OK);
            assert_int_equal(mbsr_body_coordinates(b.tree.model, id, NULL, NULL, &to, NULL),
                             MBSR_OK);
            for (int k = 0; k < n; ++k) {
                x[to + k] = a.q[from + k];
                x[MOST + to + k] = a.u[from + k];
                x[2 * MOST + to + k] = a.udot[from + k];
            }
        }
        recursive(&a, a.udot, NULL, a.residual);
        assert_int_equal(mbsr_recursive_residual(b.tree.model, b.tree.data, time_now, x, x + MOST,
                                                 x + 2 * MOST, NULL, rb),
                         MBSR_OK);
        for (int id = 0; id < b.tree.N; ++id) {
            int from, to, n;
            mbsr_rank_info ia, ib;
            const int label = b.tree.label[id];
            assert_int_equal(mbsr_body_coordinates(a.tree.model, label, NULL, NULL, &from, &n),
                             MBSR_OK);
            assert_int_equal(mbsr_body_coordinates(b.tree.model, id, NULL, NULL, &to, NULL),
                             MBSR_OK);
            for (int k = 0; k < n; ++k) {
                assert_close(rb[to + k], a.residual[from + k],
                             1e-8 * (1.0 + test_largest(a.n, a.residual)));
            }
            assert_int_equal(mbsr_body_rank(a.tree.model, a.tree.data, label, &ia), MBSR_OK);
            assert_int_equal(mbsr_body_rank(b.tree.model, b.tree.data, id, &ib), MBSR_OK);
            assert_int_equal(ia.rank, ib.rank);
        }
        teardown(&a);
        test_tree_free(&b.tree);
    }
}

/* Lengths in other units for every coordinate of every body: nothing may change. Done by scaling
 * the columns of J0 and the joint forces. */
static void units_of_joint_coordinates_do_not_change_ranks(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES / 4; ++seed) {
        test_tree_opt opt = options(seed, 0.5);
        opt.bend = 0.0;
        state a, b;
        setup(&a, opt);
        opt.units = 1;
        setup(&b, opt);
        recursive(&a, a.udot, NULL, a.residual);
        recursive(&b, b.udot, NULL, b.residual);
        for (int i = 0; i < a.tree.N; ++i) {
            mbsr_rank_info ia, ib;
            assert_int_equal(mbsr_body_rank(a.tree.model, a.tree.data, i, &ia), MBSR_OK);
            assert_int_equal(mbsr_body_rank(b.tree.model, b.tree.data, i, &ib), MBSR_OK);
            assert_int_equal(ia.rank, ib.rank);
            assert_close(ib.smallest_kept, ia.smallest_kept, 1e-9);
        }
        teardown(&a);
        teardown(&b);
    }
}

static void a_consistent_start_keeps_momenta_and_solves_both_forms(void **unused)
{
    (void)unused;
    int started = 0;
    for (int seed = 1; seed <= TREES / 4; ++seed) {
        test_tree_opt opt = options(seed, 0.5);
        opt.forces = 1;
        state s;
        setup(&s, opt);
        const int n = s.n;
        double y[2 * MOST], yp[2 * MOST], F[2 * MOST];
        memcpy(y, s.q, sizeof(double) * (size_t)n);
        memcpy(y + n, s.u, sizeof(double) * (size_t)n);
        mbsr_consistent_info info;
        mbsri_data_poison(s.tree.data);
        const int status = mbsr_dae_consistent(s.tree.model, s.tree.data, MBSR_DAE_RECURSIVE,
                                               time_now, y, yp, NULL, &info);
        assert_int_equal(status, MBSR_OK);
        started += info.null_directions > 0;
        assert_memory_equal(y, s.q, sizeof(double) * (size_t)n);
        /* momenta M u */
        for (int r = 0; r < n; ++r) {
            double change = 0.0;
            for (int c = 0; c < n; ++c) change += s.oracle.mass[c * n + r] * (y[n + c] - s.u[c]);
            assert_close(change, 0.0,
                         1e-9 * (1.0 + info.velocity_change) *
                             (1.0 + test_largest(n * n, s.oracle.mass)));
        }
        const mbsr_dae_form forms[] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS};
        const double size =
            1.0 + test_largest(2 * n, yp) * (1.0 + test_largest(n * n, s.oracle.mass));
        for (int f = 0; f < 2; ++f) {
            assert_int_equal(
                mbsr_dae_residual(s.tree.model, s.tree.data, forms[f], time_now, y, yp, F),
                MBSR_OK);
            for (int k = 0; k < 2 * n; ++k) assert_close(F[k], 0.0, 1e-9 * size);
        }
        teardown(&s);
    }
    assert_true(started > TREES / 16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mass_matrix_is_that_of_the_dense_equations),
        cmocka_unit_test(inverse_dynamics_is_that_of_the_dense_equations),
        cmocka_unit_test(forward_dynamics_of_regular_trees_is_the_dense_solution),
        cmocka_unit_test(recursive_residual_vanishes_where_inverse_dynamics_does),
        cmocka_unit_test(recursive_residual_has_the_null_space_of_the_mass_matrix),
        cmocka_unit_test(ranks_are_those_of_the_dense_mass_matrix),
        cmocka_unit_test(numbering_does_not_matter),
        cmocka_unit_test(units_of_joint_coordinates_do_not_change_ranks),
        cmocka_unit_test(a_consistent_start_keeps_momenta_and_solves_both_forms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
