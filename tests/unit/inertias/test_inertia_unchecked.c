/* Inertias whose tensor no distribution of mass has.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

static const double com[3] = {0.1, 0.2, -0.1};

static int add(mbsr_inertia inertia, mbsr_model **model)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_free(NULL, NULL);
    body.inertia = inertia;
    assert_ok(mbsr_model_create(NULL, model, NULL), NULL);
    return mbsr_model_add_body(*model, &body, NULL);
}

static void expect(mbsr_inertia inertia, int status, const char *words)
{
    mbsr_model *m;
    const int result = add(inertia, &m);
    if (status)
        assert_refused(result, mbsr_model_error(m), status, 0, MBSR_NONE, words);
    else
        assert_ok(result, mbsr_model_error(m));
    mbsr_model_destroy(m);
}

static void the_triangle_inequality_is_waived(void **state)
{
    (void)state;
    const double flat[6] = {1.0, 1.0, 3.0, 0.0, 0.0, 0.0}, line[6] = {0.0, 0.0, 1.0};
    expect(mbsr_inertia_rigid(2.0, com, flat), MBSR_ERR_VALUE, "no body has this inertia.tensor");
    expect(mbsr_inertia_rigid_unchecked(2.0, com, flat), MBSR_OK, "");
    expect(mbsr_inertia_rigid_unchecked(2.0, com, line), MBSR_OK, "");
    expect(mbsr_inertia_rigid_unchecked(0.0, com, flat), MBSR_OK, "");
    const mbsr_frame frame = mbsr_frame_rotated(com, com, 0.7);
    const mbsr_inertia moved = mbsr_inertia_in_frame(&frame,
                                                     mbsr_inertia_rigid_unchecked(1, com, flat)),
                       more = mbsr_inertia_sum(mbsr_inertia_particle(0.1), moved);
    expect(moved, MBSR_OK, "");
    expect(more, MBSR_OK, "");
    assert_int_equal(mbsr_inertia_sum(more, more).unchecked, 1);
    assert_int_equal(mbsr_inertia_sum(mbsr_inertia_particle(1), mbsr_inertia_particle(2)).unchecked,
                     0);
}

static void what_makes_a_mass_matrix_indefinite_is_refused(void **state)
{
    (void)state;
    const double negative[6] = {1.0, 1.0, -1e-3, 0.0, 0.0, 0.0},
                 product[6] = {1.0, 1.0, 1.0, 1.5, 0.0, 0.0}, rounded[6] = {1.0, 1.0, -1e-8},
                 wild[6] = {1.0, NAN, 1.0}, good[6] = {1.0, 1.0, 1.0};
    const int wrong = MBSR_ERR_VALUE;
    expect(mbsr_inertia_rigid_unchecked(1.0, com, negative), wrong,
           "inertia.tensor is indefinite|-0.001");
    expect(mbsr_inertia_rigid_unchecked(1.0, com, product), wrong, "inertia.tensor is indefinite");
    expect(mbsr_inertia_rigid_unchecked(1.0, com, rounded), MBSR_OK, "");
    expect(mbsr_inertia_rigid_unchecked(1.0, com, wild), wrong, "inertia.tensor[1] is nan");
    expect(mbsr_inertia_rigid_unchecked(-1.0, com, good), wrong, "mass is -1");
    expect(mbsr_inertia_rigid_unchecked(1e308, (const double[3]){1e9, 0, 0}, good), wrong,
           "not finite");
}

/* Euler's equations with such a tensor: about a principal axis u' = tau / moment. */
static void it_turns_as_its_tensor_says(void **state)
{
    (void)state;
    const double flat[6] = {1.0, 1.0, 3.0, 0.0, 0.0, 0.0};
    mbsr_model *m;
    mbsr_data *d = NULL;
    const int status = add(mbsr_inertia_rigid_unchecked(2.0, NULL, flat), &m);
    assert_ok(status, mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const double q[7] = {1.0}, u[6] = {0.0}, tau[6] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0},
                 expected[6] = {1.0, 2.0, 1.0, 2.0, 2.5, 3.0};
    double udot[6];
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot), mbsr_data_error(d));
    for (int k = 0; k < 6; ++k) assert_close(udot[k], expected[k], 1e-14);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_triangle_inequality_is_waived),
        cmocka_unit_test(what_makes_a_mass_matrix_indefinite_is_refused),
        cmocka_unit_test(it_turns_as_its_tensor_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
