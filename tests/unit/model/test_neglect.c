/* Copies of models, and masses that count as zero.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "loops.h"
#include "mixed.h"

#include <stdlib.h>

/* Residuals and inverse dynamics of both at a state are the same numbers, bit for bit. */
static void assert_same(const mbsr_model *a, const mbsr_model *b, uint64_t seed)
{
    enum { MOST = 256 };
    const mbsr_model *m[2] = {a, b};
    double F[2][MOST] = {{0.0}}, tau[2][MOST] = {{0.0}};
    test_rng rng = test_seed(seed);
    double y[MOST], yp[MOST];
    const int size = mbsr_dae_size(a, MBSR_DAE_MOMENTUM), nq = mbsr_model_nq(a);
    assert_int_equal(size, mbsr_dae_size(b, MBSR_DAE_MOMENTUM));
    assert_in_range(size, 1, MOST);
    test_fill(&rng, size, y);
    test_fill(&rng, size, yp);
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        assert_ok(mbsr_data_create(m[k], &d, NULL), NULL);
        assert_ok(mbsr_dae_residual(m[k], d, MBSR_DAE_MOMENTUM, 0.3, y, yp, F[k]),
                  mbsr_data_error(d));
        assert_ok(mbsr_inverse_dynamics(m[k], d, 0.3, y, yp, yp + nq, NULL, tau[k]),
                  mbsr_data_error(d));
        mbsr_data_destroy(d);
    }
    assert_memory_equal(F[0], F[1], sizeof F[0]);
    assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
}

static mbsr_model *copy_of(const mbsr_model *m)
{
    mbsr_model *copy;
    mbsr_error error;
    assert_ok(mbsr_model_copy(m, &copy, &error), &error);
    return copy;
}

static void finish(mbsr_model *m)
{
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
}

/* Copies of a finished model, of a copy that is not finished, and one in which every mass was
 * neglected and restored. */
static void check_copies(const mbsr_model *m)
{
    mbsr_model *first = copy_of(m), *second = copy_of(first), *third = copy_of(m);
    finish(first);
    finish(second);
    for (int id = mbsr_model_bodies(m) - 1; id >= 0; --id)
        (void)mbsr_model_neglect(third, id, MBSR_MASS_AND_MOMENT);
    mbsr_model *fourth = copy_of(third);
    finish(fourth);
    mbsr_model *fifth = copy_of(fourth);
    for (int id = 0; id < mbsr_model_bodies(m); ++id) {
        assert_ok(mbsr_model_restore(third, id), mbsr_model_error(third));
        assert_ok(mbsr_model_restore(fifth, id), mbsr_model_error(fifth));
        assert_string_equal(mbsr_body_name(m, id), mbsr_body_name(first, id));
    }
    finish(third);
    finish(fifth);
    assert_same(m, first, 1);
    assert_same(m, second, 2);
    assert_same(m, third, 3);
    assert_same(m, fifth, 4);
    mbsr_model *const all[] = {first, second, third, fourth, fifth};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; ++k) mbsr_model_destroy(all[k]);
}

static void a_copy_moves_as_its_model(void **unused)
{
    (void)unused;
    for (int scene = 0; scene < MIXED_ALL; ++scene) {
        mixed s;
        mixed_make(&s, (mixed_scene)scene);
        check_copies(s.model);
        mixed_free(&s);
    }
}

static void a_copy_has_the_loops_of_its_model(void **unused)
{
    (void)unused;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "coupler", a, 1.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.0, 0.0, MBSR_GROUND, 2.0, 0.5);
    loops_finish(&s);
    check_copies(s.m);
    loops_free(&s);
}

/* One body of each kind on the ground: inertia, and what it is without parts. */
static mbsr_model *single(mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "one";
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    return m;
}

static void a_copy_has_armature_and_locks(void **unused)
{
    (void)unused;
    const mbsr_joint joint = mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    mbsr_model *m = single(joint, mbsr_inertia_planar(1.3, NULL, 0.2));
    assert_ok(mbsr_model_armature(m, 0, 3, (const double[3]){0.5, 0.7, 0.9}), mbsr_model_error(m));
    assert_ok(mbsr_model_lock(m, 0, 1, 0.4), mbsr_model_error(m));
    assert_ok(mbsr_model_regularise(m, 0, 3, (const double[9]){[0] = 0.1, [4] = 0.2}),
              mbsr_model_error(m));
    finish(m);
    check_copies(m);
    mbsr_model_destroy(m);
}

static void what_is_neglected_is_the_inertia_without_it(void **unused)
{
    (void)unused;
    static const double com[3] = {0.4, -0.1, 0.2}, tensor[6] = {0.5, 0.6, 0.7, 0.1, 0.0, 0.05};
    const mbsr_joint plane = mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    const mbsr_joint space = mbsr_joint_free(NULL, NULL);
    const struct {
        mbsr_joint joint;
        mbsr_inertia given, left;
        int parts;
    } row[] = {
        {plane, mbsr_inertia_planar(1.3, com, 0.2), mbsr_inertia_planar(0.0, com, 0.2), MBSR_MASS},
        {plane, mbsr_inertia_planar(1.3, com, 0.2), mbsr_inertia_planar(1.3, com, 0.0),
         MBSR_MOMENT},
        {plane, mbsr_inertia_planar(1.3, com, 0.2), mbsr_inertia_zero(), MBSR_MASS_AND_MOMENT},
        {space, mbsr_inertia_rigid(1.3, com, tensor), mbsr_inertia_rigid(0.0, com, tensor),
         MBSR_MASS},
        {space, mbsr_inertia_rigid(1.3, com, tensor), mbsr_inertia_point_mass(1.3, com),
         MBSR_MOMENT},
        {space, mbsr_inertia_rigid(1.3, com, tensor), mbsr_inertia_zero(), MBSR_MASS_AND_MOMENT},
    };
    for (size_t k = 0; k < sizeof row / sizeof row[0]; ++k) {
        mbsr_model *m = single(row[k].joint, row[k].given),
                   *expected = single(row[k].joint, row[k].left);
        /* first another part, then this one */
        assert_ok(mbsr_model_neglect(m, 0, row[k].parts == MBSR_MASS ? MBSR_MOMENT : MBSR_MASS),
                  mbsr_model_error(m));
        assert_ok(mbsr_model_neglect(m, 0, row[k].parts), mbsr_model_error(m));
        finish(m);
        finish(expected);
        assert_int_equal(mbsr_body_neglected(m, 0), row[k].parts);
        assert_int_equal(mbsr_body_neglected(expected, 0), 0);
        assert_same(m, expected, 7 + k);
        mbsr_model_destroy(m);
        mbsr_model_destroy(expected);
    }
}

static void refusals_name_the_body(void **unused)
{
    (void)unused;
    const mbsr_joint joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    const double matrix[4] = {1.0, 0.0, 0.0, 2.0};
    mbsr_model *m = single(joint, mbsr_inertia_particle(1.0)), *copy = m;
    const mbsr_error *e = mbsr_model_error(m);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = joint;
    assert_ok(mbsr_model_add_body(m, &body, NULL), e);
    body.inertia = mbsr_inertia_matrix(2, matrix);
    assert_ok(mbsr_model_add_body(m, &body, NULL), e);
    assert_refused(mbsr_model_neglect(m, 7, MBSR_MASS), e, MBSR_ERR_ID, -2, -2, "no body 7");
    assert_refused(mbsr_model_neglect(m, 0, 0), e, MBSR_ERR_VALUE, 0, -2, "'one'|MBSR_MASS");
    assert_refused(mbsr_model_neglect(m, 0, 4), e, MBSR_ERR_VALUE, 0, -2, "'one'|MBSR_MASS");
    assert_refused(mbsr_model_neglect(m, 0, MBSR_MOMENT), e, MBSR_ERR_VALUE, 0, -2, "no moment");
    assert_refused(mbsr_model_neglect(m, 1, MBSR_MASS), e, MBSR_ERR_VALUE, 1, -2, "no inertia");
    assert_refused(mbsr_model_neglect(m, 2, MBSR_MASS), e, MBSR_ERR_VALUE, 2, -2, "no parts");
    assert_refused(mbsr_model_restore(m, -1), e, MBSR_ERR_ID, -2, -2, "no body -1");
    assert_int_equal(mbsr_model_neglect(NULL, 0, MBSR_MASS), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_restore(NULL, 0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_body_neglected(m, 0), -1);
    finish(m);
    assert_int_equal(mbsr_body_neglected(m, 3), -1);
    assert_int_equal(mbsr_body_neglected(m, 0), 0);
    assert_refused(mbsr_model_neglect(m, 0, MBSR_MASS), e, MBSR_ERR_FINISHED, -2, -2, "finished");
    assert_refused(mbsr_model_restore(m, 0), e, MBSR_ERR_FINISHED, -2, -2, "finished");
    mbsr_error error;
    assert_int_equal(mbsr_model_copy(NULL, &copy, &error), MBSR_ERR_NULL);
    assert_null(copy);
    assert_int_equal(mbsr_model_copy(m, NULL, NULL), MBSR_ERR_NULL);
    mbsr_model_destroy(m);
}

static void copies_without_memory_leave_nothing(void **unused)
{
    (void)unused;
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m, *copy = NULL;
    mbsr_error error;
    def.allocator = test_counting_allocator(&counting);
    assert_ok(mbsr_model_create(&def, &m, &error), &error);
    const mbsr_joint joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "cart";
    body.joint = joint;
    body.inertia = mbsr_inertia_particle(1.0);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 1.0, 0.0, 0.0);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_neglect(m, 0, MBSR_MASS), mbsr_model_error(m));
    finish(m);
    const long live = counting.live;
    int failures = 0;
    for (long k = 1; copy == NULL; ++k) {
        counting.fail_at = counting.calls + k;
        const int status = mbsr_model_copy(m, &copy, &error);
        assert_true((status == MBSR_ERR_NO_MEMORY) == (copy == NULL));
        if (!status) break;
        assert_contains(error.text, "no memory");
        assert_int_equal(counting.live, live);
        ++failures;
    }
    assert_in_range(failures, 3, 20);
    counting.fail_at = 0;
    mbsr_model_destroy(copy);
    mbsr_model_destroy(m);
    assert_int_equal(counting.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_moves_as_its_model),
        cmocka_unit_test(a_copy_has_the_loops_of_its_model),
        cmocka_unit_test(a_copy_has_armature_and_locks),
        cmocka_unit_test(what_is_neglected_is_the_inertia_without_it),
        cmocka_unit_test(refusals_name_the_body),
        cmocka_unit_test(copies_without_memory_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
