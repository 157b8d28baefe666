/* Models without bodies or without coordinates, on every kind of root. Run with sanitizers this
 * finds reads beyond the root's pose and arithmetic on null pointers.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <stdlib.h>

typedef struct root_of {
    mbsr_space space;
    int d, np;
} root_of;

static const root_of roots[] = {{MBSR_SPACE_FIXED, 0, 0},   {MBSR_SPACE_POINT, 2, 2},
                                {MBSR_SPACE_PLANAR, 3, 3},  {MBSR_SPACE_SPATIAL, 6, 12},
                                {MBSR_SPACE_GENERAL, 1, 1}, {MBSR_SPACE_GENERAL, 4, 0}};
enum { ROOTS = sizeof roots / sizeof *roots };

/* Pose and velocity differ from zero where they are not a rotation. */
static int motion(void *user, double t, double *p, double *V, double *A)
{
    const root_of *root = user;
    (void)t;
    for (int k = root->np == 12 ? 9 : 0; k < root->np; ++k) p[k] = 0.5 + k;
    for (int k = 0; k < root->d; ++k) V[k] = A[k] = 0.1;
    return 0;
}

static mbsr_model *model_on(const root_of *root, int moving)
{
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m = NULL;
    if (root->space != MBSR_SPACE_FIXED) {
        def.root = mbsr_root_moving(root->space, root->d, root->np, moving ? motion : NULL,
                                    (void *)(uintptr_t)root);
    }
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    return m;
}

/* Everything that takes q and u, with arrays of no length; then the Newton solver. */
static void evaluate(const mbsr_model *m)
{
    static const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE, MBSR_DAE_INDEX1,
                                          MBSR_DAE_INVERSE_DYNAMICS};
    double none[1] = {7.0}, energy[2], pose[12], twist[6];
    mbsr_data *d = NULL;
    assert_int_equal(mbsr_model_nq(m), 0);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const mbsr_error *error = mbsr_data_error(d);
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, none, none, NULL, none), error);
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, none, none, none, NULL, none), error);
    assert_ok(mbsr_stage_positions(m, d, 0.0, none), error);
    assert_ok(mbsr_stage_velocities(m, d, none), error);
    assert_ok(mbsr_energy(m, d, energy, energy + 1), error);
    assert_true(isfinite(energy[0]) && isfinite(energy[1]));
    assert_ok(mbsr_body_pose(m, d, MBSR_GROUND, pose), error);
    assert_ok(mbsr_body_twist(m, d, MBSR_GROUND, twist), error);
    assert_ok(mbsr_stage_forces(m, d, NULL), error);
    assert_ok(mbsr_stage_backward(m, d), error);
    for (int f = 0; f < 4; ++f) {
        assert_int_equal(mbsr_dae_size(m, forms[f]), 0);
        assert_ok(mbsr_dae_pack(m, d, forms[f], 0.0, none, none, none), error);
        assert_ok(mbsr_dae_consistent(m, d, forms[f], 0.0, none, none, NULL, NULL), error);
        assert_ok(mbsr_dae_residual(m, d, forms[f], 0.0, none, none, none), error);
    }
    mbsr_index_report *report = NULL;
    assert_ok(mbsr_index_report_create(m, d, 0.0, none, none, &report), error);
    assert_int_equal(report->directions, 0);
    mbsr_index_report_destroy(m, report);
    for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        mbsr_newton *newton = NULL;
        opt.by_blocks = by_blocks;
        assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
        assert_ok(mbsr_newton_factor(newton, d, 0.0, none, none, 10.0), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, none, none), mbsr_newton_error(newton));
        mbsr_newton_destroy(newton);
    }
    assert_true(none[0] == 7.0);
    mbsr_data_destroy(d);
}

static void without_bodies(void **state)
{
    (void)state;
    for (int k = 0; k < 2 * ROOTS; ++k) {
        for (int gravity = 0; gravity < 2; ++gravity) {
            mbsr_model *m = model_on(roots + k / 2, k % 2);
            const mbsr_force_def force = mbsr_force_gravity(0.0, 0.0, -9.81);
            if (gravity) assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
            assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
            assert_int_equal(mbsr_model_bodies(m), 0);
            evaluate(m);
            mbsr_model_destroy(m);
        }
    }
}

static int stay(const mbsr_joint_args *args, double *p)
{
    for (int k = 0; k < args->np; ++k) p[k] = 0.0;
    return 0;
}

static int nothing(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)args, (void)K, (void)H, (void)J, (void)kI;
    return 0;
}

static int no_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static int no_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)args, (void)Kdot, (void)Hdot, (void)Jdot;
    return 0;
}

static const mbsr_joint_table held = {.version = MBSR_JOINT_TABLE_VERSION,
                                      .flags = MBSR_JOINT_UNIT_K,
                                      .name = "held",
                                      .position = stay,
                                      .jacobians = nothing,
                                      .bias = no_bias,
                                      .rates = no_rates};

/* Bodies that are welded, by a stock joint or by one without any parameter. */
static void without_coordinates(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        mbsr_model *m = model_on(roots, 0);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_weld(NULL, NULL);
        if (k % 2) {
            body.joint = mbsr_joint_custom(&held, 2, 0, NULL);
            body.joint.params = 0;
        }
        for (int i = 0; i <= k / 2; ++i) {
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
            if (k % 2 == 0) body.parent = i;
        }
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        evaluate(m);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_bodies),
        cmocka_unit_test(without_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
