/* What single force elements exert, contacts, and elements switched off.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <string.h>

enum { GRAVITY, SPRING, BUSHING, CONTACT, JOINT, ELEMENTS };

static const double CENTRE[3] = {0.1, 0.0, -0.3}, A[3] = {0.2, 0.1, 0.0}, B[3] = {0.0, -0.1, 0.3};
static const double STIFFNESS = 300.0, DAMPING = 2.0, LENGTH = 0.4;

/* A free body, and one on it by a hinge; the elements but for `without`. */
static mbsr_model *build(int without)
{
    const double six[6] = {3.0, 2.0, 1.0, 50.0, 60.0, 70.0}, axis[3] = {0.0, 1.0, 0.0},
                 offset[3] = {0.1, 0.2, 0.3}, edges[3] = {0.3, 0.2, 0.4};
    const mbsr_contact ball = {.centre = {0.1, 0.0, -0.3},
                               .radius = 0.25,
                               .normal = {0.0, 0.0, 2.0},
                               .stiffness = 1e4,
                               .exponent = 1.5,
                               .damping = 0.2,
                               .friction = 0.6,
                               .slip = 0.01};
    mbsr_model *m = NULL;
    mbsr_body_def body = mbsr_default_body_def();
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    body.joint = mbsr_joint_free(NULL, NULL);
    body.inertia = mbsr_inertia_box(80.0, edges);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_frame at = mbsr_frame_at(0.1, 0.2, 0.3);
    body.parent = 0;
    body.joint = mbsr_joint_revolute(&at, NULL, axis);
    body.inertia = mbsr_inertia_point_mass(1.0, offset);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def all[ELEMENTS] = {
        mbsr_force_gravity(0.0, 1.0, -9.81),
        mbsr_force_point_spring(1, A, MBSR_GROUND, B, STIFFNESS, DAMPING, LENGTH),
        mbsr_force_bushing(0, NULL, 1, NULL, six, six), mbsr_force_contact(0, MBSR_GROUND, &ball),
        mbsr_force_joint_spring(1, 0, 5.0, 0.3, 0.2)};
    for (int k = 0; k < ELEMENTS; ++k) {
        if (k != without) assert_ok(mbsr_model_add_force(m, all + k, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static const double Q[8] = {0.9, 0.1, -0.2, 0.3, 0.05, -0.1, 0.3, 0.7},
                    U[7] = {0.3, -0.5, 0.2, 1.0, -0.4, -0.7, 0.9};

static mbsr_data *data_at(const mbsr_model *m)
{
    mbsr_data *d = NULL;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_stage_positions(m, d, 0.0, Q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, U), mbsr_data_error(d));
    return d;
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* ---- loads ---- */

/* The loads of all elements on all bodies, by the bodies' Jacobians, are what the elements change
 * in the joint forces of inverse dynamics. */
static void loads_are_what_the_elements_exert(void **state)
{
    (void)state;
    static const int body[ELEMENTS][2] = {{0, 1}, {1, -1}, {0, 1}, {0, -1}, {1, -1}};
    mbsr_model *m = build(-1);
    mbsr_data *d = data_at(m);
    for (int k = 0; k < ELEMENTS; ++k) {
        double sum[7] = {0.0}, with[7], without[7];
        mbsr_model *less = build(k);
        mbsr_data *e = data_at(less);
        assert_ok(mbsr_bias_forces(m, d, 0.0, Q, U, with), mbsr_data_error(d));
        assert_ok(mbsr_bias_forces(less, e, 0.0, Q, U, without), mbsr_data_error(e));
        for (int place = 0; place < 2; ++place) {
            double f[6], tau[6], J[6 * 7];
            const int on = body[k][place];
            if (on < 0) continue;
            int u = 0, n = 0;
            assert_ok(mbsr_force_load(m, d, k, place, f, tau), mbsr_data_error(d));
            assert_ok(mbsr_body_jacobian(m, d, on, J), mbsr_data_error(d));
            mbsr_body_coordinates(m, on, NULL, NULL, &u, &n);
            for (int c = 0; c < 7; ++c) {
                for (int r = 0; r < 6; ++r) sum[c] += J[6 * c + r] * f[r];
            }
            for (int c = 0; c < n; ++c) sum[u + c] += tau[c];
        }
        for (int c = 0; c < 7; ++c) assert_close(without[c] - with[c], sum[c], 1e-10);
        mbsr_data_destroy(e);
        mbsr_model_destroy(less);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void springs_and_contacts_by_hand(void **state)
{
    (void)state;
    mbsr_model *m = build(-1);
    mbsr_data *d = data_at(m);
    double pose[2][MBSR_POSE_SIZE], twist[6], f[6], arm[3], moment[3], e[3], v[3], size = 0.0;
    /* the spring */
    assert_ok(mbsr_body_pose(m, d, 1, pose[1]), mbsr_data_error(d));
    assert_ok(mbsr_body_twist(m, d, 1, twist), mbsr_data_error(d));
    for (int r = 0; r < 3; ++r) {
        arm[r] = 0.0;
        for (int c = 0; c < 3; ++c) arm[r] += pose[1][3 * c + r] * A[c];
        e[r] = pose[1][MBSR_POSE_X + r] + arm[r] - B[r];
        size += e[r] * e[r];
    }
    size = sqrt(size);
    cross(twist, arm, v);
    double rate = 0.0;
    for (int r = 0; r < 3; ++r) rate += (v[r] + twist[3 + r]) * e[r] / size;
    assert_ok(mbsr_force_load(m, d, SPRING, 0, f, NULL), mbsr_data_error(d));
    for (int r = 0; r < 3; ++r) {
        assert_close(f[3 + r], -(STIFFNESS * (size - LENGTH) + DAMPING * rate) * e[r] / size,
                     1e-10);
    }
    cross(arm, f + 3, moment);
    for (int r = 0; r < 3; ++r) assert_close(f[r], moment[r], 1e-10);
    /* the contact with the ground z = 0 */
    mbsr_contact_state touch;
    assert_ok(mbsr_contact_at(m, d, CONTACT, &touch), mbsr_data_error(d));
    assert_ok(mbsr_body_pose(m, d, 0, pose[0]), mbsr_data_error(d));
    double height = pose[0][MBSR_POSE_X + 2];
    for (int c = 0; c < 3; ++c) height += pose[0][3 * c + 2] * CENTRE[c];
    assert_close(touch.depth, 0.25 - height, 1e-14);
    assert_true(touch.depth > 0.0);
    assert_close(touch.normal_force, 1e4 * pow(touch.depth, 1.5) * (1.0 + 0.2 * touch.rate), 1e-9);
    assert_close(touch.point[2], height - 0.25, 1e-14);
    const double speed =
        sqrt(touch.sliding[0] * touch.sliding[0] + touch.sliding[1] * touch.sliding[1] + 1e-4);
    assert_ok(mbsr_force_load(m, d, CONTACT, 0, f, NULL), mbsr_data_error(d));
    for (int r = 0; r < 3; ++r) {
        assert_close(touch.normal[r], r == 2, 1e-15);
        assert_close(touch.friction[r], -0.6 * touch.normal_force * touch.sliding[r] / speed, 1e-9);
        assert_close(f[3 + r], touch.normal_force * touch.normal[r] + touch.friction[r], 1e-9);
        arm[r] = touch.point[r] - pose[0][MBSR_POSE_X + r];
    }
    cross(arm, f + 3, moment);
    for (int r = 0; r < 3; ++r) assert_close(f[r], moment[r], 1e-9);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- switched off ---- */

/* Dynamics, energies and Newton systems of the model without the element; on again all is back. */
static void elements_switched_off_are_not_there(void **state)
{
    (void)state;
    mbsr_model *m = build(-1);
    mbsr_data *d = data_at(m);
    for (int k = SPRING; k < ELEMENTS; ++k) {
        mbsr_model *less = build(k);
        mbsr_data *e = data_at(less);
        const mbsr_model *model[2] = {m, less};
        mbsr_data *data[2] = {d, e};
        double udot[2][7], tau[2][7], y[22], yp[22] = {0.1}, F[2][22], delta[2][22], energy[2],
                                             power[2];
        assert_ok(mbsr_force_switch(m, d, k, 0), mbsr_data_error(d));
        for (int l = 0; l < 2; ++l) {
            mbsr_newton *newton = NULL;
            const mbsr_model *of = model[l];
            mbsr_data *at = data[l];
            assert_ok(mbsr_forward_dynamics(of, at, 0.0, Q, U, NULL, udot[l]), mbsr_data_error(at));
            assert_ok(mbsr_inverse_dynamics(of, at, 0.0, Q, U, U, NULL, tau[l]),
                      mbsr_data_error(at));
            assert_ok(mbsr_stage_positions(of, at, 0.0, Q), mbsr_data_error(at));
            assert_ok(mbsr_stage_velocities(of, at, U), mbsr_data_error(at));
            assert_ok(mbsr_energy(of, at, NULL, energy + l), mbsr_data_error(at));
            assert_ok(mbsr_dissipation(of, at, power + l), mbsr_data_error(at));
            assert_ok(mbsr_dae_pack(of, at, MBSR_DAE_MOMENTUM, 0.0, Q, U, y), mbsr_data_error(at));
            assert_ok(mbsr_dae_residual(of, at, MBSR_DAE_MOMENTUM, 0.0, y, yp, F[l]),
                      mbsr_data_error(at));
            assert_int_equal(mbsr_newton_create(of, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), 0);
            assert_ok(mbsr_newton_factor(newton, at, 0.0, y, yp, 50.0), mbsr_newton_error(newton));
            assert_ok(mbsr_newton_solve(newton, F[0], delta[l]), mbsr_newton_error(newton));
            mbsr_newton_destroy(newton);
        }
        assert_close(energy[0], energy[1], 1e-12);
        assert_close(power[0], power[1], 1e-12);
        for (int c = 0; c < 7; ++c) {
            assert_close(udot[0][c], udot[1][c], 1e-10);
            assert_close(tau[0][c], tau[1][c], 1e-10);
        }
        for (int c = 0; c < 22; ++c) {
            assert_close(F[0][c], F[1][c], 1e-10);
            assert_close(delta[0][c], delta[1][c], 1e-9 * (1.0 + fabs(delta[1][c])));
        }
        double f[6], again[7];
        assert_ok(mbsr_stage_positions(m, d, 0.0, Q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, U), mbsr_data_error(d));
        assert_ok(mbsr_force_load(m, d, k, 0, f, NULL), mbsr_data_error(d));
        for (int c = 0; c < 6; ++c) assert_true(f[c] == 0.0);
        assert_ok(mbsr_force_switch(m, d, k, 1), mbsr_data_error(d));
        assert_ok(mbsr_inverse_dynamics(m, d, 0.0, Q, U, U, NULL, again), mbsr_data_error(d));
        assert_true(memcmp(again, tau[0], sizeof again) != 0);
        mbsr_data_destroy(e);
        mbsr_model_destroy(less);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void wrong_questions_are_refused(void **state)
{
    (void)state;
    mbsr_model *m = build(-1);
    mbsr_data *d = NULL;
    mbsr_contact_state touch;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_force_load(m, d, 0, 0, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_contact_at(m, d, CONTACT, &touch), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_stage_positions(m, d, 0.0, Q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, U), mbsr_data_error(d));
    assert_refused(mbsr_force_load(m, d, 9, 0, NULL, NULL), mbsr_data_error(d), MBSR_ERR_ID,
                   MBSR_NONE, MBSR_NONE, "mbsr_force_load|no force 9");
    assert_refused(mbsr_force_load(m, d, SPRING, 2, NULL, NULL), mbsr_data_error(d), MBSR_ERR_VALUE,
                   MBSR_NONE, SPRING, "place is 2|acts on 2 bodies");
    assert_refused(mbsr_force_load(m, d, SPRING, -1, NULL, NULL), mbsr_data_error(d),
                   MBSR_ERR_VALUE, MBSR_NONE, SPRING, "place is -1");
    assert_refused(mbsr_contact_at(m, d, SPRING, &touch), mbsr_data_error(d), MBSR_ERR_VALUE,
                   MBSR_NONE, SPRING, "is no contact");
    assert_int_equal(mbsr_contact_at(m, d, CONTACT, NULL), MBSR_ERR_NULL);
    assert_refused(mbsr_force_switch(m, d, GRAVITY, 0), mbsr_data_error(d), MBSR_ERR_VALUE,
                   MBSR_NONE, GRAVITY, "always on");
    assert_refused(mbsr_force_switch(m, d, SPRING, 2), mbsr_data_error(d), MBSR_ERR_VALUE,
                   MBSR_NONE, SPRING, "on is 2");
    assert_refused(mbsr_force_switch(m, d, -1, 0), mbsr_data_error(d), MBSR_ERR_ID, MBSR_NONE,
                   MBSR_NONE, "no force -1");
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loads_are_what_the_elements_exert),
        cmocka_unit_test(springs_and_contacts_by_hand),
        cmocka_unit_test(elements_switched_off_are_not_there),
        cmocka_unit_test(wrong_questions_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
