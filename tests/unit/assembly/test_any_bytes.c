/* Models that random bytes build, and what they are asked for (tests/fuzz/fuzz_model.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "fuzz_model.h"

#include "algebra/lapack.h"

static void random_bytes(void **state)
{
    enum { SIZE = 600 };
    (void)state;
    const int count = test_long() ? 20000 : test_seeds(100, 400);
    for (int seed = 1; seed <= count; ++seed) {
        test_rng rng = test_seed((uint64_t)seed);
        uint8_t bytes[SIZE];
        for (int k = 0; k < SIZE; ++k) bytes[k] = (uint8_t)test_integer(&rng, 0, 255);
        assert_int_equal(LLVMFuzzerTestOneInput(bytes, SIZE), 0);
    }
}

/* ---- what such models have found ---- */

/* Coordinate -1, which is none, on the ground, which has none. */
static void no_coordinate_of_no_body(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0};
    const mbsr_force_def wrong[] = {mbsr_force_joint_friction(MBSR_GROUND, -1, 1.0, 0.1),
                                    mbsr_force_joint_friction(0, -1, 1.0, 0.1)};
    for (int k = 0; k < 2; ++k) {
        mbsr_model *m;
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_revolute(NULL, NULL, z);
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_force(m, wrong + k, NULL), mbsr_model_error(m));
        const int status = mbsr_model_finish(m);
        assert_refused(status, mbsr_model_error(m), MBSR_ERR_VALUE, MBSR_NONE, 0, "friction");
        mbsr_model_destroy(m);
    }
}

/* Numbers that are not finite where a closed model goes by vector code. */
static void closed_model_at_no_number(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0}, end[3] = {1.0, 0.0, 0.0},
                        there[3] = {2.0, 0.0, 0.0};
    const mbsr_frame tip = mbsr_frame_at(1.0, 0.0, 0.0);
    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_revolute(k > 0 ? &tip : NULL, NULL, z);
        body.inertia = mbsr_inertia_point_mass(1.0, end);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_closure_def distance = mbsr_closure_distance(2, end, MBSR_GROUND, there, 1.0);
    assert_ok(mbsr_model_add_closure(m, &distance, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int k = 0; k < 4; ++k) { /* the first time nothing has been evaluated before */
        double q[3] = {0.1, k == 0 ? NAN : 0.2, 0.3}, u[3] = {0.0, 0.0, k == 1 ? INFINITY : 0.0};
        double udot[3];
        const double t = k == 2 ? NAN : 0.0;
        assert_int_equal(mbsr_forward_dynamics(m, d, t, q, u, NULL, udot),
                         k == 3 ? MBSR_OK : MBSR_NOT_FINITE);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* LAPACK's own iteration would not end. */
static void singular_values_of_no_numbers(void **state)
{
    (void)state;
    double A[9] = {1.0, NAN, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, s[3], U[9], V[9], work[64];
    assert_int_equal(mbsri_lapack_svd(3, A, s, U, V, work, 64), 4);
    assert_int_equal(mbsri_lapack_singular_values(3, A, s, work, 64), 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_coordinate_of_no_body), cmocka_unit_test(closed_model_at_no_number),
        cmocka_unit_test(singular_values_of_no_numbers), cmocka_unit_test(random_bytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
