/* Flexible bodies: data with numbers that are not finite or that overflow are refused, or give no
 * numbers that are not finite with MBSR_OK. See finite.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "flexible.h"

#include <string.h>

/* Functions that the trials below call. */
static const char *const functions[] = {
    "mbsr_default_beam_def",     "mbsr_flex_beam",          "mbsr_default_flex_def",
    "mbsr_default_flexible_def", "mbsr_flex_create",        "mbsr_flex_definition",
    "mbsr_flex_destroy",         "mbsr_flex_mass_matrix",   "mbsr_flex_span",
    "mbsr_force_elastic",        "mbsr_inertia_flexible",   "mbsr_joint_marker",
    "mbsr_joint_mount",          "mbsr_model_add_flexible", "mbsr_model_add_marker"};

enum { MODES = 2, D = 6 + MODES, SHAPES = MODES + 3 };

static void assert_finite(int n, const double *x)
{
    for (int k = 0; k < n; ++k) assert_true(isfinite(x[k]));
}

/* A pendulum of these data, joint by joint. */
static void run(const mbsr_flex *flex, const double s[MODES])
{
    static const double axis[3] = {0.0, 0.0, 1.0};
    const double q[3] = {0.3, s[0], s[1]}, u[3] = {1.0, 0.5, -0.2};
    double M[D * D], udot[3], pose[12];
    mbsr_flexible_def def = mbsr_default_flexible_def();
    mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    mbsr_model *m;
    mbsr_data *d;
    int body, tip;
    if (mbsr_flex_mass_matrix(flex, s, M) == MBSR_OK) assert_finite(D * D, M);
    for (int k = -1; k <= MODES; ++k) {
        const double span = mbsr_flex_span(flex, k, 0.5);
        assert_true(isfinite(span) && span > 0.0);
    }
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    def.flex = flex, def.joint = mbsr_joint_revolute(NULL, NULL, axis);
    assert_ok(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    assert_ok(mbsr_model_add_marker(m, body, 1, "tip", &tip), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    if (mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot) == MBSR_OK)
        assert_finite(3, udot);
    else
        assert_true(mbsr_data_error(d)->text[0] != '\0');
    if (mbsr_stage_positions(m, d, 0.0, q) == MBSR_OK && mbsr_body_pose(m, d, tip, pose) == MBSR_OK)
        assert_finite(12, pose);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* One entry of one of the arrays at a time. */
static void nothing_that_is_not_finite_passes(void **state)
{
    (void)state;
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e308, -1e308, 1e200};
    static const double zero[MODES] = {0.0}, shape[MODES] = {0.02, -0.01};
    test_ritz beam = test_ritz_pendulum(100.0);
    beam.stiffening = 1;
    mbsr_flex *good = test_ritz_make(&beam);
    mbsr_flex_def given;
    assert_int_equal(mbsr_flex_definition(good, &given), MBSR_OK);
    const int length[] = {1,
                          3,
                          9,
                          3 * SHAPES,
                          9 * SHAPES,
                          9 * SHAPES * SHAPES,
                          SHAPES * SHAPES,
                          MODES * MODES,
                          MODES * MODES,
                          3 * MODES * MODES,
                          3,
                          3 * SHAPES,
                          3 * SHAPES};
    int made = 0, refused = 0;
    for (int k = 0; k < 13; ++k) {
        for (int l = 0; l < length[k] * 6; ++l) {
            mbsr_flex_def def = given;
            mbsr_flex_marker marker[2] = {given.marker[0], given.marker[1]};
            double x[9 * SHAPES * SHAPES];
            const double *from[] = {&given.mass,  given.c0, given.N0,          given.Ct0,
                                    given.P0,     given.P,  given.Mf,          given.K,
                                    given.D,      given.Y,  marker[1].frame.x, marker[1].Phi,
                                    marker[1].Psi};
            memcpy(x, from[k], (size_t)length[k] * sizeof *x);
            x[l / 6] = bad[l % 6];
            if (k == 0) def.mass = x[0];
            if (k == 1) memcpy(def.c0, x, sizeof def.c0);
            if (k == 2) memcpy(def.N0, x, sizeof def.N0);
            const double **const to[] = {&def.Ct0, &def.P0, &def.P, &def.Mf,
                                         &def.K,   &def.D,  &def.Y};
            if (k >= 3 && k < 10) *to[k - 3] = x;
            if (k == 10) memcpy(marker[1].frame.x, x, 3 * sizeof *x);
            if (k == 11) marker[1].Phi = x;
            if (k == 12) marker[1].Psi = x;
            def.marker = marker;
            mbsr_flex *flex;
            mbsr_error error;
            if (mbsr_flex_create(&def, &flex, &error) != MBSR_OK) {
                ++refused;
                assert_null(flex);
                assert_true(error.text[0] != '\0');
                continue;
            }
            ++made;
            run(flex, zero);
            run(flex, shape);
            mbsr_flex_destroy(flex);
        }
    }
    assert_true(made > 10 && refused > 100);
    run(good, (double[MODES]){1e308, 1e308});
    run(good, (double[MODES]){NAN, 0.0});
    mbsr_flex_destroy(good);
}

static void parts_without_data_are_refused(void **state)
{
    (void)state;
    mbsr_body_def body = mbsr_default_body_def();
    mbsr_force_def elastic = mbsr_force_elastic(0, NULL);
    mbsr_model *m;
    mbsr_flex_def data;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const mbsr_error *e = mbsr_model_error(m);
    body.joint = mbsr_joint_mount(NULL, 0);
    assert_refused(mbsr_model_add_body(m, &body, NULL), e, MBSR_ERR_NULL, 0, MBSR_NONE, "flex");
    body.joint = mbsr_joint_marker(NULL, 0);
    assert_refused(mbsr_model_add_body(m, &body, NULL), e, MBSR_ERR_NULL, 0, MBSR_NONE, "flex");
    body.joint = mbsr_joint_weld(NULL, NULL);
    body.inertia = mbsr_inertia_flexible(NULL);
    assert_refused(mbsr_model_add_body(m, &body, NULL), e, MBSR_ERR_NULL, 0, MBSR_NONE, "flex");
    assert_refused(mbsr_model_add_force(m, &elastic, NULL), e, MBSR_ERR_NULL, MBSR_NONE, 0, "flex");
    assert_true(mbsr_flex_span(NULL, 0, 1.0) == 1.0);
    assert_int_equal(mbsr_flex_definition(NULL, &data), MBSR_ERR_NULL);
    mbsr_model_destroy(m);
    for (size_t k = 0; k < sizeof functions / sizeof *functions; ++k)
        assert_contains(functions[k], "mbsr_");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_that_is_not_finite_passes),
        cmocka_unit_test(parts_without_data_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
