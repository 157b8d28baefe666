/* The (q, u) forms as a DAE residual, and consistent starts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "tree.h"

#include <stdlib.h>

static const mbsr_dae_form forms[2] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS};
static const mbsr_dae_form all[3] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                     MBSR_DAE_INVERSE_DYNAMICS};

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
} scene;

/* A chain of free points with these masses, and force elements. */
static scene chain(int bodies, const double *mass, int forces, const mbsr_force_def *list)
{
    scene s;
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), 0);
    for (int k = 0; k < bodies; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.name = k == 0 ? "bead" : "cart";
        body.parent = k - 1;
        body.joint = mbsr_joint_point_free();
        body.inertia = mbsr_inertia_particle(mass[k]);
        assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    }
    for (int k = 0; k < forces; ++k) {
        assert_ok(mbsr_model_add_force(s.model, list + k, NULL), mbsr_model_error(s.model));
    }
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), 0);
    return s;
}

static void drop(scene s)
{
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

/* ---- size, id, pack -------------------------------------------------------------------------- */

static void size_id_and_order_of_y(void **state)
{
    (void)state;
    const double mass[2] = {1.0, 2.0}, q[4] = {1, 2, 3, 4}, u[4] = {5, 6, 7, 8};
    const scene s = chain(2, mass, 0, NULL);
    for (int f = 0; f < 2; ++f) {
        double id[9], y[9], back_q[5], back_u[5];
        for (int k = 0; k < 9; ++k) id[k] = y[k] = 77.0;
        for (int k = 0; k < 5; ++k) back_q[k] = back_u[k] = 77.0;
        assert_int_equal(mbsr_dae_size(s.model, forms[f]), 8);
        assert_int_equal(mbsr_dae_id(s.model, s.data, forms[f], id), 0);
        for (int k = 0; k < 8; ++k) assert_close(id[k], 1.0, 0.0);
        assert_int_equal(mbsr_dae_pack(s.model, s.data, forms[f], 0.0, q, u, y), 0);
        for (int k = 0; k < 8; ++k) assert_close(y[k], k + 1.0, 0.0);
        assert_int_equal(mbsr_dae_unpack(s.model, s.data, forms[f], 0.0, y, back_q, back_u), 0);
        assert_memory_equal(back_q, q, sizeof q);
        assert_memory_equal(back_u, u, sizeof u);
        assert_true(id[8] == 77.0 && y[8] == 77.0 && back_q[4] == 77.0 && back_u[4] == 77.0);
    }
    drop(s);
}

static void an_unknown_form_is_refused_everywhere(void **state)
{
    (void)state;
    const double mass[1] = {1.0};
    const scene s = chain(1, mass, 0, NULL);
    static const int unknown[] = {-1, 99, 1000};
    double x[4] = {0}, y[4] = {1, 2, 3, 4};
    const mbsr_error *e = mbsr_data_error(s.data);
    for (int k = 0; k < 3; ++k) {
        const mbsr_dae_form form = (mbsr_dae_form)unknown[k];
        assert_int_equal(mbsr_dae_size(s.model, form), -1);
        assert_int_equal(mbsr_dae_id(s.model, s.data, form, x), MBSR_ERR_VALUE);
        assert_refused(mbsr_dae_pack(s.model, s.data, form, 0, x, x, y), e, MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE, "mbsr_dae_pack|form");
        assert_refused(mbsr_dae_unpack(s.model, s.data, form, 0, y, x, x), e, MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE, "mbsr_dae_unpack|form");
        assert_refused(mbsr_dae_residual(s.model, s.data, form, 0, x, x, y), e, MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE, "mbsr_dae_residual|form");
        assert_refused(mbsr_dae_consistent(s.model, s.data, form, 0, x, y, NULL, NULL), e,
                       MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "mbsr_dae_consistent|form");
        for (int l = 0; l < 4; ++l) assert_true(x[l] == 0.0 && y[l] == l + 1.0);
    }
    assert_int_equal(mbsr_dae_id(s.model, s.data, forms[0], NULL), MBSR_ERR_NULL);
    drop(s);
}

/* ---- the residual ---------------------------------------------------------------------------- */

static void the_residual_is_that_of_the_equations(void **state)
{
    (void)state;
    /* two points in a row, a spring on the first and gravity:
     * (m1 + m2) a1 + m2 a2 = -c q1 + (m1 + m2) g,   m2 (a1 + a2) = m2 g */
    const double mass[2] = {1.5, 2.0};
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 10.0, 0.5, 0.1),
                                   mbsr_force_gravity(0, -9, 0.0)};
    const scene s = chain(2, mass, 2, list);
    const double y[8] = {1, 2, 3, 4, 5, 6, 7, 8}, yp[8] = {5.5, 6, 7, 7.5, 0.1, 0.2, 0.3, 0.4};
    double F[8];
    for (int f = 0; f < 2; ++f) {
        assert_ok(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F),
                  mbsr_data_error(s.data));
        assert_close(F[0], 0.5, 0.0);
        assert_close(F[1], 0.0, 0.0);
        assert_close(F[2], 0.0, 0.0);
        assert_close(F[3], -0.5, 0.0);
    }
    /* inverse dynamics: what is missing in the equations above */
    assert_close(F[4], 3.5 * 0.1 + 2.0 * 0.3 + 10.0 * 0.9 + 0.5 * 5.0, 1e-13);
    assert_close(F[5], 3.5 * 0.2 + 2.0 * 0.4 + 3.5 * 9.0, 1e-13);
    assert_close(F[6], 2.0 * 0.4, 1e-13);
    assert_close(F[7], 2.0 * 0.6 + 2.0 * 9.0, 1e-13);
    drop(s);
}

static void both_forms_vanish_together(void **state)
{
    (void)state;
    static const double masses[3][2] = {{1.5, 2.0}, {1.5, 0.0}, {0.0, 2.0}};
    const mbsr_force_def list[] = {
        mbsr_force_axis_spring(0, MBSR_GROUND, 0, 10.0, 0.5, 0.1),
        mbsr_force_axis_spring(0, MBSR_GROUND, 1, 20.0, 1.5, 0.1), mbsr_force_gravity(0, -9, 0.0),
        mbsr_force_joint_spring(1, 0, 5.0, 1.0, 0.2), mbsr_force_joint_spring(1, 1, 5.0, 2.0, 0.2)};
    for (int k = 0; k < 3; ++k) {
        const scene s = chain(2, masses[k], 5, list);
        double y[8], yp[8], F[8];
        for (int l = 0; l < 8; ++l) y[l] = 0.1 * (l + 1);
        assert_ok(mbsr_dae_consistent(s.model, s.data, forms[0], 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(s.data));
        for (int f = 0; f < 2; ++f) {
            assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F), 0);
            assert_close(test_largest(8, F), 0.0, 1e-11);
            /* all of u' wrong; then only what moves no mass */
            for (int c = 4; c < 8; ++c) yp[c] += 0.5;
            assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F), 0);
            assert_true(test_largest(8, F) > 0.1);
            for (int c = 4; c < 8; ++c) yp[c] -= 0.5;
            if (k > 0) yp[6] += 0.75;
            if (k == 2) yp[4] -= 0.75;
            assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F), 0);
            assert_close(test_largest(8, F), 0.0, 1e-11);
            if (k > 0) yp[6] -= 0.75;
            if (k == 2) yp[4] += 0.75;
        }
        drop(s);
    }
}

static void values_that_are_not_finite_are_refused(void **state)
{
    (void)state;
    const double mass[1] = {1.0};
    const scene s = chain(1, mass, 0, NULL);
    double y[4] = {1, 2, 3, 4}, yp[4] = {3, 4, 5, 6}, F[4];
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int f = 0; f < 2; ++f) {
        for (int k = 0; k < 12; ++k) {
            double *const x = (k % 2 ? y : yp) + k % 4, held = *x;
            *x = bad[k / 4];
            const int status = mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F);
            assert_refused(status, mbsr_data_error(s.data), MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                           "is not finite");
            assert_contains(mbsr_data_error(s.data)->text, x == yp + k % 4 ? "yp"
                                                           : k % 4 < 2     ? "q"
                                                                           : "u");
            *x = held;
        }
        assert_refused(mbsr_dae_residual(s.model, s.data, forms[f], NAN, y, yp, F),
                       mbsr_data_error(s.data), MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                       "t or q is not finite");
        assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F), 0);
    }
    drop(s);
}

static void an_overflow_is_not_finite(void **state)
{
    (void)state;
    const double mass[1] = {1e10}, y[4] = {1, 2, 3, 4}, yp[4] = {3, 4, 1e305, 6};
    const scene s = chain(1, mass, 0, NULL);
    double F[4];
    for (int f = 0; f < 2; ++f) {
        assert_refused(mbsr_dae_residual(s.model, s.data, forms[f], 0.0, y, yp, F),
                       mbsr_data_error(s.data), MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "overflow");
    }
    drop(s);
}

/* ---- consistent starts ----------------------------------------------------------------------- */

/* A force that grows: 2 + 3 t along x, 1 - t along y. */
static int pull(void *user, double t, int n, double *value)
{
    (void)user;
    assert_int_equal(n, 2);
    value[0] = 2.0 + 3.0 * t;
    value[1] = 1.0 - t;
    return 0;
}

static void a_massless_point_takes_the_speed_its_damper_allows(void **state)
{
    (void)state;
    /* 0 = F(t) - c q - d u:  u = (F - c q) / d,  u' = (F' - c u) / d */
    const double mass[1] = {0.0}, c[2] = {40.0, 25.0}, d[2] = {8.0, 0.5}, t = 0.5,
                 q[2] = {0.3, -0.2};
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, c[0], d[0], 0.0),
                                   mbsr_force_axis_spring(0, MBSR_GROUND, 1, c[1], d[1], 0.0),
                                   mbsr_force_applied(0, pull, NULL)};
    const scene s = chain(1, mass, 3, list);
    const double F[2] = {3.5, 0.5}, Fdot[2] = {3.0, -1.0};
    for (int f = 0; f < 2; ++f) {
        double y[4] = {0.3, -0.2, 5.0, -7.0}, yp[4] = {9, 9, 9, 9}, residual[4];
        mbsr_consistent_info info;
        assert_ok(mbsr_dae_consistent(s.model, s.data, forms[f], t, y, yp, NULL, &info),
                  mbsr_data_error(s.data));
        double change = 0.0, defect = 0.0;
        for (int k = 0; k < 2; ++k) {
            const double u = (F[k] - c[k] * q[k]) / d[k], start = k ? -7.0 : 5.0;
            assert_close(y[k], q[k], 0.0);
            assert_close(y[2 + k], u, 1e-12 * fabs(u) + 1e-13);
            assert_close(yp[k], u, 1e-12 * fabs(u) + 1e-13);
            assert_close(yp[2 + k], (Fdot[k] - c[k] * u) / d[k],
                         1e-7 * (1.0 + fabs(c[k] * u / d[k])));
            change = fmax(change, fabs(u - start));
            defect = fmax(defect, fabs(F[k] - c[k] * q[k] - d[k] * start));
        }
        assert_int_equal(info.null_directions, 2);
        assert_in_range(info.iterations, 1, 3);
        assert_close(info.velocity_change, change, 1e-9);
        assert_close(info.force_defect, defect, 1e-9);
        assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[f], t, y, yp, residual), 0);
        assert_close(test_largest(4, residual), 0.0, 1e-9);
    }
    drop(s);
}

/* A massless point with a heavy one on it: only the speed of the light one may change, the other's
 * momentum stays. */
static void momenta_stay_as_they_were(void **state)
{
    (void)state;
    const double mass[2] = {0.0, 2.0}, q[4] = {0.3, 0.1, 1.0, 0.2};
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 40.0, 8.0, 0.0),
                                   mbsr_force_axis_spring(0, MBSR_GROUND, 1, 25.0, 5.0, 0.0),
                                   mbsr_force_joint_spring(1, 0, 10.0, 2.0, 0.5),
                                   mbsr_force_joint_spring(1, 1, 15.0, 3.0, 0.0)};
    const scene s = chain(2, mass, 4, list);
    double y[8] = {0.3, 0.1, 1.0, 0.2, 1.0, -2.0, 3.0, 0.5}, yp[8], F[8];
    assert_ok(mbsr_dae_consistent(s.model, s.data, forms[0], 0.0, y, yp, NULL, NULL),
              mbsr_data_error(s.data));
    const double c[2] = {40.0, 25.0}, d[2] = {8.0, 5.0}, ci[2] = {10.0, 15.0}, di[2] = {2.0, 3.0},
                 rest[2] = {0.5, 0.0};
    const double V[2] = {4.0, -1.5}; /* of the heavy point, before and after */
    for (int k = 0; k < 2; ++k) {
        /* 0 = -c q - d u + ci (r - rest) + di (V - u) */
        const double u =
            (-c[k] * q[k] + ci[k] * (q[2 + k] - rest[k]) + di[k] * V[k]) / (d[k] + di[k]);
        assert_close(y[4 + k], u, 1e-12);
        assert_close(y[4 + k] + y[6 + k], V[k], 1e-12);
        const double A = -(ci[k] * (q[2 + k] - rest[k]) + di[k] * (V[k] - u)) / 2.0;
        assert_close(yp[4 + k] + yp[6 + k], A, 1e-7);
        const double udot = (-c[k] * u + ci[k] * (V[k] - u) + di[k] * A) / (d[k] + di[k]);
        assert_close(yp[4 + k], udot, 1e-6);
    }
    assert_int_equal(mbsr_dae_residual(s.model, s.data, forms[1], 0.0, y, yp, F), 0);
    assert_close(test_largest(8, F), 0.0, 1e-9);
    drop(s);
}

static void an_undetermined_direction_is_refused_and_named(void **state)
{
    (void)state;
    const double mass[1] = {0.0};
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 40.0, 8.0, 0.0),
                                   mbsr_force_axis_spring(0, MBSR_GROUND, 1, 0.0, 0.0, 0.0)};
    /* no force at all; damped along x only; an element along y that does nothing */
    for (int forces = 0; forces <= 2; ++forces) {
        const scene s = chain(1, mass, forces, list);
        for (int f = 0; f < 3; ++f) {
            double y[6] = {0.3, 0.1, 1.0, -2.0, 3.0, -4.0}, yp[6] = {5, 6, 7, 8, 9, 10};
            assert_refused(mbsr_dae_consistent(s.model, s.data, all[f], 0.0, y, yp, NULL, NULL),
                           mbsr_data_error(s.data), MBSR_UNDETERMINED, 0, MBSR_NONE,
                           "body 0 'bead'|neither a damper nor a spring");
            assert_true(y[0] == 0.3 && y[1] == 0.1 && y[2] == 1.0 && y[3] == -2.0);
            assert_true(y[4] == 3.0 && y[5] == -4.0);
            for (int k = 0; k < 6; ++k) assert_close(yp[k], 5.0 + k, 0.0);
        }
        drop(s);
    }
}

/* A massless point damped along x and on a spring alone along y, from a position that is off
 * balance:
 *   0 = fx(t) - c q - d u,   0 = fy(t) - c q  with  fx = 2 + 3 t, fy = 1 - t
 * so that along y  q = fy / c, u = fy' / c, u' = fy'' / c = 0. */
static void an_elastic_direction_takes_the_position_of_balance(void **state)
{
    (void)state;
    const double mass[1] = {0.0}, t = 0.5;
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 40.0, 8.0, 0.0),
                                   mbsr_force_axis_spring(0, MBSR_GROUND, 1, 25.0, 0.0, 0.0),
                                   mbsr_force_applied(0, pull, NULL)};
    const scene s = chain(1, mass, 3, list);
    const double q[2] = {0.3, 0.5 / 25.0}, u[2] = {(3.5 - 40.0 * 0.3) / 8.0, -1.0 / 25.0};
    const double udot[2] = {(3.0 - 40.0 * u[0]) / 8.0, 0.0}, given_q[2] = {0.3, 0.1},
                 given_u[2] = {1.0, -2.0};
    for (int f = 0; f < 3; ++f) {
        double y[6], yp[6], got_q[2], got_u[2], F[6];
        mbsr_consistent_info info;
        assert_ok(mbsr_dae_pack(s.model, s.data, all[f], t, given_q, given_u, y), NULL);
        assert_ok(mbsr_dae_consistent(s.model, s.data, all[f], t, y, yp, NULL, &info),
                  mbsr_data_error(s.data));
        assert_int_equal(info.null_directions, 2);
        assert_int_equal(info.elastic, 1);
        assert_close(info.position_change, 0.1 - q[1], 1e-10);
        assert_close(info.velocity_change, 1.0 - u[0], 1e-8);
        assert_close(info.force_defect, 40.0 * 0.3 + 8.0 - 3.5, 1e-9);
        assert_int_equal(mbsr_dae_unpack(s.model, s.data, all[f], t, y, got_q, got_u), MBSR_OK);
        const double *rate = yp + mbsr_dae_size(s.model, all[f]) - 2;
        for (int k = 0; k < 2; ++k) {
            assert_close(got_q[k], q[k], 1e-12);
            assert_close(got_u[k], u[k], 1e-8);
            assert_close(yp[k], u[k], 1e-8);
            assert_close(rate[k], udot[k], 1e-5);
        }
        assert_int_equal(mbsr_dae_residual(s.model, s.data, all[f], t, y, yp, F), MBSR_OK);
        assert_close(test_largest(mbsr_dae_size(s.model, all[f]), F), 0.0, 1e-8);
    }
    drop(s);
}

static void a_regular_model_starts_with_its_accelerations(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        test_tree tree;
        test_tree_make(&tree, (test_tree_opt){.seed = seed,
                                              .bodies = 8,
                                              .max_d = 4,
                                              .bend = 0.3,
                                              .forces = 1,
                                              .moving_root = 1,
                                              .shuffle = 1});
        const int n = mbsr_dae_size(tree.model, forms[0]), nq = mbsr_model_nq(tree.model);
        double *y = calloc((size_t)n, sizeof *y), *before = calloc((size_t)n, sizeof *y);
        double *yp = calloc((size_t)n, sizeof *y), *udot = calloc((size_t)n, sizeof *y);
        test_rng rng = test_seed(seed);
        mbsr_consistent_info info;
        test_fill(&rng, n, y);
        memcpy(before, y, (size_t)n * sizeof *y);
        assert_ok(
            mbsr_dae_consistent(tree.model, tree.data, forms[seed % 2], 0.3, y, yp, NULL, &info),
            mbsr_data_error(tree.data));
        assert_int_equal(info.null_directions, 0);
        assert_close(info.velocity_change, 0.0, 0.0);
        assert_int_equal(mbsr_data_error(tree.data)->status, MBSR_OK);
        assert_int_equal(mbsr_forward_dynamics(tree.model, tree.data, 0.3, y, y + nq, NULL, udot),
                         0);
        assert_memory_equal(y, before, (size_t)n * sizeof *y);
        assert_memory_equal(yp, y + nq, (size_t)nq * sizeof *y);
        assert_memory_equal(yp + nq, udot, (size_t)(n - nq) * sizeof *y);
        free(y);
        free(before);
        free(yp);
        free(udot);
        test_tree_free(&tree);
    }
}

static void a_start_that_succeeds_records_no_failure(void **state)
{
    (void)state;
    const double mass[1] = {0.0};
    const mbsr_force_def list[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 40.0, 8.0, 0.0),
                                   mbsr_force_axis_spring(0, MBSR_GROUND, 1, 25.0, 1.0, 0.0)};
    const scene s = chain(1, mass, 2, list);
    double y[4] = {0.3, 0.1, 1.0, -2.0}, yp[4];
    assert_int_equal(mbsr_dae_consistent(s.model, s.data, forms[0], 0.0, y, yp, NULL, NULL), 0);
    assert_int_equal(mbsr_data_error(s.data)->status, MBSR_OK);
    assert_string_equal(mbsr_data_error(s.data)->text, "");
    drop(s);
}

static void options_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    const double mass[1] = {1.0};
    const scene s = chain(1, mass, 0, NULL);
    double y[4] = {1, 2, 3, 4}, yp[4] = {5, 6, 7, 8};
    const mbsr_error *e = mbsr_data_error(s.data);
    mbsr_consistent_opt opt;
    memset(&opt, 0, sizeof opt);
    opt.max_iterations = 20;
    opt.tolerance = 1e-12;
    assert_refused(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, NULL), e,
                   MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "mbsr_default_consistent_opt");
    static const struct {
        int iterations;
        double tolerance;
        const char *words;
    } wrong[] = {
        {0, 1e-12, "max_iterations is 0"}, {-3, 1e-12, "max_iterations is -3"},
        {20, 0.0, "tolerance is 0"},       {20, -1e-12, "tolerance is -1e-12"},
        {20, NAN, "tolerance is"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        opt = mbsr_default_consistent_opt();
        opt.max_iterations = wrong[k].iterations;
        opt.tolerance = wrong[k].tolerance;
        assert_refused(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, NULL), e,
                       MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, wrong[k].words);
    }
    for (int k = 0; k < 4; ++k) assert_true(y[k] == k + 1.0 && yp[k] == k + 5.0);
    opt = mbsr_default_consistent_opt();
    assert_int_equal(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, NULL), 0);
    y[2] = NAN;
    assert_int_equal(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, NULL),
                     MBSR_NOT_FINITE);
    drop(s);
}

/* A damper with force -|u|^3 - u: Newton needs several steps, and one step is too few. */
static int cubic(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < 2; ++k) b->tau[k] += 10.0 - b->u[k] - b->u[k] * b->u[k] * b->u[k];
    return 0;
}

static void a_nonlinear_damper_needs_its_iterations(void **state)
{
    (void)state;
    const mbsr_force_table table = {
        .version = MBSR_FORCE_TABLE_VERSION, .name = "cubic", .evaluate = cubic};
    const double mass[1] = {0.0};
    const mbsr_force_def force = mbsr_force_custom(&table, 1, (const int[]){0}, NULL);
    const scene s = chain(1, mass, 1, &force);
    double y[4] = {0, 0, 0, 30}, yp[4] = {5, 6, 7, 8};
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    mbsr_consistent_info info;
    opt.max_iterations = 2;
    assert_refused(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, &info),
                   mbsr_data_error(s.data), MBSR_NO_CONVERGENCE, 0, MBSR_NONE,
                   "mbsr_dae_consistent|no velocity balances the forces");
    assert_true(y[2] == 0.0 && y[3] == 30.0 && yp[0] == 5.0);
    assert_true(info.iterations >= 2); /* of each attempt */
    opt.max_iterations = 30;
    assert_ok(mbsr_dae_consistent(s.model, s.data, forms[0], 0, y, yp, &opt, &info),
              mbsr_data_error(s.data));
    assert_in_range(info.iterations, 4, 30);
    assert_close(y[2], 2.0, 1e-11); /* 2 + 8 = 10 */
    assert_close(y[3], 2.0, 1e-11);
    assert_close(yp[2], 0.0, 1e-6);
    drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(size_id_and_order_of_y),
        cmocka_unit_test(an_unknown_form_is_refused_everywhere),
        cmocka_unit_test(the_residual_is_that_of_the_equations),
        cmocka_unit_test(both_forms_vanish_together),
        cmocka_unit_test(values_that_are_not_finite_are_refused),
        cmocka_unit_test(an_overflow_is_not_finite),
        cmocka_unit_test(a_massless_point_takes_the_speed_its_damper_allows),
        cmocka_unit_test(momenta_stay_as_they_were),
        cmocka_unit_test(an_undetermined_direction_is_refused_and_named),
        cmocka_unit_test(an_elastic_direction_takes_the_position_of_balance),
        cmocka_unit_test(a_regular_model_starts_with_its_accelerations),
        cmocka_unit_test(a_start_that_succeeds_records_no_failure),
        cmocka_unit_test(options_that_make_no_sense_are_refused),
        cmocka_unit_test(a_nonlinear_damper_needs_its_iterations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
