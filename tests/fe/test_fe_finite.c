/* Nothing of the component returns MBSR_OK with a number that is not finite: numbers of a model one
 * by one.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "sid_text.h"
#include "solid.h"

/* Functions that are called here, in test_read.c and in test_sid.c. */
static const char *const functions[] = {"mbsr_default_fe_def",    "mbsr_fe_reduce",
                                        "mbsr_fe_report_destroy", "mbsr_fe_read",
                                        "mbsr_fe_input_destroy",  "mbsr_default_sid_opt",
                                        "mbsr_sid_read",          "mbsr_sid_report_destroy",
                                        "mbsr_sid_write",         "mbsr_sid_text_destroy"};

static void assert_finite(int n, const double *x)
{
    for (int k = 0; k < n; ++k) assert_true(isfinite(x[k]));
}

static void run(const mbsr_fe_def *def)
{
    mbsr_flex *flex;
    mbsr_fe_report *report;
    mbsr_flex_def data;
    mbsr_error error;
    if (mbsr_fe_reduce(def, &flex, &report, &error)) {
        assert_null(flex);
        assert_null(report);
        assert_true(error.text[0] != '\0');
        return;
    }
    assert_int_equal(mbsr_flex_definition(flex, &data), MBSR_OK);
    const int n = data.modes;
    assert_finite(n * n, data.K);
    assert_finite(n * n, data.D);
    assert_finite(9 * n * n, data.P);
    assert_finite(9 * n, data.P0);
    for (int k = 0; k < data.markers; ++k) assert_finite(3 * n, data.marker[k].Phi);
    assert_finite(report->normal, report->omega);
    assert_finite(6, report->lost);
    for (int a = 0; a < report->modes; ++a) {
        assert_finite(1, &report->mode[a].omega);
        assert_finite(6, report->mode[a].effective);
    }
    assert_true(isfinite(report->definite) && isfinite(report->difference) &&
                isfinite(report->rigid) && !strstr(report->text, "nan"));
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
}

static void nothing_that_is_not_finite_passes(void **state)
{
    (void)state;
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e308, -1e308, 1e200, 1e-308, 0.0};
    test_solid *s = test_bar(2, 1, 1);
    s->def.modes = 3;
    double *const arrays[3] = {s->mesh.K, s->mesh.M, s->mesh.x};
    const int sizes[3] = {s->mesh.entries, s->mesh.entries, 3 * s->mesh.nodes};
    for (int which = 0; which < 3; ++which) {
        for (int k = 0; k < sizes[which]; k += which == 2 ? 1 : 37) {
            const double kept = arrays[which][k];
            for (size_t b = 0; b < sizeof bad / sizeof *bad; ++b) {
                arrays[which][k] = bad[b];
                run(&s->def);
            }
            arrays[which][k] = kept;
        }
    }
    for (size_t b = 3; b < sizeof bad / sizeof *bad; ++b) { /* units that overflow */
        for (int which = 0; which < 3; ++which) {
            double *kept = malloc((size_t)sizes[which] * sizeof *kept);
            memcpy(kept, arrays[which], (size_t)sizes[which] * sizeof *kept);
            for (int k = 0; k < sizes[which]; ++k) arrays[which][k] *= bad[b];
            run(&s->def);
            memcpy(arrays[which], kept, (size_t)sizes[which] * sizeof *kept);
            free(kept);
        }
    }
    test_solid_destroy(s);
}

/* Blocks of a SID file by large and small factors. */
static void sid_files(void **state)
{
    (void)state;
    static const char *const blocks[] = {"mdCM", "J", "Ct", "Cr", "Me", "Oe", "Ke", "De"};
    static const double factors[] = {1e308, -1e200, 1e150, 1e-200, 1e-308, 0.0};
    mbsr_beam_def beam = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_sid_text *text;
    mbsr_error error;
    beam.length = beam.density = beam.EI_z = beam.EI_y = 1.0;
    beam.elements = 3, beam.modes = 3;
    assert_ok(mbsr_flex_beam(&beam, &flex, &error), &error);
    assert_ok(mbsr_sid_write(flex, NULL, NULL, &text, &error), &error);
    mbsr_flex_destroy(flex);
    for (int trial = 0; trial < 8 * 6 * 6; ++trial) {
        mbsr_sid_opt opt = mbsr_default_sid_opt();
        mbsr_sid_report *report;
        char *other = test_sid_scaled(text->text, blocks[trial % 8], trial / 8 % 2 ? "m1" : "m0",
                                      factors[trial / 16 % 6]);
        opt.change = (mbsr_sid_change)(trial / 96);
        if (mbsr_sid_read(other, strlen(other), NULL, &opt, &flex, &report, &error) == MBSR_OK) {
            mbsr_flex_def data;
            assert_int_equal(mbsr_flex_definition(flex, &data), MBSR_OK);
            assert_finite(81, data.P);
            assert_finite(27, data.P0);
            assert_finite(9, data.Ct0);
            assert_true(!strstr(report->text, "nan") && !strstr(report->text, "inf"));
            mbsr_sid_report_destroy(report);
            mbsr_flex_destroy(flex);
        } else {
            assert_true(error.text[0] != '\0');
        }
        free(other);
    }
    mbsr_sid_text_destroy(text);
}

static void nothing_comes_of_null(void **state)
{
    (void)state;
    mbsr_fe_input *input;
    mbsr_flex *flex;
    for (size_t k = 0; k < sizeof functions / sizeof *functions; ++k)
        assert_int_equal(strncmp(functions[k], "mbsr_", 5), 0);
    mbsr_fe_report_destroy(NULL);
    mbsr_fe_input_destroy(NULL);
    mbsr_sid_report_destroy(NULL);
    mbsr_sid_text_destroy(NULL);
    assert_int_not_equal(mbsr_default_fe_def().cookie, 0);
    assert_int_not_equal(mbsr_default_sid_opt().cookie, 0);
    assert_int_equal(mbsr_sid_write(NULL, NULL, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sid_read(NULL, 0, NULL, NULL, &flex, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_fe_read(NULL, NULL, &input, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_fe_reduce(NULL, &flex, NULL, NULL), MBSR_ERR_NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_that_is_not_finite_passes),
        cmocka_unit_test(sid_files),
        cmocka_unit_test(nothing_comes_of_null),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
