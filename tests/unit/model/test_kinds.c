/* What joint coordinates measure, against what they move.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "own_joint.h"
#include "expect.h"
#include "samples.h"

enum { MOST = 7 };

static int add(mbsr_model *m, mbsr_joint joint)
{
    int id = MBSR_NONE;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = joint;
    assert_ok(mbsr_model_add_body(m, &def, &id), mbsr_model_error(m));
    return id;
}

static mbsr_model *empty(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

/* Whether the body's twist has an angular velocity when only rate k of nu is 1; drives stand still
 * in the Jacobian. */
static bool turns(mbsr_model *m, mbsr_data *d, int body, int k)
{
    double J[6 * 64];
    const int dimension = mbsr_body_dimension(m, body), nu = mbsr_model_nu(m);
    assert_in_range(dimension * nu, 1, 6 * 64);
    assert_ok(mbsr_body_jacobian(m, d, body, J), mbsr_data_error(d));
    const double *column = J + k * dimension;
    if (dimension == 2) return false;
    if (dimension == 3) return fabs(column[2]) > 1e-12;
    return test_largest(3, column) > 1e-12;
}

/* Each rate is a rotation exactly where it turns the body, and each position of the kind of the
 * rate that changes it. */
static void check_model(mbsr_model *m)
{
    mbsr_data *d = NULL;
    double q[64], u[64] = {0.0}, rate[64];
    test_rng rng = test_seed(4);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_model_nq(m), 1, 64);
    test_fill(&rng, mbsr_model_nq(m), q);
    assert_ok(mbsr_stage_positions(m, d, 0.3, q), mbsr_data_error(d));
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        mbsr_coordinate_kind position[MOST], velocity[MOST];
        int first_q, nq, first_u, n;
        assert_ok(mbsr_body_coordinates(m, i, &first_q, &nq, &first_u, &n), NULL);
        assert_in_range(nq, 0, MOST);
        assert_ok(mbsr_body_coordinate_kinds(m, i, position, velocity), NULL);
        for (int k = 0; k < n; ++k) {
            const bool rotation = turns(m, d, i, first_u + k);
            assert_int_equal(velocity[k],
                             rotation ? MBSR_COORDINATE_ROTATION : MBSR_COORDINATE_TRANSLATION);
            u[first_u + k] = 1.0;
            assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
            u[first_u + k] = 0.0;
            assert_ok(mbsr_coordinate_rates(m, d, rate), mbsr_data_error(d));
            for (int j = 0; j < nq; ++j) {
                if (fabs(rate[first_q + j]) > 1e-12) assert_int_equal(position[j], velocity[k]);
            }
        }
    }
    mbsr_data_destroy(d);
}

static int still(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    (void)t;
    *s = *sdot = *sddot = 0.0;
    return 0;
}

static void stock_joints_in_space(void **state)
{
    (void)state;
    const mbsr_axis driven_first[2] = {
        {.kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}, .driven = 1},
        {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 1.0, 0.0}}};
    test_rng rng = test_seed(11);
    mbsr_model *m = empty();
    for (int kind = 0; kind < TEST_KINDS; ++kind) add(m, test_joint_in_space(&rng, kind, 1.0));
    for (int k = 0; k < SAMPLE_JOINTS; ++k) add(m, sample_make(k, &rng).joint);
    add(m, mbsr_joint_compound(NULL, NULL, 2, driven_first, still, NULL));
    check_model(m);
    mbsr_model_destroy(m);
}

static void stock_joints_in_the_plane(void **state)
{
    (void)state;
    const mbsr_planar_frame A = {0.1, 0.2, 0.3}, B = {-0.4, 0.5, 0.6};
    mbsr_model *m = empty();
    for (int free = 1; free < 8; ++free) {
        const int driven = ~free & 4;
        add(m, mbsr_joint_planar(A, B, free, driven, still, NULL));
        if (free < 4) add(m, mbsr_joint_point(A, free, 3 & ~free, still, NULL));
    }
    check_model(m);
    mbsr_model_destroy(m);
}

static void coordinates_that_are_left(void **state)
{
    (void)state;
    test_rng rng = test_seed(12);
    mbsr_model *m = empty();
    for (int k = 0; k < 3; ++k) {
        const int body = add(m, mbsr_joint_in_plane(NULL, NULL));
        assert_ok(mbsr_model_lock(m, body, k, 0.2), mbsr_model_error(m));
    }
    for (int k = 0; k < 3; ++k) {
        const int body = add(m, sample_make(SAMPLE_JOINTS - 1, &rng).joint);
        assert_ok(mbsr_model_lock(m, body, k, 0.2), mbsr_model_error(m));
    }
    for (int k = 0; k < 3; ++k) {
        const int body =
            add(m, mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0}));
        assert_ok(mbsr_model_lock(m, body, k, 0.2), mbsr_model_error(m));
    }
    check_model(m);
    mbsr_coordinate_kind kind[2] = {MBSR_COORDINATE_OTHER, MBSR_COORDINATE_OTHER};
    assert_ok(mbsr_body_coordinate_kinds(m, 1, NULL, kind), NULL);
    assert_true(kind[0] == MBSR_COORDINATE_TRANSLATION && kind[1] == MBSR_COORDINATE_ROTATION);
    mbsr_model_destroy(m);
}

static void what_is_not_known(void **state)
{
    (void)state;
    mbsr_coordinate_kind kind = MBSR_COORDINATE_ROTATION;
    mbsr_model *m = empty();
    add(m, mbsr_joint_custom(&test_own_table, 1, 1, NULL));
    assert_int_equal(mbsr_body_coordinate_kinds(NULL, 0, &kind, &kind), MBSR_ERR_NULL);
    assert_int_equal(mbsr_body_coordinate_kinds(m, 0, &kind, &kind), MBSR_ERR_UNFINISHED);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_body_coordinate_kinds(m, 1, &kind, &kind), MBSR_ERR_ID);
    assert_int_equal(mbsr_body_coordinate_kinds(m, MBSR_GROUND, &kind, &kind), MBSR_ERR_ID);
    assert_int_equal(kind, MBSR_COORDINATE_ROTATION);
    assert_ok(mbsr_body_coordinate_kinds(m, 0, NULL, NULL), NULL);
    assert_ok(mbsr_body_coordinate_kinds(m, 0, NULL, &kind), NULL);
    assert_int_equal(kind, MBSR_COORDINATE_OTHER);
    kind = MBSR_COORDINATE_ROTATION;
    assert_ok(mbsr_body_coordinate_kinds(m, 0, &kind, NULL), NULL);
    assert_int_equal(kind, MBSR_COORDINATE_OTHER);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stock_joints_in_space),
        cmocka_unit_test(stock_joints_in_the_plane),
        cmocka_unit_test(coordinates_that_are_left),
        cmocka_unit_test(what_is_not_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
