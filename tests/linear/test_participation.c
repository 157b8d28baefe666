/* Where the energy of a mode is: on paper, and against energies of models that move.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "units.h"

#include <mbsrank/linear.h>

#include <stdlib.h>

static const double along[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0};

/* Two masses on three springs, in four systems of units: (1, 1) leaves the one between them alone,
 * (1, -1) takes it twice. The damper in the middle damps the second alone. */
static void two_masses(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double stiffness = 40.0 * s->mass / (s->time * s->time),
                     damping = 0.3 * s->mass / s->time, q[2] = {0.0};
        mbsr_model *m = empty();
        mbsr_error error;
        mbsr_mode mode[4];
        mbsr_linear *l;
        int count;
        for (int i = 0; i < 2; ++i)
            add_body(m, i - 1, NULL, mbsr_joint_prismatic(NULL, NULL, along),
                     mbsr_inertia_particle(1.5 * s->mass));
        add_force(m, mbsr_force_joint_spring(0, 0, stiffness, 0.0, 0.0));
        add_force(m, mbsr_force_point_spring(1, NULL, MBSR_GROUND,
                                             (const double[3]){9.0 * s->length, 0, 0}, stiffness,
                                             0.0, 9.0 * s->length));
        add_force(m, mbsr_force_joint_spring(1, 0, 2.0 * stiffness, damping, 0.0));
        mbsr_data *d = finish(m);
        assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        assert_int_equal(count, 2);
        const double expected[2][3] = {{0.5, 0.5, 0.0}, {0.1, 0.1, 0.8}};
        for (int i = 0; i < 2; ++i) {
            double re[2], im[2], T[2], V[3], D[3];
            assert_ok(mbsr_linear_shape(l, i, re, im), NULL);
            assert_ok(mbsr_mode_participation(m, d, 0.0, q, mode + i, re, im, T, V, D, &error),
                      &error);
            for (int j = 0; j < 2; ++j) assert_close(T[j], 0.5, 1e-9);
            for (int j = 0; j < 3; ++j) assert_close(V[j], expected[i][j], 1e-6);
            if (i == 1) assert_close(D[2], 1.0, 1e-6);
        }
        mbsr_linear_destroy(l);
        free_both(m, d);
    }
}

/* A rod upright on a spring at its hinge: gravity takes from what the spring holds, k - m g h. A
 * wheel of some armature turns beside it. */
static void gravity_has_a_negative_share(void **state)
{
    (void)state;
    const double mass = 2.0, h = 0.5, g = 10.0, k = 40.0, q[2] = {0.0}, armature = 0.7;
    mbsr_model *m = empty();
    mbsr_error error;
    mbsr_mode mode = {.imaginary = 1.0};
    double re[2] = {1.0, 0.5}, T[2], V[2];
    add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(mass, (const double[3]){0, 0, h}));
    add_body(m, MBSR_GROUND, "wheel", mbsr_joint_revolute(NULL, NULL, y_axis), mbsr_inertia_zero());
    assert_ok(mbsr_model_armature(m, 1, 1, &armature), mbsr_model_error(m));
    add_force(m, mbsr_force_joint_spring(0, 0, k, 0.0, 0.0));
    add_force(m, mbsr_force_gravity(0, 0, -g));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_mode_participation(m, d, 0.0, q, &mode, re, NULL, T, V, NULL, &error), &error);
    const double held = k + mass * g * h, moved = mass * h * h + 0.25 * armature;
    assert_close(V[0], k / held, 1e-8);
    assert_close(V[1], -mass * g * h / held, 1e-8);
    assert_close(T[0], mass * h * h / moved, 1e-12);
    assert_close(T[1], 0.25 * armature / moved, 1e-12);
    assert_refused(mbsr_mode_participation(m, d, 0.0, q, NULL, re, NULL, T, V, NULL, &error),
                   &error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mode is NULL");
    free_both(m, d);
}

/* Rayleigh: of a mode without damping all potential energy is all kinetic energy, so that shares
 * of springs are those of their energies 1/2 k (x)^2 along the shape; chains in space, a fifth of
 * the bodies without mass. */
static void springs_of_a_chain(void **state)
{
    (void)state;
    enum { BODIES = 12 };
    test_rng rng = test_seed(3);
    for (int round = 0; round < 20; ++round) {
        mbsr_model *m = empty();
        mbsr_error error;
        double q[BODIES] = {0.0}, k[BODIES], re[2 * BODIES], im[2 * BODIES], T[BODIES], V[BODIES];
        mbsr_near_opt opt = mbsr_default_near_opt();
        mbsr_mode mode[2];
        int found;
        opt.count = 2;
        for (int i = 0; i < BODIES; ++i) {
            double axis[3], centre[3];
            const mbsr_frame at =
                mbsr_frame_at(test_uniform(&rng), test_uniform(&rng), test_uniform(&rng));
            test_fill(&rng, 3, axis);
            test_fill(&rng, 3, centre);
            k[i] = exp(2.0 * test_uniform(&rng));
            add_body(m, i > 0 ? i - 1 : MBSR_GROUND, NULL, mbsr_joint_revolute(&at, NULL, axis),
                     i % 5 == 2 ? mbsr_inertia_zero()
                                : mbsr_inertia_rigid(1.0, centre, (const double[6]){1, 1, 1}));
            add_force(m, mbsr_force_joint_spring(i, 0, k[i], 0.0, 0.0));
        }
        mbsr_data *d = finish(m);
        assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, re, im, &error), &error);
        assert_int_equal(found, 2);
        for (int l = 0; l < 2; ++l) {
            const double *x = re + l * BODIES;
            double sum = 0.0, energy = 0.0;
            assert_ok(mbsr_mode_participation(m, d, 0.0, q, mode + l, x, im + l * BODIES, T, V,
                                              NULL, &error),
                      &error);
            for (int i = 0; i < BODIES; ++i) sum += k[i] * x[i] * x[i];
            for (int i = 0; i < BODIES; ++i) assert_close(V[i], k[i] * x[i] * x[i] / sum, 1e-6);
            assert_ok(mbsr_stage_positions(m, d, 0.0, q), NULL);
            assert_ok(mbsr_stage_velocities(m, d, x), NULL);
            assert_ok(mbsr_energy(m, d, &energy, NULL), NULL);
            assert_close(2.0 * energy * mode[l].imaginary * mode[l].imaginary / sum, 1.0, 1e-8);
            for (int i = 0; i < BODIES; ++i) {
                double of_body;
                assert_ok(mbsr_body_energy(m, d, i, &of_body), NULL);
                assert_close(T[i], of_body / energy, 1e-9);
            }
        }
        free_both(m, d);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_masses),
                                       cmocka_unit_test(gravity_has_a_negative_share),
                                       cmocka_unit_test(springs_of_a_chain)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
