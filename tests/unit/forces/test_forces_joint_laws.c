/* Springs on joints: the cubic law, and the law of rotation vectors on quaternions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"
#include "space.h"

#include <mbsrank/verify.h>

/* ---- one coordinate ---- */

static void the_cubic_law(void **state)
{
    (void)state;
    mbsr_force_def def = mbsr_force_joint_cubic_spring(4, 1, 3.0, 7.0, 0.5, 0.2);
    test_part part = test_part_make(MBSR_SPACE_PLANAR);
    part.q[1] = 0.6;
    part.u[1] = -2.0;
    assert_int_equal(test_ask(&def, &part, 1, TEST_FORCES, NULL), 0);
    assert_close(part.tau[1], -(3.0 * 0.4 + 7.0 * 0.064 - 1.0), 1e-14);
    assert_true(part.tau[0] == 0.0 && part.tau[2] == 0.0);
    assert_close(test_value(&def, &part, 1, TEST_ENERGY), 0.5 * 3.0 * 0.16 + 0.25 * 7.0 * 0.0256,
                 1e-14);
    assert_close(test_value(&def, &part, 1, TEST_DISSIPATION), 0.5 * 4.0, 1e-14);
    test_rng rng = test_seed(3);
    for (int l = 0; l < 50; ++l) {
        def = mbsr_force_joint_cubic_spring(0, l % 3, 1.0 + test_uniform(&rng), 2.0, 0.3, 0.4);
        part = test_part_random(MBSR_SPACE_SPATIAL, &rng);
        test_balance(&def, &part, 1);
    }
    /* without the cubic term it is the linear one */
    const mbsr_force_def linear = mbsr_force_joint_spring(4, 1, 3.0, 0.5, 0.2),
                         none = mbsr_force_joint_cubic_spring(4, 1, 3.0, 0.0, 0.5, 0.2);
    assert_ptr_equal(linear.table, none.table);
    assert_memory_equal(linear.param, none.param, sizeof none.param);
}

/* ---- quaternions ---- */

enum { N = 3, NQ = 4 };
static const double stiffness[3] = {2.0, 3.0, 5.0}, damping[3] = {0.3, 0.2, 0.4};

/* Joint forces, energy and dissipation of the element on a spherical joint. */
static int ask(const mbsr_force_def *def, const double *q, const double *u, double tau[3],
               double *energy, double *power)
{
    mbsr_force_body body = {.id = 0, .n = N, .nq = NQ, .q = q, .u = u, .tau = tau};
    const mbsr_force_args args = {.force = def, .bodies = 1, .body = &body};
    for (int k = 0; k < 3; ++k) tau[k] = 0.0;
    int status = def->table->evaluate(&args);
    if (!status && energy) *energy = 0.0, status = def->table->energy(&args, energy);
    if (!status && power) *power = 0.0, status = def->table->dissipation(&args, power);
    return status;
}

/* q of a rotation by `angle` about `axis`, of length `length`. */
static void turned(const double axis[3], double angle, double length, double q[4])
{
    const mbsr_frame frame = mbsr_frame_rotated(NULL, axis, angle);
    mbsr_rotation_quaternion(frame.R, q);
    for (int k = 0; k < 4; ++k) q[k] *= length;
}

static void a_turn_about_one_axis_is_a_torsion_spring(void **state)
{
    (void)state;
    const double axis[3] = {0.48, 0.6, 0.64}, same[3] = {4.0, 4.0, 4.0}, still[3] = {0.0};
    const double lengths[] = {1.0, -1.0, 7.0, 1e-160, 1e160};
    for (int l = 0; l < 5; ++l) {
        for (int a = -31; a <= 31; a += 2) {
            double q[4], tau[3], E;
            mbsr_force_def def = mbsr_force_joint_rotation_spring(0, same, damping, NULL);
            turned(axis, 0.1 * a, lengths[l], q);
            assert_int_equal(ask(&def, q, still, tau, &E, NULL), 0);
            for (int k = 0; k < 3; ++k) assert_close(tau[k], -0.4 * a * axis[k], 1e-13 * 4.0);
            assert_close(E, 2.0 * 0.01 * a * a, 1e-12);
            /* different stiffnesses, about one of their axes */
            def = mbsr_force_joint_rotation_spring(0, stiffness, NULL, NULL);
            turned((const double[3]){0, 1, 0}, 0.1 * a, lengths[l], q);
            assert_int_equal(ask(&def, q, still, tau, &E, NULL), 0);
            assert_close(tau[1], -0.3 * a, 1e-13 * 4.0);
            /* at rest */
            def = mbsr_force_joint_rotation_spring(0, stiffness, damping, q);
            assert_int_equal(ask(&def, q, still, tau, &E, NULL), 0);
            for (int k = 0; k < 3; ++k) assert_close(tau[k], 0.0, 1e-14);
            assert_close(E, 0.0, 1e-28);
        }
    }
    double tau[3];
    const mbsr_force_def def = mbsr_force_joint_rotation_spring(0, stiffness, damping, NULL);
    assert_int_equal(ask(&def, (const double[4]){0.0}, still, tau, NULL, NULL),
                     MBSR_ZERO_QUATERNION);
}

/* Along q' = 1/2 (0, u) q. */
static void the_power_is_that_of_the_energy(void **state)
{
    (void)state;
    test_rng rng = test_seed(5);
    for (int l = 0; l < 300; ++l) {
        double q[4], u[3], rest[4], tau[3], nothing[3], E[2], loss, power = 0.0;
        test_fill(&rng, 4, q);
        test_fill(&rng, 4, rest);
        test_fill(&rng, 3, u);
        double cosine = 0.0, size = 0.0;
        for (int k = 0; k < 4; ++k) cosine += q[k] * rest[k], size += q[k] * q[k];
        if (fabs(cosine) < 0.1 || size < 0.05) continue; /* near the jump at pi */
        const mbsr_force_def def = mbsr_force_joint_rotation_spring(0, stiffness, damping, rest);
        assert_int_equal(ask(&def, q, u, tau, NULL, &loss), 0);
        const double h = 1e-5, rate[4] = {-0.5 * (u[0] * q[1] + u[1] * q[2] + u[2] * q[3]),
                                          0.5 * (u[0] * q[0] + u[1] * q[3] - u[2] * q[2]),
                                          0.5 * (u[1] * q[0] + u[2] * q[1] - u[0] * q[3]),
                                          0.5 * (u[2] * q[0] + u[0] * q[2] - u[1] * q[1])};
        for (int side = 0; side < 2; ++side) {
            double moved[4];
            for (int k = 0; k < 4; ++k) moved[k] = q[k] + (side ? h : -h) * rate[k];
            assert_int_equal(ask(&def, moved, u, nothing, E + side, NULL), 0);
        }
        for (int k = 0; k < 3; ++k) power += tau[k] * u[k];
        assert_close(power, -(E[1] - E[0]) / (2.0 * h) - loss, 1e-7);
    }
}

/* ---- in a model ---- */

/* Body 0 free, 1 spherical, 2 universal, 3 with two axes of which one is locked. */
static mbsr_model *make_bodies(test_rng *rng)
{
    static const double e_x[3] = {1, 0, 0}, e_y[3] = {0, 1, 0};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int id = 0; id < 4; ++id) {
        const mbsr_frame A = test_frame(rng, 0.5), B = test_frame(rng, 0.5);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = id - 1;
        body.joint = id == 0   ? mbsr_joint_free(&A, &B)
                     : id == 1 ? mbsr_joint_spherical(&A, &B)
                               : mbsr_joint_universal(&A, &B, e_x, e_y);
        body.inertia = mbsr_inertia_box(1000.0, (const double[3]){0.1, 0.2, 0.3});
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_lock(m, 3, 0, 0.4), mbsr_model_error(m));
    return m;
}

static void derivatives_are_right(void **state)
{
    (void)state;
    test_rng rng = test_seed(8);
    for (int l = 0; l < 20; ++l) {
        double rest[4], q[14], u[12];
        test_fill(&rng, 4, rest);
        mbsr_model *m = make_bodies(&rng);
        const mbsr_force_def force[] = {
            mbsr_force_joint_rotation_spring(0, stiffness, damping, rest),
            mbsr_force_joint_rotation_spring(1, stiffness, damping, l % 2 ? rest : NULL),
            mbsr_force_joint_cubic_spring(2, 1, 3.0, 7.0, 0.5, 0.2),
            mbsr_force_joint_cubic_spring(3, 1, 3.0, 7.0, 0.5, 0.2)};
        for (int k = 0; k < 4; ++k)
            assert_ok(mbsr_model_add_force(m, force + k, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        mbsr_data *d = NULL;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_int_equal(mbsr_model_nq(m), 14);
        test_fill(&rng, 14, q);
        test_fill(&rng, 12, u);
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
        for (int k = 0; k < 4; ++k) {
            mbsr_force_errors errors;
            assert_ok(mbsr_force_verify(m, d, k, &errors), mbsr_data_error(d));
            if (!(errors.largest < 1e-6)) print_error("force %d: %s\n", k, errors.text);
            assert_true(errors.largest < 1e-6);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

static void refuse(mbsr_force_def def, int when_added, const char *words)
{
    test_rng rng = test_seed(9);
    mbsr_model *m = make_bodies(&rng);
    int status = mbsr_model_add_force(m, &def, NULL);
    if (!when_added) {
        assert_ok(status, mbsr_model_error(m));
        status = mbsr_model_finish(m);
    }
    assert_true(status < 0);
    assert_refused(status, mbsr_model_error(m), status, MBSR_NONE, 0, words);
    mbsr_model_destroy(m);
}

static void what_they_cannot_be_is_refused(void **state)
{
    (void)state;
    const double negative[3] = {1.0, -2.0, 1.0}, bad[3] = {1.0, NAN, 1.0}, zero[4] = {0.0},
                 wild[4] = {1.0, 0.0, INFINITY, 0.0};
    const char *none = "joint rotation spring-damper|body 2 has nq = 2, n = 2|quaternion";
    refuse(mbsr_force_joint_rotation_spring(2, stiffness, damping, NULL), 0, none);
    refuse(mbsr_force_joint_rotation_spring(MBSR_GROUND, stiffness, damping, NULL), 0, "body -1");
    refuse(mbsr_force_joint_rotation_spring(1, negative, damping, NULL), 0,
           "(stiffness[1]) is -2, negative");
    refuse(mbsr_force_joint_rotation_spring(1, stiffness, negative, NULL), 0,
           "(damping[1]) is -2, negative");
    refuse(mbsr_force_joint_rotation_spring(1, bad, damping, NULL), 1, "(stiffness[1]) is nan");
    refuse(mbsr_force_joint_rotation_spring(1, stiffness, damping, zero), 1, "rest");
    refuse(mbsr_force_joint_rotation_spring(1, stiffness, damping, wild), 1, "rest");
    refuse(mbsr_force_joint_cubic_spring(2, 0, 1.0, -1.0, 0.0, 0.0), 0, "(cubic) is -1, negative");
    refuse(mbsr_force_joint_cubic_spring(2, 0, 1.0, INFINITY, 0.0, 0.0), 1, "(cubic) is inf");
    refuse(mbsr_force_joint_cubic_spring(1, 0, 1.0, 1.0, 0.0, 0.0), 0, "nq = 4, n = 3");
    refuse(mbsr_force_joint_cubic_spring(3, 2, 1.0, 1.0, 0.0, 0.0), 0, "coordinate is 2");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cubic_law),
        cmocka_unit_test(a_turn_about_one_axis_is_a_torsion_spring),
        cmocka_unit_test(the_power_is_that_of_the_energy),
        cmocka_unit_test(derivatives_are_right),
        cmocka_unit_test(what_they_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
