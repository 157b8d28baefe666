/* The component study: values of parameters are finite over the widest ranges.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"

#include <mbsrank/study.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Values at the first, the middle and the last run, of three spreads. */
static int run_values(finite_subject *s)
{
    static const char *const samples[] = {"sobol 1000000000", "random 1000000000 seed 1",
                                          "latin 1000"};
    for (int k = 0; k < 3 && s->out[0]; ++k) {
        char text[400];
        mbsr_study *study;
        snprintf(text, sizeof text,
                 "sample %s\nvary a -1e300 1e300\nvary b 1e-300 1e300 log\n"
                 "vary c normal 1e300 1e300\nkeep x max\n",
                 samples[k]);
        assert_ok(mbsr_study_read(text, strlen(text), NULL, NULL, &study, NULL), NULL);
        const long run[] = {0, study->runs / 2, study->runs - 1};
        for (int l = 0; l < 3; ++l) {
            double value[3];
            assert_ok(mbsr_study_values(study, run[l], value), NULL);
            for (int j = 0; j < 3; ++j) {
                assert_true(isfinite(value[j]));
                s->out[0][0] = value[j];
            }
        }
        mbsr_study_destroy(study);
    }
    return s->out[0] ? MBSR_OK : MBSR_ERR_NULL;
}

static int of_study(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

/* Numbers of journals are those of their runs, NaN where there are none: test_journal.c. */
static const finite_row rows[] = {
    {"mbsr_default_fit_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_fit_create", NULL, NULL, 0, 0, 0, NULL}, /* test_fit.c */
    {"mbsr_fit_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_journal_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_add", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_close", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_get", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_has", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_open", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_journal_outcome", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_study_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_study_read", NULL, NULL, 0, 0, 0, NULL}, /* test_study.c */
    {"mbsr_sampling_name", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_study_values", run_values, NULL, 0, 0, 0, of_study},
};

static const mbsr_error *missing_output(const finite_subject *s)
{
    static const mbsr_error error = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                                     "mbsr_study_values: value is NULL"};
    (void)s;
    return &error;
}

static void the_widest_ranges(void **state)
{
    (void)state;
    finite_subject s = {.name = "a study", .error = missing_output};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k)
        assert_true(finite_try(&s, rows + k) > 0 || !rows[k].run);
    finite_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_widest_ranges)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
