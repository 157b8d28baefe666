/* Constructors with NULL in each of their pointer arguments: what it means, or that it is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

static const double e_x[3] = {1, 0, 0}, e_y[3] = {0, 1, 0};
static const double tensor[6] = {1.0, 1.1, 1.2, 0.1, 0.05, 0.02}, com[3] = {0.1, 0.2, -0.1};
static const double origin[3] = {0.0, 0.0, 0.0};
static const mbsr_planar_frame flat = {0.1, 0.2, 0.3};

static mbsr_model *two_bodies(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_spherical(NULL, NULL);
        body.inertia = mbsr_inertia_sphere(1000.0, 0.1);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    return m;
}

/* status of adding a body, whose text contains the words; MBSR_OK: it finishes too. */
static void expect_body(mbsr_joint joint, mbsr_inertia inertia, int status, const char *words)
{
    mbsr_model *m = two_bodies();
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = joint;
    body.inertia = inertia;
    const int result = mbsr_model_add_body(m, &body, NULL);
    if (status)
        assert_refused(result, mbsr_model_error(m), status, 2, MBSR_NONE, words);
    else
        assert_ok(result, mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_model_bodies(m), status ? 2 : 3);
    mbsr_model_destroy(m);
}

static void expect_joint(mbsr_joint joint, int status, const char *words)
{
    expect_body(joint, mbsr_inertia_zero(), status, words);
}

static void expect_inertia(mbsr_inertia inertia, int status, const char *words)
{
    expect_body(mbsr_joint_free(NULL, NULL), inertia, status, words);
}

static void expect_force(mbsr_force_def force, int status, const char *words)
{
    mbsr_model *m = two_bodies();
    const int result = mbsr_model_add_force(m, &force, NULL);
    if (status)
        assert_refused(result, mbsr_model_error(m), status, MBSR_NONE, 0, words);
    else
        assert_ok(result, mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_model_destroy(m);
}

static void joints(void **state)
{
    (void)state;
    const int wrong = MBSR_ERR_VALUE;
    const char *zero = "direction of axis 0 has length 0";
    expect_joint(mbsr_joint_weld(NULL, NULL), MBSR_OK, "");
    expect_joint(mbsr_joint_revolute(NULL, NULL, NULL), wrong, zero);
    expect_joint(mbsr_joint_prismatic(NULL, NULL, NULL), wrong, zero);
    expect_joint(mbsr_joint_screw(NULL, NULL, NULL, 0.1), wrong, zero);
    expect_joint(mbsr_joint_cylindrical(NULL, NULL, NULL), wrong, zero);
    expect_joint(mbsr_joint_universal(NULL, NULL, NULL, e_y), wrong, zero);
    expect_joint(mbsr_joint_universal(NULL, NULL, e_x, NULL), wrong, "axis 1 has length 0");
    expect_joint(mbsr_joint_in_plane(NULL, NULL), MBSR_OK, "");
    expect_joint(mbsr_joint_translational(NULL, NULL), MBSR_OK, "");
    expect_joint(mbsr_joint_compound(NULL, NULL, 0, NULL, NULL, NULL), MBSR_OK, "");
    expect_joint(mbsr_joint_compound(NULL, NULL, 3, NULL, NULL, NULL), MBSR_ERR_NULL,
                 "joint 'compound': axes is NULL");
    const mbsr_axis driven = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    expect_joint(mbsr_joint_compound(NULL, NULL, 1, &driven, NULL, NULL), wrong, "motion is NULL");
    expect_joint(mbsr_joint_planar(flat, flat, MBSR_X, MBSR_Y, NULL, NULL), wrong,
                 "motion is NULL");
    expect_joint(mbsr_joint_point(flat, MBSR_X, MBSR_Y, NULL, NULL), wrong, "motion is NULL");
    expect_joint(mbsr_joint_custom(NULL, 1, 1, NULL), wrong, "table is NULL");
}

static void inertias(void **state)
{
    (void)state;
    const mbsr_frame frame = mbsr_frame_at(1.0, 2.0, 3.0);
    const int wrong = MBSR_ERR_VALUE;
    const char *from_null = "from NULL";
    expect_inertia(mbsr_inertia_rigid(1.0, NULL, tensor), MBSR_OK, "");
    expect_inertia(mbsr_inertia_rigid(1.0, com, NULL), wrong, from_null);
    expect_inertia(mbsr_inertia_rigid_unchecked(1.0, NULL, tensor), MBSR_OK, "");
    expect_inertia(mbsr_inertia_rigid_unchecked(1.0, com, NULL), wrong, from_null);
    expect_inertia(mbsr_inertia_rigid_about(1.0, NULL, NULL, tensor), MBSR_OK, "");
    expect_inertia(mbsr_inertia_rigid_about(1.0, com, &frame, NULL), wrong, from_null);
    expect_inertia(mbsr_inertia_point_mass(1.0, NULL), MBSR_OK, "");
    expect_inertia(mbsr_inertia_rod(1.0, NULL, e_x), MBSR_OK, "");
    expect_inertia(mbsr_inertia_rod(1.0, e_x, NULL), MBSR_OK, "");
    expect_inertia(mbsr_inertia_box(1000.0, NULL), wrong, from_null);
    expect_inertia(mbsr_inertia_in_frame(NULL, mbsr_inertia_particle(1.0)), MBSR_OK, "");
    expect_inertia(mbsr_inertia_matrix(6, NULL), MBSR_ERR_NULL, "matrix is NULL");
    expect_inertia(mbsr_inertia_function(NULL, NULL), MBSR_ERR_NULL, "function is NULL");
    expect_body(mbsr_joint_planar_free(flat, flat), mbsr_inertia_planar(1.0, NULL, 0.5), MBSR_OK,
                "");
    /* NULL is the origin */
    const mbsr_inertia rod = mbsr_inertia_rod(2.0, NULL, e_x),
                       same = mbsr_inertia_rod(2.0, origin, e_x),
                       rigid = mbsr_inertia_rigid(2.0, NULL, tensor),
                       about = mbsr_inertia_rigid_about(2.0, NULL, &frame, tensor),
                       as_about = mbsr_inertia_rigid_about(2.0, origin, &frame, tensor);
    assert_memory_equal(rod.com, same.com, sizeof rod.com);
    assert_memory_equal(rod.tensor, same.tensor, sizeof rod.tensor);
    assert_memory_equal(rigid.com, origin, sizeof origin);
    assert_memory_equal(about.tensor, as_about.tensor, sizeof about.tensor);
    assert_memory_equal(mbsr_inertia_planar(1.0, NULL, 0.5).com, origin, sizeof origin);
}

static void forces(void **state)
{
    (void)state;
    static const double six[6] = {1, 2, 3, 4, 5, 6};
    expect_force(mbsr_force_spring(0, NULL, 1, NULL, NULL), MBSR_ERR_NULL, "NULL");
    expect_force(mbsr_force_point_spring(0, NULL, 1, NULL, 1.0, 0.1, 0.2), MBSR_OK, "");
    expect_force(mbsr_force_bushing(0, NULL, 1, NULL, six, NULL), MBSR_OK, "");
    expect_force(mbsr_force_bushing(0, NULL, 1, NULL, NULL, six), MBSR_OK, "");
    expect_force(mbsr_force_contact(0, 1, NULL), MBSR_ERR_NULL, "NULL");
    expect_force(mbsr_force_point_friction(0, NULL, 1, NULL), MBSR_ERR_NULL, "NULL");
    expect_force(mbsr_force_bearing_friction(0, 1, NULL), MBSR_ERR_NULL, "NULL");
    expect_force(mbsr_force_applied(0, NULL, NULL), MBSR_ERR_NULL, "function is NULL");
    expect_force(mbsr_force_joint_applied(0, NULL, NULL), MBSR_ERR_NULL, "function is NULL");
    expect_force(mbsr_force_wrench(0, NULL, 0, NULL, NULL), MBSR_ERR_NULL, "function is NULL");
    expect_force(mbsr_force_joint_applied(0, mbsr_stored_force, NULL), MBSR_ERR_NULL,
                 "user is NULL, must be the numbers stored");
    expect_force(mbsr_force_joint_rotation_spring(0, NULL, NULL, NULL), MBSR_OK, "");
    expect_force(mbsr_force_custom(NULL, 0, NULL, NULL), MBSR_ERR_VALUE, "table is NULL");
    expect_force(mbsr_force_custom(mbsr_force_applied(0, NULL, NULL).table, 1, NULL, NULL),
                 MBSR_ERR_ID, "neither a body nor MBSR_GROUND");
    for (int k = 0; k < 12; ++k)
        assert_true(mbsr_force_bushing(0, NULL, 1, NULL, NULL, NULL).param[18 + k] == 0.0);
}

static void frames(void **state)
{
    (void)state;
    const mbsr_frame a = mbsr_frame_rotated(e_y, e_x, 0.3), same = mbsr_frame_identity();
    const mbsr_frame none[] = {mbsr_frame_rotated(e_x, NULL, 0.3), mbsr_frame_along(e_x, NULL),
                               mbsr_frame_quaternion(e_x, NULL)};
    for (int k = 0; k < 3; ++k) {
        expect_joint(mbsr_joint_weld(none + k, NULL), MBSR_ERR_VALUE, "axes of frame A");
        expect_inertia(mbsr_inertia_in_frame(none + k, mbsr_inertia_particle(1.0)), MBSR_ERR_VALUE,
                       "not orthonormal");
    }
    mbsr_frame c = mbsr_frame_product(&a, NULL);
    assert_memory_equal(&c, &a, sizeof a);
    c = mbsr_frame_product(NULL, &a);
    assert_memory_equal(&c, &a, sizeof a);
    c = mbsr_frame_inverse(NULL);
    assert_memory_equal(&c, &same, sizeof same);
    double R[9], quaternion[4];
    const double nowhere[4] = {0.0}, wild[4] = {1.0, NAN, 0.0, 0.0};
    assert_int_equal(mbsr_quaternion_rotation(NULL, R), MBSR_ZERO_QUATERNION);
    for (int k = 0; k < 9; ++k) assert_true(R[k] == 0.0);
    assert_int_equal(mbsr_quaternion_rotation(nowhere, R), MBSR_ZERO_QUATERNION);
    assert_int_equal(mbsr_quaternion_rotation(nowhere, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_quaternion_rotation(wild, R), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_rotation_quaternion(R, quaternion), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_rotation_quaternion(NULL, quaternion), MBSR_ERR_NULL);
    assert_int_equal(mbsr_rotation_quaternion(R, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_quaternion_rotation((const double[4]){0.0, 3.0, 0.0, 0.0}, R), MBSR_OK);
    assert_int_equal(mbsr_rotation_quaternion(R, quaternion), MBSR_OK);
    assert_true(quaternion[1] == 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints),
        cmocka_unit_test(inertias),
        cmocka_unit_test(forces),
        cmocka_unit_test(frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
