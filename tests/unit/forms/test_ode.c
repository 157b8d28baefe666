/* The reduced ODE against the momentum form, and its groups of coupled massless directions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"
#include "duration.h"
#include "expect.h"
#include "tree.h"

#include "assembly/data.h"

#include <math.h>
#include <string.h>

#define TREES test_seeds(60, 200)
enum { MOST = 160 };

static const double time_now = 0.3;

/* x' of the ODE is that of the momentum form at its consistent start, whatever Newton starts
 * from. */
static void rhs_is_that_of_the_momentum_form(void **unused)
{
    (void)unused;
    int massless = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        const test_tree_opt opt = {.seed = (uint64_t)seed,
                                   .bodies = 2 + seed % 9,
                                   .max_d = 5,
                                   .welds = 1,
                                   .deficient = 0.6,
                                   .bend = 0.1,
                                   .forces = 1,
                                   .moving_root = seed % 3 == 0,
                                   .shuffle = seed % 2};
        test_tree tree;
        test_tree_make(&tree, opt);
        const mbsr_model *m = tree.model;
        mbsr_data *d = tree.data;
        const int n = tree.nu;
        double q[MOST], u[MOST], y[3 * MOST], yp[3 * MOST], x[2 * MOST], xdot[2 * MOST];
        test_rng rng = test_seed((uint64_t)seed + 7000);
        test_fill(&rng, n, q);
        test_fill(&rng, n, u);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, time_now, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, time_now, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        double kept = 1.0, F[3 * MOST];
        assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, time_now, y, yp, F),
                  mbsr_data_error(d));
        for (int i = 0; i < tree.N; ++i) {
            mbsr_rank_info info;
            assert_int_equal(mbsr_body_rank(m, d, i, &info), MBSR_OK);
            if (info.rank > 0) kept = fmin(kept, info.smallest_kept);
            massless += info.rank < info.n;
        }
        mbsr_ode *ode;
        assert_ok(mbsr_ode_create(m, d, time_now, q, u, &ode), mbsr_data_error(d));
        assert_int_equal(mbsr_ode_size(ode), 2 * n);
        memcpy(x, y, sizeof(double) * (size_t)(2 * n));
        mbsri_data_poison(d);
        double found[MOST];
        test_fill(&rng, n, found); /* any start */
        assert_ok(mbsr_ode_velocities(ode, time_now, x, found), mbsr_data_error(d));
        const double size = 1.0 + test_largest(n, y + 2 * n);
        for (int k = 0; k < n; ++k) assert_close(found[k], y[2 * n + k], 1e-10 * size / kept);
        assert_ok(mbsr_ode_rhs(ode, time_now, x, xdot), mbsr_data_error(d));
        const double rate = 1.0 + test_largest(2 * n, yp);
        for (int k = 0; k < 2 * n; ++k) assert_close(xdot[k], yp[k], 1e-9 * rate / kept);
        found[0] = NAN; /* a start that fails is not the next one */
        (void)mbsr_ode_velocities(ode, time_now, x, found);
        assert_ok(mbsr_ode_rhs(ode, time_now, x, xdot), mbsr_data_error(d));
        for (int k = 0; k < 2 * n; ++k) assert_close(xdot[k], yp[k], 1e-9 * rate / kept);
        mbsr_ode_destroy(ode);
        test_tree_free(&tree);
    }
    assert_true(massless > TREES);
}

/* A row of points on the ground, each alone (absolute) or on the one before (chain). */
static mbsr_model *points(int count, bool chain, double damping)
{
    mbsr_model *m;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < count; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = chain ? k - 1 : MBSR_GROUND;
        body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        const mbsr_force_def spring =
            mbsr_force_axis_spring(k, chain ? k - 1 : MBSR_GROUND, 0, 2.0, damping, 0.0);
        assert_int_equal(mbsr_model_add_force(m, &spring, NULL), MBSR_OK);
    }
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    return m;
}

/* Each evaluation of the forces serves all isolated bodies: their number does not count. */
static void isolated_bodies_share_their_differences(void **unused)
{
    (void)unused;
    long evaluations[2], steps[2];
    const int count[2] = {5, 60};
    for (int c = 0; c < 2; ++c) {
        mbsr_model *m = points(count[c], false, 0.5);
        mbsr_data *d;
        mbsr_ode *ode;
        double q[60], u[60] = {0.0}, x[120], xdot[120];
        for (int k = 0; k < count[c]; ++k) q[k] = 1.0 + k;
        assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
        assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
        assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
        assert_ok(mbsr_ode_rhs(ode, 0.0, x, xdot), mbsr_data_error(d));
        /* 0 = -2 q - 0.5 q' */
        for (int k = 0; k < count[c]; ++k) assert_close(xdot[k], -4.0 * q[k], 1e-9 * q[k]);
        assert_int_equal(mbsr_ode_stats(ode, &steps[c], &evaluations[c]), MBSR_OK);
        mbsr_ode_destroy(ode);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_int_equal(evaluations[0], 2 * steps[0]); /* one for gamma, one for its slopes */
    assert_int_equal(evaluations[0], evaluations[1]);
}

static void a_chain_is_one_group(void **unused)
{
    (void)unused;
    mbsr_model *m = points(5, true, 0.5);
    mbsr_data *d;
    mbsr_ode *ode;
    const double q[5] = {1.0, 2.0, 3.0, 4.0, 5.0}, u[5] = {0.0};
    double x[10], xdot[10];
    long steps, evaluations;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
    assert_ok(mbsr_ode_rhs(ode, 0.0, x, xdot), mbsr_data_error(d));
    for (int k = 0; k < 5; ++k) assert_close(xdot[k], -4.0 * q[k], 1e-9 * q[k]);
    assert_int_equal(mbsr_ode_stats(ode, &steps, &evaluations), MBSR_OK);
    assert_int_equal(evaluations, 6 * steps); /* gamma and five slopes */
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A mass between two massless points of a chain keeps them apart: each damped against the ground.
 */
static void a_mass_ends_a_group(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ode *ode;
    const double q[3] = {1.0, 2.0, 3.0}, u[3] = {0.0};
    double x[6], xdot[6];
    long steps, evaluations;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 3; ++k) {
        const mbsr_force_def damper = mbsr_force_axis_spring(k, MBSR_GROUND, 0, 2.0, 0.5, 0.0);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        if (k == 1) body.inertia = mbsr_inertia_particle(1.0);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        assert_int_equal(mbsr_model_add_force(m, &damper, NULL), MBSR_OK);
    }
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
    assert_ok(mbsr_ode_rhs(ode, 0.0, x, xdot), mbsr_data_error(d));
    /* 0 = -2 s - 0.5 s' of what has no mass, at 1 and 6 */
    assert_close(xdot[0], -4.0, 1e-9);
    assert_close(xdot[1] + xdot[0], 0.0, 1e-9);
    assert_close(xdot[2], -24.0, 1e-8);
    assert_int_equal(mbsr_ode_stats(ode, &steps, &evaluations), MBSR_OK);
    assert_int_equal(evaluations, 2 * steps); /* one for gamma, one for the slopes of both groups */
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void an_undamped_direction_is_refused_and_named(void **unused)
{
    (void)unused;
    mbsr_model *m = points(2, false, 0.0);
    mbsr_data *d;
    mbsr_ode *ode;
    const double q[2] = {1.0, 2.0}, u[2] = {0.0};
    double x[4], xdot[4];
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
    assert_refused(mbsr_ode_rhs(ode, 0.0, x, xdot), mbsr_data_error(d), MBSR_UNDETERMINED, 0,
                   MBSR_NONE, "body 0");
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A damper between two points holds neither of them. */
static void directions_that_are_damped_together_alone_are_refused(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ode *ode;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        const mbsr_force_def damper =
            mbsr_force_axis_spring(k, k > 0 ? k - 1 : 2, 0, 2.0, 0.3 + k, 0.0);
        assert_int_equal(mbsr_model_add_force(m, &damper, NULL), MBSR_OK);
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    test_rng rng = test_seed(53);
    for (int state = 0; state < 1000; ++state) {
        double q[3], u[3], x[6], xdot[6];
        test_fill(&rng, 3, q);
        test_fill(&rng, 3, u);
        assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
        assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
        assert_int_equal(mbsr_ode_rhs(ode, 0.0, x, xdot), MBSR_UNDETERMINED);
        mbsr_ode_destroy(ode);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void null_is_refused(void **unused)
{
    (void)unused;
    double x[1] = {0.0};
    assert_int_equal(mbsr_ode_rhs(NULL, 0.0, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ode_velocities(NULL, 0.0, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ode_pack(NULL, 0.0, x, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ode_stats(NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ode_size(NULL), -1);
    mbsr_ode_destroy(NULL);
}

/* A slide without mass, pulled by 0.6 of the largest force of its friction beside a pendulum: it
 * moves at 0.75 of the speed of slip, in m and s, mm and ms, and where that speed is next to
 * nothing in the units. */
static void a_speed_in_any_units(void **unused)
{
    (void)unused;
    static const double length[] = {1.0, 1e3, 1.0 / 1048576.0}, time[] = {1.0, 1e3, 1048576.0};
    for (int k = 0; k < 3; ++k) {
        const double L = length[k], T = time[k], N = L / (T * T), slip = 1e-3 * L / T,
                     com[2] = {L, 0.0}, none[2] = {0.0, 0.0}, u[2] = {0.0, 0.0},
                     q[2] = {0.0, 0.6 * L};
        const mbsr_planar_frame here = {0.0, 0.0, 0.0}, aside = {L, 0.0, 0.0};
        const mbsr_force_def force[] = {mbsr_force_gravity(0.0, -9.81 * N, 0.0),
                                        mbsr_force_joint_friction(1, 0, N, slip),
                                        mbsr_force_joint_spring(1, 0, N / L, 0.0, 0.0)};
        mbsr_body_def body = mbsr_default_body_def();
        mbsr_model *m;
        mbsr_data *d;
        mbsr_ode *ode;
        double x[4], found[2] = {0.0, 0.0};
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        body.joint = mbsr_joint_planar_revolute(aside, here);
        body.inertia = mbsr_inertia_planar(1.0, com, 0.1 * L * L);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        body.joint = mbsr_joint_planar_prismatic(here, here);
        body.inertia = mbsr_inertia_planar(0.0, none, 0.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        for (int l = 0; l < 3; ++l)
            assert_ok(mbsr_model_add_force(m, force + l, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
        assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
        assert_ok(mbsr_ode_velocities(ode, 0.0, x, found), mbsr_data_error(d));
        assert_close(found[1] / slip, -0.75, 1e-8);
        mbsr_ode_destroy(ode);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* Bodies that turn about the line that their masses are on, but for rounding. */
static void levers_that_are_rounding_damp_nothing(void **unused)
{
    (void)unused;
    static const struct {
        uint64_t seed;
        int body;
    } turning[] = {{1400, 6}, {2110, 0}, {11878, 0}};
    static const units si = {"m, kg, s", 1.0, 1.0, 1.0};
    for (size_t k = 0; k < sizeof turning / sizeof turning[0]; ++k) {
        double u[ANY_MOST], x[2 * ANY_MOST];
        any_model s;
        mbsr_data *d;
        mbsr_ode *ode;
        assert_true(any_model_make(&s, turning[k].seed, &si, false));
        assert_int_equal(mbsr_data_create(s.m, &d, NULL), MBSR_OK);
        for (int l = 0; l < s.nu; ++l) u[l] = sin(4.0 + l);
        assert_ok(mbsr_ode_create(s.m, d, 0.0, s.q, u, &ode), mbsr_data_error(d));
        assert_ok(mbsr_ode_pack(ode, 0.0, s.q, u, x), mbsr_data_error(d));
        assert_refused(mbsr_ode_velocities(ode, 0.0, x, u), mbsr_data_error(d), MBSR_UNDETERMINED,
                       turning[k].body, MBSR_NONE, "no damping determines");
        mbsr_ode_destroy(ode);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rhs_is_that_of_the_momentum_form),
        cmocka_unit_test(isolated_bodies_share_their_differences),
        cmocka_unit_test(a_chain_is_one_group),
        cmocka_unit_test(a_mass_ends_a_group),
        cmocka_unit_test(an_undamped_direction_is_refused_and_named),
        cmocka_unit_test(directions_that_are_damped_together_alone_are_refused),
        cmocka_unit_test(levers_that_are_rounding_damp_nothing),
        cmocka_unit_test(a_speed_in_any_units),
        cmocka_unit_test(null_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
