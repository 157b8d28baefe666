/* Ranks of many loops at random places of one tree, so that many of them are open at once, by the
 * singular values of all rows, and starts there.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "loops.h"
#include "oracle.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

enum { BODIES = 100 };

/* Hinges at points p along random axes, on the body before or on any other; every third body or so
 * is held to another one by a ball joint between both: closed at q = 0. */
static void make(loops *s, test_rng *rng, int bodies)
{
    static const double com[3] = {0.1, 0.2, -0.1}, tensor[6] = {0.3, 0.4, 0.5, 0.01, 0.02, -0.03};
    double p[BODIES][3];
    int parent[BODIES];
    loops_begin(s, NULL);
    for (int i = 0; i < bodies; ++i) {
        double axis[3];
        mbsr_body_def def = mbsr_default_body_def();
        parent[i] = def.parent = test_integer(rng, 0, 2) > 0 ? i - 1 : test_integer(rng, -1, i - 1);
        test_fill(rng, 3, p[i]);
        test_fill(rng, 3, axis);
        const mbsr_frame A = mbsr_frame_at(0.5 * p[i][0], 0.5 * p[i][1], 0.5 * p[i][2]);
        def.joint = mbsr_joint_revolute(&A, NULL, axis);
        def.inertia = mbsr_inertia_rigid(1.0 + 0.5 * test_uniform(rng), com, tensor);
        for (int k = 0; k < 3; ++k)
            p[i][k] = 0.5 * p[i][k] + (parent[i] < 0 ? 0.0 : p[parent[i]][k]);
        assert_ok(mbsr_model_add_body(s->m, &def, NULL), mbsr_model_error(s->m));
    }
    for (int l = 0; l < 3 * bodies / 10; ++l) {
        int a = 0, b = 0;
        double to_a[3], to_b[3];
        while (a == b || parent[a] == b || parent[b] == a) {
            a = test_integer(rng, 0, bodies - 1);
            b = test_integer(rng, 0, bodies - 1);
        }
        for (int k = 0; k < 3; ++k) {
            to_b[k] = 0.5 * (p[a][k] - p[b][k]) + 0.1 * test_uniform(rng);
            to_a[k] = p[b][k] + to_b[k] - p[a][k];
        }
        const mbsr_closure_def def = mbsr_closure_ball(a, to_a, b, to_b);
        assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    }
    loops_build(s);
}

/* The rank of the rows that `without` (NULL: none) does not mark, each of length 1, at the
 * positions of the data. */
static int rank_of(const loops *s, const int *without)
{
    const size_t n = (size_t)s->nu;
    double *A = calloc(n * n, sizeof *A), *e = calloc((size_t)s->rows, sizeof *e);
    assert_true(s->rows <= s->nu);
    for (int k = 0; k < s->rows; ++k) {
        double *row = A + (size_t)k * n, square = 0.0;
        if (without && without[k]) continue;
        e[k] = 1.0;
        assert_ok(mbsr_closures_transpose(s->m, s->d, e, row), mbsr_data_error(s->d));
        e[k] = 0.0;
        for (size_t j = 0; j < n; ++j) square += row[j] * row[j];
        for (size_t j = 0; j < n && square > 0.0; ++j) row[j] /= sqrt(square);
    }
    const int rank = test_singular_rank(s->nu, A);
    free(A);
    free(e);
    return rank;
}

static void reports(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        mbsr_closure_report report;
        int redundant[BODIES], unique[BODIES], dropped = 0;
        const double q[BODIES] = {0.0};
        make(&s, &rng, test_integer(&rng, 60, BODIES));
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, q, &report, redundant, unique),
                  mbsr_data_error(s.d));
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, q), mbsr_data_error(s.d));
        const int rank = rank_of(&s, NULL);
        for (int k = 0; k < s.rows; ++k) dropped += redundant[k];
        assert_int_equal(report.independent, rank);
        assert_int_equal(report.nearby, rank);
        assert_int_equal(report.mobility, s.nu - rank);
        assert_int_equal(s.rows - dropped, rank);
        assert_int_equal(rank_of(&s, redundant), rank);
        loops_free(&s);
    }
}

/* From positions that are not closed: gaps, their rates and the residual vanish, and the rows that
 * the data leaves out are as many as there are too many. */
static void starts(void **state)
{
    (void)state;
    for (uint64_t seed = 11; seed <= 16; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        int redundant[BODIES], dropped = 0;
        double q[BODIES], u[BODIES], rows[BODIES];
        make(&s, &rng, test_integer(&rng, 60, BODIES));
        double *y = calloc(3 * (size_t)s.size, sizeof *y), *yp = y + s.size, *F = yp + s.size;
        const mbsr_error *error = mbsr_data_error(s.d);
        test_fill(&rng, s.nq, q);
        test_fill(&rng, s.nu, u);
        for (int k = 0; k < s.nq; ++k) q[k] *= 1e-2, u[k] *= 0.1;
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), error);
        assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), error);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error);
        assert_less(test_largest(s.size, F), 1e-9 * (1.0 + test_largest(s.size, yp)));
        assert_ok(mbsr_dae_unpack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, q, u), error);
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, q), error);
        assert_ok(mbsr_stage_velocities(s.m, s.d, u), error);
        assert_ok(mbsr_closures_gap(s.m, s.d, rows), error);
        assert_less(test_largest(s.position_rows, rows), 1e-10);
        assert_ok(mbsr_closures_rate(s.m, s.d, rows), error);
        assert_less(test_largest(s.rows, rows), 1e-10);
        assert_ok(mbsr_closures_redundant(s.m, s.d, redundant), error);
        for (int k = 0; k < s.rows; ++k) dropped += redundant[k];
        assert_int_equal(rank_of(&s, NULL), s.rows - dropped);
        assert_int_equal(rank_of(&s, redundant), s.rows - dropped);
        free(y);
        loops_free(&s);
    }
}

/* Cranks of one length in a line, coupled in a row or in parallel: flat, where every loop may
 * branch, of each two rows one depends on others there alone. */
static void flat_mechanisms(void **state)
{
    (void)state;
    const int seeds = test_long() ? 1500 : 174;
    int missed = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; ++seed) {
        test_rng rng = test_seed(seed);
        const int count = test_integer(&rng, 1, 14);
        const double length = 0.6 + 0.4 * test_uniform(&rng);
        const bool in_parallel = test_integer(&rng, 0, 2) == 1;
        mbsr_closure_report report;
        loops s;
        loops_begin(&s, NULL);
        const int first = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.0, 1.0, length);
        double place = 0.0;
        for (int k = 1, last = first; k <= count; ++k) {
            const double way = 1.0 + 0.5 * test_uniform(&rng);
            const bool again = in_parallel && test_uniform(&rng) > 0.0;
            const int rod = loops_rod(&s, NULL, again ? first : last, length, 0.0, 1.0, way);
            place = (again ? 0.0 : place) + way;
            last = loops_rod(&s, NULL, MBSR_GROUND, place, 0.0, 1.0, length);
            loops_pin(&s, NULL, rod, way, 0.0, last, length, 0.0);
        }
        loops_build(&s);
        double *q = calloc((size_t)s.nq, sizeof *q);
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, q, &report, NULL, NULL),
                  mbsr_data_error(s.d));
        assert_int_equal(report.independent, count);
        missed += report.nearby != s.rows;
        free(q);
        loops_free(&s);
    }
    assert_in_range(missed, 0, seeds / 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(reports), cmocka_unit_test(starts),
                                       cmocka_unit_test(flat_mechanisms)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
