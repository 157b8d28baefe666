/* Servos, characteristics and gears: the laws, their derivatives, what they refuse.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton_along.h"

#include <mbsrank/verify.h>

#include <string.h>

static const double X[3] = {0.0, 1.0, 3.0}, V[6] = {0.2, 1.0, -0.5, 0.0, 0.0, 0.0};

static mbsr_table *make(mbsr_table_kind kind, int columns)
{
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table = NULL;
    def.points = 3;
    def.columns = columns;
    def.x = X;
    def.value = V;
    def.kind = kind;
    def.beyond = MBSR_TABLE_STRAIGHT;
    assert_int_equal(mbsr_table_create(&def, &table, NULL), MBSR_OK);
    return table;
}

/* Three hinges in a row and a slider beside them, with one element. */
static mbsr_model *build(mbsr_force_def force)
{
    const double y[3] = {0.0, 1.0, 0.0}, x[3] = {1.0, 0.0, 0.0}, tip[3] = {0.1, 0.2, -0.5};
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 4; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k < 3 ? k - 1 : MBSR_GROUND;
        body.joint =
            k < 3 ? mbsr_joint_revolute(NULL, NULL, y) : mbsr_joint_prismatic(NULL, NULL, x);
        body.inertia = mbsr_inertia_point_mass(1.0 + k, tip);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* tau of the element at a state, and its derivatives against differences; the Newton solver against
 * differences of the residual. */
static void tau_of(mbsr_force_def force, double t, const double *q, const double *u, double tau[4])
{
    mbsr_model *m = build(force);
    mbsr_data *d = NULL;
    mbsr_force_errors errors;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_stage_positions(m, d, t, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    memset(tau, 0, 4 * sizeof *tau);
    for (int k = 0; k < force.bodies; ++k) {
        double one = 0.0;
        assert_ok(mbsr_force_load(m, d, 0, k, NULL, &one), mbsr_data_error(d));
        tau[force.body[k]] += one;
    }
    assert_ok(mbsr_force_verify(m, d, 0, &errors), mbsr_data_error(d));
    assert_less(errors.largest, 1e-7);

    /* the solver */
    enum { SIZE = 12 };
    const double c = 30.0;
    double y[SIZE], yp[SIZE], r[SIZE], delta[SIZE];
    mbsr_newton *newton = NULL;
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, t, q, u, y), mbsr_data_error(d));
    for (int k = 0; k < SIZE; ++k) yp[k] = 0.1 * k, r[k] = sin(k + 1.0);
    assert_int_equal(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), MBSR_OK);
    assert_ok(mbsr_newton_factor(newton, d, t, y, yp, c), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
    test_newton_along(m, d, t, y, yp, c, r, delta);
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static const double Q[4] = {0.3, -0.4, 0.9, 0.25}, U[4] = {1.5, -0.7, 0.4, -0.3};

static int wave(void *user, double t, int n, double *value)
{
    (void)user;
    assert_int_equal(n, 2);
    value[0] = sin(t);
    value[1] = cos(t);
    return 0;
}

static void servos_follow_references(void **state)
{
    (void)state;
    double tau[4], r[2];
    mbsr_table *table = make(MBSR_TABLE_SPLINE, 1);
    mbsr_servo servo = {.kp = 20.0, .kd = 3.0, .reference = 0.7};
    tau_of(mbsr_force_joint_servo(1, 0, &servo), 0.4, Q, U, tau);
    assert_close(tau[1], 20.0 * (0.7 - Q[1]) - 3.0 * U[1], 1e-13);
    assert_true(tau[0] == 0.0 && tau[2] == 0.0);
    servo.function = wave;
    tau_of(mbsr_force_joint_servo(2, 0, &servo), 0.4, Q, U, tau);
    assert_close(tau[2], 20.0 * (sin(0.4) - Q[2]) + 3.0 * (cos(0.4) - U[2]), 1e-13);
    servo.table = table;
    tau_of(mbsr_force_joint_servo(3, 0, &servo), 0.4, Q, U, tau);
    assert_int_equal(mbsr_table_value(table, 0.4, r, r + 1, NULL), MBSR_OK);
    assert_close(tau[3], 20.0 * (r[0] - Q[3]) + 3.0 * (r[1] - U[3]), 1e-13);
    servo.limit = 2.5;
    tau_of(mbsr_force_joint_servo(3, 0, &servo), 0.4, Q, U, tau);
    assert_close(tau[3], 2.5, 0.0);
    mbsr_table_destroy(table);
}

static void characteristics_go_with_speed(void **state)
{
    (void)state;
    double tau[4], value = 0.0;
    mbsr_table *table = make(MBSR_TABLE_MONOTONE, 1);
    for (int k = 0; k < 4; ++k) {
        tau_of(mbsr_force_joint_curve(k, 0, table), 0.0, Q, U, tau);
        assert_int_equal(mbsr_table_value(table, U[k], &value, NULL, NULL), MBSR_OK);
        assert_close(tau[k], value, 1e-15);
    }
    mbsr_table_destroy(table);
}

/* Between neighbours, across a body, and across the tree; in contact on both sides and free. */
static void gears_tie_two_coordinates(void **state)
{
    (void)state;
    static const int pair[3][2] = {{0, 1}, {2, 0}, {3, 2}};
    static const double backlash[3] = {0.0, 0.08, 50.0};
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) {
            for (int sign = -1; sign <= 1; sign += 2) {
                const int a = pair[k][0], b = pair[k][1];
                double tau[4];
                const mbsr_gear gear = {.ratio = -2.5 * sign,
                                        .stiffness = 40.0,
                                        .damping = 3.0,
                                        .backlash = backlash[l],
                                        .rest = 0.1};
                const double e = Q[a] + 2.5 * sign * Q[b] - 0.1, v = U[a] + 2.5 * sign * U[b];
                const double s = e < 0.0 ? -1.0 : 1.0, F = 40.0 * (fabs(e) - 0.04);
                const double T = l == 0   ? 40.0 * e + 3.0 * v
                                 : l == 1 ? s * (F + fmax(-F, fmin(3.0 * s * v, F)))
                                          : 0.0;
                tau_of(mbsr_force_gear(a, 0, b, 0, &gear), 0.0, Q, U, tau);
                assert_true(l != 1 || F > 0.0);
                assert_close(tau[a], -T, 1e-12);
                assert_close(tau[b], gear.ratio * T, 1e-12);
            }
        }
    }
}

/* The energy of the gear goes into motion, or into heat. */
static void gears_balance_power(void **state)
{
    (void)state;
    const mbsr_gear gear = {.ratio = 3.0, .stiffness = 40.0, .damping = 2.0, .backlash = 0.2};
    mbsr_model *m = build(mbsr_force_gear(0, 0, 3, 0, &gear));
    mbsr_data *d = NULL;
    double q[4], E[2], power = 0.0, f[2], heat = 0.0;
    const double h = 1e-6;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    for (int side = 0; side < 2; ++side) {
        for (int k = 0; k < 4; ++k) q[k] = Q[k] + (side ? h : -h) * U[k];
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, U), mbsr_data_error(d));
        assert_ok(mbsr_force_power(m, d, 0, E + side, &heat), mbsr_data_error(d));
    }
    assert_ok(mbsr_stage_positions(m, d, 0.0, Q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, U), mbsr_data_error(d));
    assert_ok(mbsr_force_power(m, d, 0, NULL, &heat), mbsr_data_error(d));
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_force_load(m, d, 0, k, NULL, f + k), mbsr_data_error(d));
        power += f[k] * U[k ? 3 : 0];
    }
    assert_close(-power, (E[1] - E[0]) / (2.0 * h) + heat, 1e-7);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- refusals ---- */

static void refuse(mbsr_force_def force, int status, const char *words)
{
    const double y[3] = {0.0, 1.0, 0.0};
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = k ? mbsr_joint_spherical(NULL, NULL) : mbsr_joint_revolute(NULL, NULL, y);
        body.inertia = mbsr_inertia_sphere(1.0, 1.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    int result = mbsr_model_add_force(m, &force, NULL);
    if (!result) result = mbsr_model_finish(m);
    assert_refused(result, mbsr_model_error(m), status, MBSR_NONE, 0, words);
    mbsr_model_destroy(m);
}

static void wrong_drives_are_refused(void **state)
{
    (void)state;
    mbsr_table *two = make(MBSR_TABLE_LINEAR, 2);
    mbsr_servo servo = {.kp = 1.0};
    mbsr_gear gear = {.ratio = 2.0, .stiffness = 1.0};
    refuse(mbsr_force_joint_servo(0, 0, NULL), MBSR_ERR_NULL, "is NULL");
    refuse(mbsr_force_joint_servo(0, 1, &servo), MBSR_ERR_VALUE, "coordinate is 1|body 0 has 1");
    refuse(mbsr_force_joint_servo(1, 0, &servo), MBSR_ERR_SPACE, "body 1|nq = 4, n = 3");
    refuse(mbsr_force_joint_servo(MBSR_GROUND, 0, &servo), MBSR_ERR_ID, "acts on the ground");
    servo.kd = -1.0;
    refuse(mbsr_force_joint_servo(0, 0, &servo), MBSR_ERR_VALUE, "(kd) is -1, negative");
    servo = (mbsr_servo){.kp = 1.0, .limit = -2.0};
    refuse(mbsr_force_joint_servo(0, 0, &servo), MBSR_ERR_VALUE, "(limit) is -2, negative");
    servo = (mbsr_servo){.kp = NAN};
    refuse(mbsr_force_joint_servo(0, 0, &servo), MBSR_ERR_VALUE, "(kp) is nan");
    servo = (mbsr_servo){.kp = 1.0, .table = two};
    refuse(mbsr_force_joint_servo(0, 0, &servo), MBSR_ERR_VALUE, "2 columns, must have 1");
    refuse(mbsr_force_joint_curve(0, 0, two), MBSR_ERR_VALUE, "2 columns, must have 1");
    refuse(mbsr_force_joint_curve(0, 0, NULL), MBSR_ERR_NULL, "must be the table");
    refuse(mbsr_force_gear(0, 0, 1, 0, NULL), MBSR_ERR_NULL, "is NULL");
    refuse(mbsr_force_gear(0, 0, 1, 0, &gear), MBSR_ERR_SPACE, "body 1|nq = 4, n = 3");
    refuse(mbsr_force_gear(0, 0, 0, 0, &gear), MBSR_ERR_VALUE, "both coordinates are 0 of body 0");
    refuse(mbsr_force_gear(MBSR_GROUND, 0, 0, 0, &gear), MBSR_ERR_ID, "acts on the ground");
    gear.ratio = 0.0;
    refuse(mbsr_force_gear(0, 0, 0, 0, &gear), MBSR_ERR_VALUE, "both coordinates");
    mbsr_table_destroy(two);
}

/* ---- branches ---- */

/* In the play a gear has no branch; beyond it one for each side, and others where the damper would
 * pull or push more than the spring. */
static void branches_of_a_gear(void **state)
{
    static const struct {
        double e, rate, side;
    } at[] = {{0.0, 1.0, 0.0},  {0.05, 5.0, 0.0},  {0.2, 0.0, 1.0},    {-0.2, 0.0, -1.0},
              {0.2, 20.0, 2.0}, {0.2, -20.0, 3.0}, {-0.2, -20.0, -2.0}};
    const mbsr_gear gear = {.ratio = 2.0, .stiffness = 10.0, .damping = 0.1, .backlash = 0.2};
    mbsr_gear rigid = gear;
    rigid.backlash = 0.0;
    (void)state;
    for (size_t k = 0; k < sizeof at / sizeof *at; ++k) {
        const double q[2] = {at[k].e + 2.0 * 0.3, 0.3}, u[2] = {at[k].rate + 2.0 * 0.4, 0.4};
        const mbsr_force_body body[2] = {{.id = 0, .n = 1, .nq = 1, .q = q, .u = u},
                                         {.id = 1, .n = 1, .nq = 1, .q = q + 1, .u = u + 1}};
        for (int l = 0; l < 2; ++l) {
            const mbsr_force_def def = mbsr_force_gear(0, 0, 1, 0, l ? &rigid : &gear);
            const mbsr_force_args args = {.force = &def, .bodies = 2, .body = body};
            assert_true(def.table->side(&args) == (l ? 0.0 : at[k].side));
        }
    }
}

/* A characteristic changes where its table has a corner: the next one is its branch, infinity
 * behind the last. */
static void branches_of_a_characteristic(void **state)
{
    (void)state;
    mbsr_table *straight = make(MBSR_TABLE_LINEAR, 1);
    const mbsr_force_def def = mbsr_force_joint_curve(0, 0, straight);
    for (int k = 0; k < 2; ++k) {
        const double u = k == 0 ? 0.5 : 2.0;
        const mbsr_force_body body = {.id = 0, .n = 1, .nq = 1, .u = &u};
        const mbsr_force_args args = {.force = &def, .bodies = 1, .body = &body};
        assert_true(def.table->side(&args) == (k == 0 ? 1.0 : INFINITY));
    }
    mbsr_table_destroy(straight);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(servos_follow_references),
        cmocka_unit_test(branches_of_a_gear),
        cmocka_unit_test(branches_of_a_characteristic),
        cmocka_unit_test(characteristics_go_with_speed),
        cmocka_unit_test(gears_tie_two_coordinates),
        cmocka_unit_test(gears_balance_power),
        cmocka_unit_test(wrong_drives_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
