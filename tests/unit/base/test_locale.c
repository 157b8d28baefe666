/* Texts in a locale with a decimal comma, and the library's own formatting against that of the C
 * library.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "expect.h"
#include "locale_comma.h"

#include <stdint.h>
#include <stdio.h>

/* Both ways, in buffers of every size up to that of the text. */
#define assert_same_print(...)                                                                     \
    do {                                                                                           \
        char expected[300], found[300];                                                            \
        const int length = snprintf(expected, sizeof expected, __VA_ARGS__);                       \
        for (size_t size = (size_t)length + 2; size > 0; --size) {                                 \
            memset(found, 'x', sizeof found);                                                      \
            snprintf(expected, size, __VA_ARGS__);                                                 \
            assert_int_equal(mbsri_print(found, size, __VA_ARGS__), length);                       \
            assert_string_equal(found, expected);                                                  \
            assert_int_equal(found[size], 'x');                                                    \
        }                                                                                          \
    } while (0)

static void prints_what_printf_prints(void **state)
{
    (void)state;
    const size_t most = SIZE_MAX;
    assert_same_print("plain");
    assert_same_print("%s", "");
    assert_same_print("100%% of %d and %u, %c%c", -7, 8u, 'a', 'b');
    assert_same_print("%s|%.3s|%.0s|%.9s", "string", "string", "string", "string");
    assert_same_print("%zu %ld %lld %lu %x %5d %-5d| %05d", most, -3L, 1LL << 60, 4ul, 255u, 3, 3,
                      3);
    assert_same_print("%g %.3g %+.3g %.17g %10.4f %-12.3e|", 1.5, 0.1, -0.1, 0.1, 3.14159, -2.5e-7);
    assert_same_print("%g %g %g %g", INFINITY, -INFINITY, 1e308, 0.0);
    assert_same_print("%.1f", -1e200);
    assert_same_print("%s %p", "at", (void *)0x1234);
    assert_same_print("%s: %d of '%s' is %g, must be %g", "body 3", 2, "1,5", 1.5, 2.25);
}

static void numbers_have_a_point_and_names_stay(void **state)
{
    (void)state;
    if (!test_locale_comma()) skip();
    char text[100];
    assert_int_equal(snprintf(text, sizeof text, "%g", 1.5), 3);
    assert_string_equal(text, "1,5"); /* this is such a locale */
    assert_int_equal(
        mbsri_print(text, sizeof text, "%s %g %.3f %.10g %5.1e", "1,5", 1.5, -2.25, 0.1, 1.25e-7),
        26);
    assert_string_equal(text, "1,5 1.5 -2.250 0.1 1.2e-07");
    test_locale_back();
}

static void refusals_in_a_locale_with_a_comma(void **state)
{
    (void)state;
    if (!test_locale_comma()) skip();
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const mbsr_error *error = mbsr_model_error(m);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "rod 1,5";
    body.joint = mbsr_joint_weld(NULL, NULL);
    body.inertia = mbsr_inertia_particle(-1.5);
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "body 0 'rod 1,5'|mass is -1.5");
    body.inertia = mbsr_inertia_zero();
    body.joint.param[3] = 0.5;
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "rod 1,5|frame A|differs from 1 by 0.75");
    body.joint = mbsr_joint_compound(
        NULL, NULL, 2,
        (const mbsr_axis[2]){{.kind = MBSR_AXIS_TRANSLATION, .direction = {1, 0, 0}},
                             {.kind = MBSR_AXIS_TRANSLATION, .direction = {1, 0.5, 0}}},
        NULL, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), error);
    const mbsr_force_def force = mbsr_force_joint_spring(0, 0, -2.5, 0.0, 0.0);
    assert_ok(mbsr_model_add_force(m, &force, NULL), error);
    assert_refused(mbsr_model_finish(m), error, MBSR_ERR_VALUE, MBSR_NONE, 0,
                   "(stiffness) is -2.5, negative");
    mbsr_model_destroy(m);
    test_locale_back();
}

/* Two carts without mass, of which only a combination is held. */
static void reports_in_a_locale_with_a_comma(void **state)
{
    (void)state;
    if (!test_locale_comma()) skip();
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_index_report *report = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint =
        mbsr_joint_planar_revolute((mbsr_planar_frame){0, 0, 0}, (mbsr_planar_frame){0, 0, 0});
    assert_ok(mbsr_model_add_body(m, &body, NULL), NULL);
    body.joint =
        mbsr_joint_planar_prismatic((mbsr_planar_frame){4, 0, 0}, (mbsr_planar_frame){0, 0, 0});
    body.parent = 0;
    assert_ok(mbsr_model_add_body(m, &body, NULL), NULL);
    const double ground[3] = {0.0, 1.0, 0.0};
    const mbsr_force_def spring =
        mbsr_force_point_spring(1, NULL, MBSR_GROUND, ground, 3.0, 1.0, 0.5);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), NULL);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const double q[2] = {0.3, 0.2}, u[2] = {0.1, 0.2};
    assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &report), mbsr_data_error(d));
    for (const char *c = strchr(report->text, ','); c; c = strchr(c + 1, ','))
        assert_int_equal(c[1], ' ');
    mbsr_index_report_destroy(m, report);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    test_locale_back();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prints_what_printf_prints),
        cmocka_unit_test(numbers_have_a_point_and_names_stay),
        cmocka_unit_test(refusals_in_a_locale_with_a_comma),
        cmocka_unit_test(reports_in_a_locale_with_a_comma),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
