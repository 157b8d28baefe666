/* Inertias: mass matrices by hand, energies that do not depend on the description, gyroscopic
 * forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "recursion/inertia.h"

#include <mbsrank/driver.h>

static const mbsr_planar_frame origin = {0.0, 0.0, 0.0};

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
} scene;

/* One body with this joint and inertia on the ground. */
static scene make(mbsr_joint joint, mbsr_inertia inertia)
{
    scene s;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "disc";
    body.joint = joint;
    body.inertia = inertia;
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), 0);
    assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), 0);
    return s;
}

static void drop(scene s)
{
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

static void move(scene s, const double *q, const double *u)
{
    assert_int_equal(mbsr_stage_positions(s.model, s.data, 0.0, q), 0);
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, u), 0);
}

static double kinetic(scene s, const double *q, const double *u)
{
    double T = NAN;
    move(s, q, u);
    assert_int_equal(mbsr_energy(s.model, s.data, &T, NULL), 0);
    return T;
}

static void assert_matrix(scene s, int n, const double *expected)
{
    double mass[9];
    assert_int_equal(mbsr_mass_matrix(s.model, s.data, mass), 0);
    for (int k = 0; k < n * n; ++k) assert_close(mass[k], expected[k], 1e-14);
}

static void an_offset_centre_of_mass_gives_the_parallel_axis_matrix(void **state)
{
    (void)state;
    const double com[2] = {0.5, 0.25}, q[3] = {3.0, -2.0, 1.5707963267948966}, zero[3] = {0};
    const scene s =
        make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_planar(2.0, com, 0.3));
    move(s, q, zero);
    /* turned by 90 degrees: the centre is at (-0.25, 0.5) from the origin; 0.3 + 2 (0.25 + 0.0625)
     * = 0.925 */
    assert_matrix(s, 3, (const double[]){2, 0, -1, 0, 2, -0.5, -1, -0.5, 0.925});
    drop(s);
}

static void the_kinetic_energy_is_that_of_centre_and_spin(void **state)
{
    (void)state;
    test_rng rng = test_seed(31);
    for (int round = 0; round < 20; ++round) {
        double com[2], q[3], u[3];
        test_fill(&rng, 2, com);
        test_fill(&rng, 3, q);
        test_fill(&rng, 3, u);
        const double m = 1.0 + test_uniform(&rng), moment = 1.0 + test_uniform(&rng);
        const double rx = cos(q[2]) * com[0] - sin(q[2]) * com[1],
                     ry = sin(q[2]) * com[0] + cos(q[2]) * com[1];
        const double vx = u[0] - u[2] * ry, vy = u[1] + u[2] * rx;
        const double expected = 0.5 * m * (vx * vx + vy * vy) + 0.5 * moment * u[2] * u[2];
        const scene s =
            make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_planar(m, com, moment));
        assert_close(kinetic(s, q, u), expected, 1e-14);
        drop(s);
        /* the same body described from its centre: origin moved there by the joint's frame B */
        const mbsr_planar_frame B = {-com[0], -com[1], 0.0};
        const double centre[2] = {0, 0};
        const scene c =
            make(mbsr_joint_planar_free(origin, B), mbsr_inertia_planar(m, centre, moment));
        assert_close(kinetic(c, q, u), expected, 1e-14);
        drop(c);
    }
}

/* h = M' V - 1/2 d(V^T M V)/dp, by differences of the mass matrix. */
static void the_gyroscopic_force_balances_momentum(void **state)
{
    (void)state;
    test_rng rng = test_seed(32);
    for (int round = 0; round < 10; ++round) {
        const double h = 1e-5;
        double com[2], p[3], V[3], ahead[9], behind[9], M[9], gyroscopic[3] = {NAN, NAN, NAN};
        test_fill(&rng, 2, com);
        test_fill(&rng, 3, p);
        test_fill(&rng, 3, V);
        V[2] += 2.0;
        const mbsri_body b = {.d = 3, .np = 3, .inertia = mbsr_inertia_planar(1.7, com, 0.6)};
        mbsri_inertia_mass(&b, p, M);
        assert_int_equal(mbsri_inertia_velocity(&b, 0.0, p, V, M, gyroscopic), 0);
        double expected[3] = {0};
        for (int l = 0; l < 3; ++l) {
            double moved[3] = {p[0], p[1], p[2]};
            moved[l] = p[l] + h;
            mbsri_inertia_mass(&b, moved, ahead);
            moved[l] = p[l] - h;
            mbsri_inertia_mass(&b, moved, behind);
            for (int j = 0; j < 3; ++j) {
                for (int k = 0; k < 3; ++k) {
                    const double slope = (ahead[j * 3 + k] - behind[j * 3 + k]) / (2.0 * h);
                    expected[k] += slope * V[l] * V[j];
                    expected[l] -= 0.5 * slope * V[k] * V[j];
                }
            }
        }
        assert_true(test_largest(3, expected) > 1e-3);
        for (int k = 0; k < 3; ++k) assert_close(gyroscopic[k], expected[k], 1e-9);
    }
}

/* The force on a body that spins about its own origin at rest is the centripetal one. */
static void a_spinning_body_pulls_at_its_axis(void **state)
{
    (void)state;
    const double com[2] = {0.5, 0.0}, q[3] = {0.0, 0.0, 0.0}, u[3] = {0.0, 0.0, 3.0}, udot[3] = {0};
    double tau[3];
    const scene s =
        make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_planar(2.0, com, 0.7));
    assert_int_equal(mbsr_inverse_dynamics(s.model, s.data, 0.0, q, u, udot, NULL, tau), 0);
    assert_close(tau[0], -2.0 * 0.5 * 9.0, 1e-13);
    assert_close(tau[1], 0.0, 1e-13);
    assert_close(tau[2], 0.0, 1e-13);
    drop(s);
}

static void a_particle_has_mass_but_no_moment(void **state)
{
    (void)state;
    const double q[3] = {1, 2, 3}, u[3] = {0.5, -0.25, 7.0};
    const scene disc = make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_particle(4.0));
    assert_close(kinetic(disc, q, u), 2.0 * (0.25 + 0.0625), 1e-15);
    assert_matrix(disc, 3, (const double[]){4, 0, 0, 0, 4, 0, 0, 0, 0});
    drop(disc);
    const scene point = make(mbsr_joint_point_free(), mbsr_inertia_particle(4.0));
    assert_close(kinetic(point, q, u), 2.0 * (0.25 + 0.0625), 1e-15);
    assert_matrix(point, 2, (const double[]){4, 0, 0, 4});
    drop(point);
}

static void a_matrix_is_used_as_it_is(void **state)
{
    (void)state;
    const double M[9] = {3, 0.5, 0.2, 0.5, 2, -0.1, 0.2, -0.1, 1}, q[3] = {1, 2, 3},
                 u[3] = {1, -1, 2};
    const scene s = make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_matrix(3, M));
    assert_close(kinetic(s, q, u), 0.5 * (3 + 2 + 4 - 1.0 + 0.8 + 0.4), 1e-14);
    assert_matrix(s, 3, M);
    drop(s);
}

static void zero_and_not_given_count_the_same_but_are_told_apart(void **state)
{
    (void)state;
    const mbsr_inertia not_given = mbsr_default_body_def().inertia, zero = mbsr_inertia_zero();
    assert_int_equal(not_given.kind, MBSR_INERTIA_NOT_GIVEN);
    assert_int_not_equal(zero.kind, MBSR_INERTIA_NOT_GIVEN);
    const double q[3] = {1, 2, 3}, u[3] = {1, -1, 2};
    const mbsr_joint joints[] = {mbsr_joint_planar_free(origin, origin), mbsr_joint_point_free()};
    for (int k = 0; k < 2; ++k) {
        for (int given = 0; given < 2; ++given) {
            const scene s = make(joints[k], given ? zero : not_given);
            assert_close(kinetic(s, q, u), 0.0, 0.0);
            assert_matrix(s, joints[k].d, (const double[9]){0});
            assert_int_equal(mbsr_stage_forces(s.model, s.data, NULL), 0);
            assert_int_equal(mbsr_stage_backward(s.model, s.data), 0);
            assert_int_equal(mbsr_total_rank(s.model, s.data), 0);
            drop(s);
        }
    }
}

/* ---- inertia by function --------------------------------------------------------------------- */

typedef struct rotor {
    int calls, code;
    double bad;
} rotor;

/* m = 2 + sin(y) along x, 3 along y, moment 1; h derived from it. */
static int rotor_inertia(void *user, double t, const double *p, const double *V, double *M,
                         double *h)
{
    rotor *w = user;
    ++w->calls;
    for (int k = 0; k < 9; ++k) assert_close(M[k], 0.0, 0.0);
    for (int k = 0; k < 3; ++k) assert_close(h[k], 0.0, 0.0);
    assert_close(t, 0.0, 0.0);
    M[0] = 2.0 + sin(p[1]);
    M[4] = 3.0;
    M[8] = 1.0 + w->bad;
    h[0] = cos(p[1]) * V[0] * V[1];
    h[1] = -0.5 * cos(p[1]) * V[0] * V[0];
    return w->code;
}

static void an_inertia_by_function_is_asked_once_a_state(void **state)
{
    (void)state;
    rotor w = {0, 0, 0.0};
    const double q[3] = {1, 0.5, 3}, u[3] = {1, -1, 2}, udot[3] = {0.3, 0.4, 0.5};
    double tau[3];
    const scene s =
        make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_function(rotor_inertia, &w));
    const double m = 2.0 + sin(0.5), slope = cos(0.5);
    w.calls = 0; /* the model asks when it is finished */
    assert_close(kinetic(s, q, u), 0.5 * (m + 3.0 + 4.0), 1e-14);
    assert_int_equal(w.calls, 1);
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, u), 0); /* again in the same pose */
    assert_int_equal(w.calls, 2);
    assert_matrix(s, 3, (const double[]){m, 0, 0, 0, 3, 0, 0, 0, 1});
    assert_int_equal(mbsr_inverse_dynamics(s.model, s.data, 0.0, q, u, udot, NULL, tau), 0);
    assert_int_equal(w.calls, 3);
    assert_close(tau[0], m * 0.3 - slope, 1e-14);
    assert_close(tau[1], 3.0 * 0.4 - 0.5 * slope, 1e-14);
    assert_close(tau[2], 0.5, 1e-14);
    drop(s);
}

static void what_an_inertia_function_returns_is_passed_on(void **state)
{
    (void)state;
    static const int codes[] = {17, -7};
    const double q[3] = {1, 0.5, 3}, u[3] = {1, -1, 2};
    for (int k = 0; k < 2; ++k) {
        rotor w = {0, codes[k], 0.0};
        const scene s =
            make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_function(rotor_inertia, &w));
        assert_int_equal(mbsr_stage_positions(s.model, s.data, 0.0, q), 0);
        assert_refused(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data), codes[k],
                       0, MBSR_NONE, "body 0 'disc'|inertia|function");
        drop(s);
    }
}

static void a_bad_matrix_from_a_function_is_found(void **state)
{
    (void)state;
    const double q[3] = {1, 0.5, 3}, u[3] = {1, -1, 2};
    double y[6], F[6];
    memcpy(y, q, sizeof q);
    memcpy(y + 3, u, sizeof u);
    rotor w = {0, 0, NAN};
    scene s =
        make(mbsr_joint_planar_free(origin, origin), mbsr_inertia_function(rotor_inertia, &w));
    for (int form = MBSR_DAE_RECURSIVE; form <= MBSR_DAE_INVERSE_DYNAMICS; ++form) {
        assert_refused(mbsr_dae_residual(s.model, s.data, (mbsr_dae_form)form, 0.0, y, y, F),
                       mbsr_data_error(s.data), MBSR_NOT_FINITE, 0, MBSR_NONE,
                       "body 0 'disc'|mass matrix");
    }
    w.bad = -2.0; /* moment -1 */
    assert_refused(mbsr_dae_residual(s.model, s.data, MBSR_DAE_RECURSIVE, 0.0, y, y, F),
                   mbsr_data_error(s.data), MBSR_INDEFINITE_MASS, 0, MBSR_NONE,
                   "body 0 'disc'|indefinite");
    drop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_offset_centre_of_mass_gives_the_parallel_axis_matrix),
        cmocka_unit_test(the_kinetic_energy_is_that_of_centre_and_spin),
        cmocka_unit_test(the_gyroscopic_force_balances_momentum),
        cmocka_unit_test(a_spinning_body_pulls_at_its_axis),
        cmocka_unit_test(a_particle_has_mass_but_no_moment),
        cmocka_unit_test(a_matrix_is_used_as_it_is),
        cmocka_unit_test(zero_and_not_given_count_the_same_but_are_told_apart),
        cmocka_unit_test(an_inertia_by_function_is_asked_once_a_state),
        cmocka_unit_test(what_an_inertia_function_returns_is_passed_on),
        cmocka_unit_test(a_bad_matrix_from_a_function_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
