/* The parts of a finished model make the same model again; joints in space are told by their axes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "loops.h"
#include "mixed.h"

/* Another model of the same parts, in the order of their ids. */
static mbsr_model *rebuilt(const mbsr_model *m, const mbsr_root *root)
{
    mbsr_model_def model = mbsr_default_model_def();
    mbsr_model *to;
    mbsr_body_def body;
    mbsr_force_def force;
    mbsr_closure_def closure;
    if (root) model.root = *root;
    assert_ok(mbsr_model_create(&model, &to, NULL), NULL);
    for (int k = 0; k < mbsr_model_bodies(m); ++k) {
        assert_ok(mbsr_body_definition(m, k, &body), NULL);
        assert_ok(mbsr_model_add_body(to, &body, NULL), mbsr_model_error(to));
        assert_ok(mbsr_model_armature(to, k, body.joint.n, mbsr_body_armature(m, k)),
                  mbsr_model_error(to));
    }
    for (int k = 0; k < mbsr_model_forces(m); ++k) {
        assert_ok(mbsr_force_definition(m, k, &force), NULL);
        assert_ok(mbsr_model_add_force(to, &force, NULL), mbsr_model_error(to));
    }
    for (int k = 0; k < mbsr_model_closures(m); ++k) {
        assert_ok(mbsr_closure_definition(m, k, &closure), NULL);
        assert_ok(mbsr_model_add_closure(to, &closure, NULL), mbsr_model_error(to));
    }
    assert_ok(mbsr_model_finish(to), mbsr_model_error(to));
    return to;
}

static void assert_same_dynamics(const mbsr_model *a, const mbsr_model *b)
{
    enum { MOST = 64 };
    const mbsr_model *m[2] = {a, b};
    double q[MOST], u[MOST], udot[MOST], tau[2][MOST] = {{0.0}};
    test_rng rng = test_seed(7);
    assert_int_equal(mbsr_model_nq(a), mbsr_model_nq(b));
    assert_in_range(mbsr_model_nq(a), 1, MOST);
    test_fill(&rng, mbsr_model_nq(a), q);
    test_fill(&rng, mbsr_model_nu(a), u);
    test_fill(&rng, mbsr_model_nu(a), udot);
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        assert_ok(mbsr_data_create(m[k], &d, NULL), NULL);
        assert_ok(mbsr_inverse_dynamics(m[k], d, 0.3, q, u, udot, NULL, tau[k]),
                  mbsr_data_error(d));
        mbsr_data_destroy(d);
    }
    assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
}

static void parts_make_the_same_tree(void **unused)
{
    (void)unused;
    mixed s;
    mixed_make(&s, MIXED_ARM);
    mbsr_model *again = rebuilt(s.model, NULL);
    for (int k = 0; k < s.bodies; ++k)
        assert_string_equal(mbsr_body_name(s.model, k), mbsr_body_name(again, k));
    assert_same_dynamics(s.model, again);
    mbsr_model_destroy(again);
    mixed_free(&s);
}

static void parts_make_the_same_loop(void **unused)
{
    (void)unused;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "coupler", a, 1.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.0, 0.0, MBSR_GROUND, 2.0, 0.5);
    loops_finish(&s);
    mbsr_model *again = rebuilt(s.m, NULL);
    assert_int_equal(mbsr_model_rows(again), mbsr_model_rows(s.m));
    assert_string_equal(mbsr_closure_name(again, 0), "pin");
    assert_same_dynamics(s.m, again);
    mbsr_model_destroy(again);
    loops_free(&s);
}

/* Three springs on bodies in an order that is not that of the sweeps: each keeps its body. */
static void elements_keep_their_bodies(void **unused)
{
    (void)unused;
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) { /* 2 carries 1 carries 0 */
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k < 2 ? k + 1 : MBSR_GROUND;
        body.joint = mbsr_joint_revolute(NULL, NULL, (const double[3]){0.0, 1.0, 0.0});
        body.inertia = mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 10.0 + k, 0.0, 0.0);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    for (int k = 0; k < 3; ++k) {
        mbsr_force_def force;
        assert_ok(mbsr_force_definition(m, k, &force), NULL);
        assert_int_equal(force.bodies, 1);
        assert_int_equal(force.body[0], k);
        assert_close(force.param[0], 10.0 + k, 0.0);
    }
    mbsr_model *again = rebuilt(m, NULL);
    assert_same_dynamics(m, again);
    mbsr_model_destroy(again);
    mbsr_model_destroy(m);
}

static void joints_in_space_are_told_by_their_axes(void **unused)
{
    (void)unused;
    const mbsr_frame A = mbsr_frame_rotated((const double[3]){1.0, 2.0, 3.0},
                                            (const double[3]){0.0, 0.6, 0.8}, 0.4),
                     B = mbsr_frame_at(0.0, -1.0, 0.5);
    const double axis[3] = {0.0, 3.0, 4.0};
    mbsr_joint_chain c;
    mbsr_joint joint = mbsr_joint_screw(&A, &B, axis, 0.2);
    assert_int_equal(mbsr_joint_chain_of(&joint, &c), MBSR_OK);
    assert_int_equal(c.axes, 1);
    assert_int_equal(c.quaternion, 0);
    assert_int_equal(c.axis[0].kind, MBSR_AXIS_SCREW);
    assert_close(c.axis[0].direction[2], 0.8, 1e-15);
    assert_close(c.axis[0].pitch, 0.2, 0.0);
    for (int k = 0; k < 9; ++k) assert_close(c.A.R[k], A.R[k], 1e-15);
    for (int k = 0; k < 3; ++k) assert_close(c.B.x[k], B.x[k], 0.0);
    const mbsr_joint same = mbsr_joint_screw(&c.A, &c.B, c.axis[0].direction, c.axis[0].pitch);
    for (int k = 0; k < 28; ++k) assert_close(same.param[k], joint.param[k], 1e-15);

    joint = mbsr_joint_free(&A, NULL);
    assert_int_equal(mbsr_joint_chain_of(&joint, &c), MBSR_OK);
    assert_int_equal(c.axes, 3);
    assert_int_equal(c.quaternion, 1);
    assert_int_equal(c.axis[2].kind, MBSR_AXIS_TRANSLATION);

    joint = mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    assert_int_equal(mbsr_joint_chain_of(&joint, &c), MBSR_ERR_SPACE);
    joint = mbsr_joint_revolute(&A, &B, NULL);
    assert_int_equal(mbsr_joint_chain_of(&joint, &c), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_joint_chain_of(NULL, &c), MBSR_ERR_NULL);
    assert_int_equal(mbsr_joint_chain_of(&joint, NULL), MBSR_ERR_NULL);
}

static void wrong_calls_are_refused(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_body_def body;
    mbsr_force_def force;
    mbsr_closure_def closure;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_int_equal(mbsr_body_definition(m, 0, &body), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_force_definition(m, 0, &force), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_closure_definition(m, 0, &closure), MBSR_ERR_UNFINISHED);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_body_definition(m, 0, &body), MBSR_ERR_ID);
    assert_int_equal(mbsr_body_definition(m, MBSR_GROUND, &body), MBSR_ERR_ID);
    assert_int_equal(mbsr_force_definition(m, 0, &force), MBSR_ERR_ID);
    assert_int_equal(mbsr_closure_definition(m, 0, &closure), MBSR_ERR_ID);
    assert_int_equal(mbsr_body_definition(NULL, 0, &body), MBSR_ERR_NULL);
    assert_int_equal(mbsr_body_definition(m, 0, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_force_definition(m, 0, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_closure_definition(m, 0, NULL), MBSR_ERR_NULL);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_make_the_same_tree),
        cmocka_unit_test(parts_make_the_same_loop),
        cmocka_unit_test(elements_keep_their_bodies),
        cmocka_unit_test(joints_in_space_are_told_by_their_axes),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
