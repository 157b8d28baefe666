/* Rods on and beside the axes of joints: no mass where by reasoning there is none, in any position and
 * system of units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <math.h>

/* Length and mass in units of metres and kilograms: SI; mm, t; km, kg; mm, g. */
static const double units[4][2] = {{1.0, 1.0}, {1e3, 1e-3}, {1e-3, 1.0}, {1e3, 1e3}};

static int add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = MBSR_NONE;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static mbsr_model *begin(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

/* Rank of the first joint by the stages. */
static int rank_of(const mbsr_model *m, mbsr_data *d, const double *q, const double *u)
{
    mbsr_rank_info info;
    assert_ok(mbsr_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_backward(m, d), mbsr_data_error(d));
    assert_ok(mbsr_body_rank(m, d, 0, &info), mbsr_data_error(d));
    return info.rank;
}

/* A rod from the origin to p, tilted from z by `tilt`, turns about itself or about z; with `carried` it is
 * fixed to a body without mass that does. */
static void try_rod(const double unit[2], double tilt, int beside, int carried)
{
    const double length = unit[0], mass = 2.0 * unit[1], origin[3] = {0.0, 0.0, 0.0},
                 p[3] = {0.3 * tilt * length, 0.4 * tilt * length, 0.7 * length},
                 z[3] = {0.0, 0.0, length};
    const mbsr_inertia rod = mbsr_inertia_rod(mass, origin, p);
    const mbsr_joint joint = mbsr_joint_revolute(NULL, NULL, beside ? z : p);
    mbsr_model *m = begin();
    const int first = add(m, MBSR_GROUND, joint, carried ? mbsr_inertia_zero() : rod);
    if (carried) add(m, first, mbsr_joint_weld(NULL, NULL), rod);
    mbsr_data *d = finish(m);
    const double moment = mass * (p[0] * p[0] + p[1] * p[1]) / 3.0;
    for (int k = 0; k < 12; ++k) {
        const double q = 0.55 * k, u = 0.0, tau = moment;
        double udot = 0.0;
        const int status = mbsr_forward_dynamics(m, d, 0.0, &q, &u, &tau, &udot);
        if (beside) {
            assert_ok(status, mbsr_data_error(d));
            assert_close(udot, 1.0, 1e-4);
        } else {
            assert_int_equal(status, MBSR_UNDETERMINED);
        }
        assert_int_equal(rank_of(m, d, &q, &u), beside);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void a_rod_has_no_moment_about_itself(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        for (double tilt = 1.0; tilt > 0.5e-9; tilt *= 0.1) {
            for (int carried = 0; carried < 2; ++carried) {
                try_rod(units[k], tilt, 0, carried);
                if (tilt > 0.5e-5) try_rod(units[k], tilt, 1, carried);
            }
        }
    }
}

/* Two of three rotations of a rod on a ball joint move it, wherever it points. */
static void a_rod_on_a_ball_joint(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        for (double tilt = 1.0; tilt > 0.5e-9; tilt *= 0.1) {
            const double l = units[k][0], origin[3] = {0.0, 0.0, 0.0},
                         p[3] = {0.3 * tilt * l, 0.4 * tilt * l, 0.7 * l};
            mbsr_model *m = begin();
            add(m, MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                mbsr_inertia_rod(2.0 * units[k][1], origin, p));
            mbsr_data *d = finish(m);
            for (int turn = 0; turn < 12; ++turn) {
                const double q[4] = {cos(0.3 * turn), sin(0.3 * turn), 0.0, 0.1 * turn},
                             u[3] = {0.0, 0.0, 0.0};
                assert_int_equal(rank_of(m, d, q, u), 2);
            }
            mbsr_data_destroy(d);
            mbsr_model_destroy(m);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rod_has_no_moment_about_itself),
        cmocka_unit_test(a_rod_on_a_ball_joint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
