/* The index-1 form where bases of two and more dimensions turn: the driver takes a new reference
 * and starts anew by itself.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A plate without mass may move freely in the plane, held by springs and dampers along x, y and the
 * angle. A rod hangs on it off centre, with a particle at its end: of the plate's three directions
 * one has inertia, the one along the rod, and it turns with the rod. */
#include "expect.h"

#include <mbsrank/ida.h>

typedef struct plate {
    mbsr_model *model;
    mbsr_data *data;
} plate;

static plate make(void)
{
    plate s;
    assert_ok(mbsr_model_create(NULL, &s.model, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "plate";
    body.joint = mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    body.name = "rod";
    body.parent = 0;
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0.3, 0.1, 0.0},
                                            (mbsr_planar_frame){0.0, 1.0, 0.0});
    body.inertia = mbsr_inertia_particle(1.0);
    assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    const double stiffness[3] = {100.0, 120.0, 40.0}, damping[3] = {5.0, 6.0, 2.0};
    for (int axis = 0; axis < 3; ++axis) {
        const mbsr_force_def spring =
            mbsr_force_axis_spring(0, MBSR_GROUND, axis, stiffness[axis], damping[axis], 0.0);
        assert_ok(mbsr_model_add_force(s.model, &spring, NULL), mbsr_model_error(s.model));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(s.model, &gravity, NULL), mbsr_model_error(s.model));
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_ok(mbsr_data_create(s.model, &s.data, NULL), NULL);
    return s;
}

/* Motion from theta = 2, theta' = 6 rad/s to t_end in `parts` outputs; q (4) is the end. */
static void swing(mbsr_dae_form form, double tolerance, int parts, double *q, mbsr_ida_stats *stats)
{
    plate s = make();
    const double q0[4] = {0.0, 0.0, 0.0, 2.0}, u0[4] = {0.0, 0.0, 0.0, 6.0};
    double y[12], yp[12], u[4];
    assert_ok(mbsr_dae_pack(s.model, s.data, form, 0.0, q0, u0, y), mbsr_data_error(s.data));
    assert_ok(mbsr_dae_consistent(s.model, s.data, form, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(s.data));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    opt.rtol = opt.atol = tolerance;
    mbsr_ida *ida;
    assert_ok(mbsr_ida_create(s.model, s.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    for (int k = 1; k <= parts; ++k) {
        assert_ok(mbsr_ida_advance(ida, 5.0 * k / parts, NULL, y, NULL), mbsr_ida_error(ida));
    }
    assert_int_equal(mbsr_ida_get_stats(ida, stats), MBSR_OK);
    assert_ok(mbsr_dae_unpack(s.model, s.data, form, 5.0, y, q, u), mbsr_data_error(s.data));
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

static void it_moves_as_in_the_momentum_form(void **state)
{
    (void)state;
    const double tolerance[] = {1e-6, 1e-8};
    double reference[4];
    mbsr_ida_stats stats;
    swing(MBSR_DAE_MOMENTUM, 1e-11, 1, reference, &stats);
    for (int k = 0; k < 2; ++k) {
        double momentum[4], index1[4];
        mbsr_ida_stats one;
        swing(MBSR_DAE_MOMENTUM, tolerance[k], 1, momentum, &stats);
        swing(MBSR_DAE_INDEX1, tolerance[k], 1, index1, &one);
        print_message("tolerance %.0e: momentum %ld steps, index 1 %ld steps\n", tolerance[k],
                      stats.steps, one.steps);
        for (int c = 0; c < 4; ++c) {
            assert_close(momentum[c], reference[c], 1000.0 * tolerance[k]);
            assert_close(index1[c], reference[c], 1000.0 * tolerance[k]);
        }
        /* each new start costs steps, but not many times the motion */
        assert_true(one.steps < 3 * stats.steps);
        assert_true(one.steps <= one.newton_iterations);
    }
}

/* Where the reference is renewed is a root that IDA brackets by output times too: its place differs
 * by rounding, the steps do not. */
static void output_does_not_change_the_steps(void **state)
{
    (void)state;
    double once[4], often[4];
    mbsr_ida_stats a, b;
    swing(MBSR_DAE_INDEX1, 1e-6, 1, once, &a);
    swing(MBSR_DAE_INDEX1, 1e-6, 50, often, &b);
    assert_int_equal(a.steps, b.steps);
    for (int c = 0; c < 4; ++c) assert_close(often[c], once[c], 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_moves_as_in_the_momentum_form),
        cmocka_unit_test(output_does_not_change_the_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
