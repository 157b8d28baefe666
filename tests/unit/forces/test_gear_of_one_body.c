/* Gears and couplings between two coordinates of one body's joint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "tree.h"

#include <mbsrank/verify.h>
#include <mbsrank/newton.h>

#include <stdbool.h>

static const mbsr_gear teeth = {.ratio = 1.5, .stiffness = 30.0, .damping = 2.0, .rest = 0.1};

static int add(mbsr_model *m, int parent, mbsr_joint joint)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = -1;
    body.parent = parent;
    body.joint = joint;
    body.inertia = mbsr_inertia_box(800.0, (const double[3]){0.1, 0.2, 0.3});
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

/* A hinge, a universal joint with the gear between its axes, a hinge. */
static mbsr_model *make(bool as_closure)
{
    static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame at = mbsr_frame_at(0.1, 0.0, 0.3);
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    add(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, y));
    add(m, 0, mbsr_joint_universal(&at, NULL, x, y));
    add(m, 1, mbsr_joint_revolute(&at, NULL, z));
    mbsr_force_def gear = mbsr_force_gear(1, 0, 1, 1, &teeth);
    gear.as_closure = as_closure;
    assert_ok(mbsr_model_add_force(m, &gear, NULL), mbsr_model_error(m));
    return m;
}

static void it_acts_on_both_coordinates(void **state)
{
    (void)state;
    const double q[4] = {0.2, 0.5, -0.3, 0.4}, u[4] = {0.3, -0.2, 0.7, 0.1}, none[4] = {0.0};
    double with[4], f[6], tau[2], E, P;
    mbsr_model *m = make(false);
    mbsr_data *d = NULL;
    mbsr_force_errors errors;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const double e = q[1] - 1.5 * q[2] - 0.1, rate = u[1] - 1.5 * u[2], T = 30.0 * e + 2.0 * rate;
    double without[4];
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, none, NULL, with), mbsr_data_error(d));
    assert_ok(mbsr_force_load(m, d, 0, 0, f, tau), mbsr_data_error(d));
    assert_ok(mbsr_force_power(m, d, 0, &E, &P), mbsr_data_error(d));
    assert_close(E, 15.0 * e * e, 1e-13);
    assert_close(P, 2.0 * rate * rate, 1e-13);
    assert_close(tau[0], -T, 1e-13);
    assert_ok(mbsr_force_load(m, d, 0, 1, f, tau), mbsr_data_error(d));
    assert_close(tau[1], 1.5 * T, 1e-13);
    assert_ok(mbsr_force_verify(m, d, 0, &errors), mbsr_data_error(d));
    assert_true(errors.largest < 1e-6);
    assert_ok(mbsr_force_switch(m, d, 0, 0), mbsr_data_error(d));
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, none, NULL, without), mbsr_data_error(d));
    assert_close(with[1] - without[1], T, 1e-12);
    assert_close(with[2] - without[2], -1.5 * T, 1e-12);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* F(y + h delta, y' + c h delta) - F is h times the right-hand side, by the sweeps and by blocks.
 */
static void newton_systems_have_it(void **state)
{
    (void)state;
    enum { SIZE = 12 };
    const double q[4] = {0.2, 0.5, -0.3, 0.4}, u[4] = {0.3, -0.2, 0.7, 0.1}, c = 15.0, h = 1e-6;
    for (int blocks = 0; blocks < 2; ++blocks) {
        double y[SIZE], yp[SIZE], r[SIZE], delta[SIZE], F[2][SIZE], yh[SIZE], yph[SIZE];
        mbsr_model *m = make(false);
        mbsr_data *d = NULL;
        mbsr_newton *w = NULL;
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        opt.by_blocks = blocks;
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        for (int k = 0; k < SIZE; ++k) r[k] = cos(2.0 * k);
        assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &w, NULL), NULL);
        assert_ok(mbsr_newton_factor(w, d, 0.0, y, yp, c), mbsr_data_error(d));
        assert_ok(mbsr_newton_solve(w, r, delta), mbsr_data_error(d));
        for (int side = 0; side < 2; ++side) {
            const double step = side ? h : -h;
            for (int k = 0; k < SIZE; ++k) {
                yh[k] = y[k] + step * delta[k];
                yph[k] = yp[k] + c * step * delta[k];
            }
            assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, yh, yph, F[side]),
                      mbsr_data_error(d));
        }
        for (int k = 0; k < SIZE; ++k) assert_close((F[1][k] - F[0][k]) / (2.0 * h), r[k], 1e-6);
        mbsr_newton_destroy(w);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* As a closure the gear is a row on the two, whose forces are as the gear's. */
static void it_may_be_a_closure(void **state)
{
    (void)state;
    const double q[4] = {0.2, 0.5, -0.3, 0.4}, u[4] = {0.3, -0.2, 0.7, 0.1};
    double udot[2][4];
    for (int k = 0; k < 2; ++k) {
        mbsr_model *m = make(k == 1);
        mbsr_data *d = NULL;
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_int_equal(mbsr_model_rows(m), k);
        assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot[k]), mbsr_data_error(d));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    for (int k = 0; k < 4; ++k) assert_close(udot[1][k], udot[0][k], 1e-10);
}

static void a_coupling_of_two_axes_holds(void **state)
{
    (void)state;
    const int body[2] = {1, 1}, coordinate[2] = {0, 1};
    const double factor[2] = {1.0, -1.5};
    const double q[4] = {0.2, 0.6, 0.4, 0.4}, u[4] = {0.3, 0.3, 0.2, 0.1};
    double udot[4], tau[4], lambda[2];
    mbsr_model *m = make(false), *open = make(false);
    mbsr_data *d = NULL, *other = NULL;
    const mbsr_closure_def coupling = mbsr_closure_coupling(2, body, coordinate, factor, 0.0);
    assert_ok(mbsr_model_add_closure(m, &coupling, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(open), mbsr_model_error(open));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_data_create(open, &other, NULL), NULL);
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot), mbsr_data_error(d));
    assert_close(udot[1] - 1.5 * udot[2], 0.0, 1e-11);
    assert_ok(mbsr_closures_lambda(m, d, lambda), mbsr_data_error(d));
    assert_ok(mbsr_inverse_dynamics(open, other, 0.0, q, u, udot, NULL, tau),
              mbsr_data_error(other));
    assert_close(tau[0], 0.0, 1e-10);
    assert_close(tau[1], lambda[0], 1e-10);
    assert_close(tau[2], -1.5 * lambda[0], 1e-10);
    assert_close(tau[3], 0.0, 1e-10);
    mbsr_data_destroy(d);
    mbsr_data_destroy(other);
    mbsr_model_destroy(m);
    mbsr_model_destroy(open);
}

static void one_coordinate_with_itself_is_refused(void **state)
{
    (void)state;
    mbsr_model *m = make(false);
    const mbsr_force_def gear = mbsr_force_gear(1, 1, 1, 1, &teeth);
    assert_ok(mbsr_model_add_force(m, &gear, NULL), mbsr_model_error(m));
    assert_refused(mbsr_model_finish(m), mbsr_model_error(m), MBSR_ERR_VALUE, -2, 1,
                   "gear|both coordinates are 1 of body 1");
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_acts_on_both_coordinates),
        cmocka_unit_test(newton_systems_have_it),
        cmocka_unit_test(it_may_be_a_closure),
        cmocka_unit_test(a_coupling_of_two_axes_holds),
        cmocka_unit_test(one_coordinate_with_itself_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
