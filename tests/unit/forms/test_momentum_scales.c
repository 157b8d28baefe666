/* The masses by which momenta are tested, beside ranks and the mass matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "rigid_tree.h"
#include "units.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

static void run_to_backward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u)
{
    assert_ok(mbsr_stage_positions(m, d, t, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
}

enum { KINDS = 3 };

static void scales_of(const mbsr_model *m, mbsr_data *d, double *scale)
{
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(m, d, i, &info), mbsr_data_error(d));
        scale[i] = info.scale;
    }
}

/* Scales of levers that are none but for rounding count as zero. */
static void forget_rounding(const mbsr_model *m, double *scale)
{
    double most = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) most = fmax(most, scale[i]);
    for (int i = 0; i < mbsr_model_bodies(m); ++i) scale[i] *= scale[i] > 1e-20 * most;
}

/* The largest of each kind. */
static void find_most(const mbsr_model *m, const double *mass, double *most)
{
    for (int k = 0; k < KINDS; ++k) most[k] = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        int u, n;
        mbsr_coordinate_kind kind[MBSR_MAX_D];
        assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &u, &n), NULL);
        assert_ok(mbsr_body_coordinate_kinds(m, i, NULL, kind), NULL);
        for (int k = 0; k < n; ++k) most[kind[k]] = fmax(most[kind[k]], mass[u + k]);
    }
}

/* Whether a joint is eliminated by itself. */
static bool is_alone(const mbsr_model *m, int body)
{
    int members = 0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i)
        members += mbsr_body_group(m, i) == mbsr_body_group(m, body);
    return members == 1;
}

/* Those of one joint: its scale, or 3 % of the diagonal entry. Of several kinds of rates one has
 * the scale, others less, or those without mass `most`, and so have joints of a group. Returns how
 * many are of the diagonal. */
static int check_joint(int n, const mbsr_coordinate_kind *kind, bool alone, double scale,
                       const double *locked, const double *most, const double *mass)
{
    double found = alone ? 0.0 : scale;
    int raised = 0;
    bool same = alone;
    for (int k = 0; k < n; ++k) {
        same = same && kind[k] == kind[0];
        found = fmax(found, mass[k]);
        raised += locked[k] > scale;
        assert_true(mass[k] >= (1.0 - 1e-12) * locked[k]);
    }
    for (int k = 0; k < n; ++k) {
        const double expected = fmax(scale, locked[k]);
        if (same) assert_close(mass[k], expected, 1e-12 * expected);
        assert_true(mass[k] <= (1.0 + 1e-12) * expected || mass[k] == most[(int)kind[k]]);
    }
    assert_true(found >= (1.0 - 1e-12) * scale);
    return raised;
}

/* Of all joints; without mass no more than the largest of the kind, where there is one. Ranks are
 * there afterwards as before. */
static int check(const mbsr_model *m, mbsr_data *d)
{
    const int nu = mbsr_model_nu(m), bodies = mbsr_model_bodies(m);
    double *mass = calloc((size_t)(2 * nu + 2 * bodies + nu * nu) + 1, sizeof *mass),
           *locked = mass + nu, *scale = locked + nu, *again = scale + bodies,
           *matrix = again + bodies, largest[KINDS] = {0.0}, most[KINDS];
    int raised = 0;
    scales_of(m, d, scale);
    assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
    scales_of(m, d, again);
    assert_ok(mbsr_mass_matrix(m, d, matrix), mbsr_data_error(d));
    for (int k = 0; k < nu; ++k) locked[k] = 0.03 * matrix[k * (nu + 1)];
    forget_rounding(m, scale);
    find_most(m, mass, most);
    for (int turn = 0; turn < 2; ++turn) {
        for (int i = 0; i < bodies; ++i) {
            int u, n;
            mbsr_coordinate_kind kind[MBSR_MAX_D];
            assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &u, &n), NULL);
            assert_ok(mbsr_body_coordinate_kinds(m, i, NULL, kind), NULL);
            assert_true(scale[i] == 0.0 || again[i] == scale[i]);
            if (turn == 0 && scale[i] > 0.0)
                raised +=
                    check_joint(n, kind, is_alone(m, i), scale[i], locked + u, most, mass + u);
            for (int k = u; k < u + n; ++k) {
                double *found = largest + (int)kind[k - u];
                assert_true(mass[k] > 0.0);
                if (scale[i] > 0.0)
                    *found = fmax(*found, mass[k]);
                else if (turn == 1 && *found > 0.0)
                    assert_true(mass[k] <= fmax(*found, locked[k]));
            }
        }
    }
    free(mass);
    return raised;
}

/* A slider of 2 kg carries a wheel of 1 kg, which carries an arm on a hinge, without mass. */
static void masses_of_kinds(const units *s, double *mass)
{
    const double up[3] = {0.0, 0.0, 1.0}, zero[3] = {0.0};
    const double tensor = 0.5 * s->mass * s->length * s->length;
    const mbsr_joint turns = mbsr_joint_revolute(NULL, NULL, up);
    const mbsr_inertia inertias[3] = {
        mbsr_inertia_particle(2.0 * s->mass),
        mbsr_inertia_rigid(s->mass, zero, (const double[6]){tensor, tensor, tensor}),
        mbsr_inertia_zero()};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k == 0 ? mbsr_joint_prismatic(NULL, NULL, up) : turns;
        body.inertia = inertias[k];
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    run_to_backward(m, d, 0.0, zero, zero);
    assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* The arm has the wheel's kg m^2, not the slider's kg. */
static void no_kind_has_the_mass_of_another(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const units *s = systems + k;
        const double turned = s->mass * s->length * s->length;
        double mass[3];
        masses_of_kinds(s, mass);
        assert_close(mass[1] / turned, 0.5, 1e-12);
        assert_close(mass[2] / mass[1], 1.0, 1e-12);
    }
}

/* A free body has its mass along ways, and its largest moment along turns. */
static void free_bodies_turn_by_their_moments(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const units *s = systems + k;
        const double turned = s->mass * s->length * s->length, zero[6] = {0.0},
                     q[7] = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
                     tensor[6] = {0.004 * turned, 0.006 * turned, 0.005 * turned, 0.0, 0.0, 0.0};
        mbsr_body_def body = mbsr_default_body_def();
        mbsr_model *m = NULL;
        mbsr_data *d = NULL;
        double mass[6];
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        body.joint = mbsr_joint_free(NULL, NULL);
        body.inertia = mbsr_inertia_rigid(2.0 * s->mass, zero, tensor);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        run_to_backward(m, d, 0.0, q, zero);
        assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
        for (int l = 0; l < 3; ++l) {
            assert_close(mass[l] / turned, 0.006, 1e-14);
            assert_close(mass[3 + l] / s->mass, 2.0, 1e-12);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* A slide and a hinge without mass on springs and dampers: what these would swing, k T^2 or d T. */
static void nor_do_they_depend_on_units_without_mass(void **state)
{
    (void)state;
    double si[2] = {0.0};
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const units *s = systems + k;
        const double L = s->length, M = s->mass, T = s->time, unit[2] = {M, M * L * L},
                     zero[2] = {0.0}, up[3] = {0.0, 0.0, 1.0}, side[3] = {1.0, 0.0, 0.0};
        const mbsr_frame tip = mbsr_frame_at(0.2 * L, 0.0, 0.0);
        mbsr_model *m = NULL;
        mbsr_data *d = NULL;
        double mass[2];
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int l = 0; l < 2; ++l) {
            mbsr_body_def body = mbsr_default_body_def();
            body.parent = l - 1;
            body.joint = l == 0 ? mbsr_joint_prismatic(NULL, NULL, side)
                                : mbsr_joint_revolute(&tip, NULL, up);
            body.inertia = mbsr_inertia_zero();
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
            const mbsr_force_def spring =
                mbsr_force_joint_spring(l, 0, 300.0 * unit[l] / (T * T), 20.0 * unit[l] / T, 0.0);
            assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
        }
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        run_to_backward(m, d, 0.0, zero, zero);
        assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
        for (int l = 0; l < 2; ++l) {
            if (k == 0) si[l] = mass[l];
            assert_close(mass[l] / unit[l] / si[l], 1.0, 1e-12);
        }
        assert_close(si[1] / si[0], 0.04, 1e-12);
        assert_in_range((int)(1e3 * si[0]), 100, 10000);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

static void light_carriers_are_tested_as_what_they_carry(void **state)
{
    (void)state;
    const double up[3] = {0.0, 0.0, 1.0}, mass[3] = {1e-3, 1e-5, 400.0}, zero[3] = {0.0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double found[3];
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_prismatic(NULL, NULL, up);
        body.inertia = mbsr_inertia_particle(mass[k]);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    run_to_backward(m, d, 0.0, zero, zero);
    assert_ok(mbsr_momentum_scales(m, d, found), mbsr_data_error(d));
    assert_close(found[0], 0.03 * (400.0 + 1e-3 + 1e-5), 1e-12);
    assert_in_range((int)found[1], 12,
                    800); /* by the scale, too, in which twice 400 has cancelled */
    assert_close(found[2], 400.0, 1e-10);
    assert_int_equal(check(m, d), 1);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void random_trees(void **state)
{
    (void)state;
    int raised = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)test_seeds(10, 60); ++seed) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = seed,
                                                     .bodies = 12,
                                                     .massless = 0.1,
                                                     .light = 0.3,
                                                     .points = 0.3,
                                                     .many = 0.5,
                                                     .branching = 0.5,
                                                     .length = 0.5,
                                                     .shuffle = 1,
                                                     .held = 0.1,
                                                     .armature = 0.2});
        run_to_backward(s.model, s.data, s.t, s.q, s.u);
        raised += check(s.model, s.data);
        test_rigid_tree_free(&s);
    }
    assert_true(raised > 0);
}

/* A mass on the axis about which its joint turns, far from its origin: what the turn moves is
 * rounding in a tensor, also where a loop takes part. It counts as none. */
static void a_mass_on_its_axis(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *of = systems + k;
        const double L = of->length, at[3] = {0.0, L, L}, post[3] = {2.0 * L, 0.0, 0.0},
                     q[3] = {0.0, 0.0, -0.7853981633974483}, u[3] = {0.0};
        const mbsr_frame A = {.R = {2e-16, -1, 0, 1, -2e-16, 0, 0, 0, 1},
                              .x = {0, 0.5 * L, -0.5 * L}},
                         B = {.R = {0, 1, 2e-16, 2e-16, 2e-16, -1, -1, 0, -2e-16}, .x = {0, 0, L}};
        const mbsr_axis axes[3] = {{MBSR_AXIS_TRANSLATION, {0, 1, 0}, 0.0, 0},
                                   {MBSR_AXIS_TRANSLATION, {0, 0, 1}, 0.0, 0},
                                   {MBSR_AXIS_ROTATION, {1, 0, 0}, 0.0, 0}};
        mbsr_body_def body = mbsr_default_body_def();
        const mbsr_closure_def rod = mbsr_closure_distance(0, at, MBSR_GROUND, post, 2.0 * L);
        double mass[3];
        mbsr_model *m;
        mbsr_data *d;
        body.joint = mbsr_joint_compound(&A, &B, 3, axes, NULL, NULL);
        body.inertia = mbsr_inertia_point_mass(2.5 * of->mass, at);
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        run_to_backward(m, d, 0.0, q, u);
        assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
        assert_less(0.1, mass[2] / (of->mass * L * L));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mass_on_its_axis),
        cmocka_unit_test(light_carriers_are_tested_as_what_they_carry),
        cmocka_unit_test(no_kind_has_the_mass_of_another),
        cmocka_unit_test(free_bodies_turn_by_their_moments),
        cmocka_unit_test(nor_do_they_depend_on_units_without_mass),
        cmocka_unit_test(random_trees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
