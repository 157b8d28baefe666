/* Consistent starts of small models with closures: what balances is taken as it is, what does not is named.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "body.h"

#include <mbsrank/mbsrank.h>

#include <math.h>

static const double tilt = 0.5;

static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 10.0 * t;
    *sdot = 10.0;
    *sddot = 0.0;
    return 0;
}

/* A driven shaft turns another by a universal joint, whose bearing has no mass: rows hold it across, rubber keeps
 * it from turning, with springs of 10 N m/rad and 0.1 N m s/rad. Lengths in `unit` of a metre. */
static mbsr_model *shafts(double unit, double stiffness)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                 com[3] = {0.0}, square = unit * unit,
                 moments[6] = {0.03 * square, 0.03 * square, 0.05 * square},
                 place[3] = {0.0, -0.4 * unit * sin(tilt), 0.4 * unit * cos(tilt)},
                 rubber[6] = {10.0 * square, 10.0 * square, 10.0 * square},
                 loss[6] = {0.1 * square, 0.1 * square, 0.1 * square},
                 across[6] = {1.0, 0.0, 0.0, 0.0, cos(tilt), sin(tilt)};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const mbsr_frame on_shaft = mbsr_frame_at(0.0, 0.0, 0.4 * unit),
                     tilted = mbsr_frame_turned(NULL, x, tilt),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int a = test_add_body(
        m, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL), mbsr_inertia_zero());
    const int b = test_add_body(m, a, mbsr_joint_universal(NULL, NULL, x, y),
                                mbsr_inertia_rigid(4.0, com, moments));
    const int c = test_add_body(m, b, mbsr_joint_revolute(&on_shaft, NULL, z), mbsr_inertia_zero());
    const mbsr_force_def bushing =
        mbsr_force_bushing(MBSR_GROUND, &on_ground, c, NULL, rubber, loss);
    assert_ok(mbsr_model_add_force(m, &bushing, NULL), mbsr_model_error(m));
    mbsr_closure_def rows = mbsr_closure_rows(c, NULL, MBSR_GROUND, place, 2, across);
    for (int k = 0; k < 2 && stiffness > 0.0; ++k) {
        rows.stiffness[k] = stiffness;
        rows.damping[k] = 1e-5 * stiffness;
    }
    assert_ok(mbsr_model_add_closure(m, &rows, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* In steady rotation no force acts at all, but for rounding; the start is what was given. */
static void a_start_without_forces(void **state)
{
    (void)state;
    static const double units[] = {1.0, 1e3, 1e-3};
    for (int k = 0; k < 6; ++k) {
        mbsr_model *m = shafts(units[k / 2], k % 2 ? 1e8 : 0.0);
        mbsr_data *d = NULL;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        double q[3] = {tilt, 0.0, 0.0}, u[3] = {0.0, -10.0 * sin(tilt), -10.0 * cos(tilt)}, y[16],
               yp[16];
        assert_true(mbsr_dae_size(m, MBSR_DAE_MOMENTUM) <= 16);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        for (int l = 0; l < 3; ++l) {
            assert_close(y[l], q[l], 1e-12);
            assert_close(y[6 + l], u[l], 1e-9);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* Turned by 0.2 rad the rubber's spring asks for 20 rad/s more. */
static void a_start_whose_rate_is_found(void **state)
{
    (void)state;
    mbsr_model *m = shafts(1.0, 0.0);
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[3] = {tilt, 0.0, 0.2}, u[3] = {0.0, -10.0 * sin(tilt), -10.0 * cos(tilt)}, y[16],
           yp[16];
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_close(y[8], u[2] - 20.0, 1e-6);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_start_without_forces),
                                       cmocka_unit_test(a_start_whose_rate_is_found)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
