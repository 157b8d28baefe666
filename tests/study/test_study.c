/* What studies are read from, and the values that they choose.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"

#include <mbsrank/study.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mbsr_study *read_study(const char *text)
{
    mbsr_study *s;
    mbsr_error error;
    if (mbsr_study_read(text, strlen(text), "a.study", NULL, &s, &error))
        fail_msg("%s", error.text);
    return s;
}

static double value_of(const mbsr_study *s, long run, int k)
{
    double value[MBSR_SOBOL_PARAMETERS];
    assert_int_equal(mbsr_study_values(s, run, value), MBSR_OK);
    return value[k];
}

/* A study with n parameters p0, p1 ... from 0 to 1. */
static mbsr_study *unit_study(const char *sample, int n)
{
    char text[4096];
    int length = snprintf(text, sizeof text, "sample %s\n", sample);
    for (int k = 0; k < n; ++k)
        length += snprintf(text + length, sizeof text - (size_t)length, "vary p%d 0 1\n", k);
    snprintf(text + length, sizeof text - (size_t)length, "keep x max\n");
    return read_study(text);
}

static void a_file_says_what_is_varied_and_kept(void **state)
{
    (void)state;
    mbsr_study *s = read_study("# a comment\n"
                               "model \"my car.xml\"  # another\r\n"
                               "run --t-end 2 --start pushed\n"
                               "limit 1000 steps\nlimit 2.5 s\n"
                               "sample latin 10 seed 18446744073709551615\n"
                               "vary a.mass 1 2 unit kg\n"
                               "vary b.stiffness 1e3 1e5 log\n"
                               "\n"
                               "vary c normal -3 0.5\n"
                               "keep q at 0 0.5 1e0 unit m\n"
                               "keep q every 0.5 to 2\n"
                               "keep u max\nkeep u min unit m/s\nkeep u mean\n"
                               "keep u rises -0.1\nkeep u falls 2");
    assert_string_equal(s->model, "my car.xml");
    assert_int_equal(s->model_line, 2);
    assert_int_equal(s->words, 4);
    assert_string_equal(s->word[3], "pushed");
    assert_int_equal(s->max_steps, 1000);
    assert_true(s->max_time == 2.5);
    assert_int_equal(s->sampling, MBSR_SAMPLING_LATIN);
    assert_string_equal(mbsr_sampling_name(s->sampling), "latin");
    assert_null(mbsr_sampling_name((mbsr_sampling)17));
    assert_true(s->seed == UINT64_MAX);
    assert_int_equal(s->runs, 10);
    assert_int_equal(s->parameters, 3);
    assert_string_equal(s->parameter[0].unit, "kg");
    assert_int_equal(s->parameter[1].spread, MBSR_SPREAD_LOG);
    assert_string_equal(s->parameter[1].unit, "");
    assert_int_equal(s->parameter[2].spread, MBSR_SPREAD_NORMAL);
    assert_int_equal(s->parameter[2].line, 10);
    assert_int_equal(s->outputs, 7);
    assert_int_equal(s->output[0].times, 3);
    assert_true(s->output[0].time[2] == 1.0);
    assert_string_equal(s->output[0].unit, "m");
    assert_int_equal(s->output[1].times, 5);
    assert_true(s->output[1].time[4] == 2.0);
    assert_int_equal(s->output[1].first, 3);
    assert_int_equal(s->output[5].kind, MBSR_KEEP_RISES);
    assert_true(s->output[5].level == -0.1);
    assert_int_equal(s->output[6].first, 12);
    assert_int_equal(s->numbers, 13);
    mbsr_study_destroy(s);
    mbsr_study_destroy(NULL);
}

static void what_is_wrong_is_refused_with_line_and_word(void **state)
{
    static const struct {
        const char *text, *said;
    } wrong[] = {
        {"", "no line of sample"},
        {"sample sobol 4\nvary a 0 1\n", "nothing is kept"},
        {"sample sobol 4\nkeep q max\n", "a.study:1: nothing is varied"},
        {"sample sobol 4\nvary a 0 1\nfetch q max\n", "a.study:3: no line of a study begins"},
        {"sample halton 4\n", "a.study:1: there is no sampling 'halton'"},
        {"sample sobol\n", "a number is missing behind 'sobol'"},
        {"sample sobol 4.5\n", "no whole number in its range: '4.5'"},
        {"sample sobol 1e10\n", "no whole number"},
        {"sample latin 2e7\n", "no whole number"},
        {"sample random 4 seed -1\n", "seed needs a whole number"},
        {"sample random 4 seed 18446744073709551616\n", "seed needs a whole number"},
        {"sample random 4 seeds 1\n", "does not take 'seeds'"},
        {"sample grid\nsample list\n", "a.study:2: there is a second line of sample"},
        {"vary a 0 1\n", "sample comes before vary"},
        {"values 1\n", "values are for sample list"},
        {"sample list\nvalues 1\n", "vary comes before values"},
        {"sample sobol 4\nvary a 0 2x\n", "no number: '2x'"},
        {"sample sobol 4\nvary a 0 1e301\n", "a number is beyond 1e300 of 'a'"},
        {"sample sobol 4\nvary a 0\n", "a number is missing behind '0'"},
        {"sample sobol 4\nvary a 0 much\n", "no number: 'much'"},
        {"sample sobol 4\nvary a 0 nan\n", "no number: 'nan'"},
        {"sample sobol 4\nvary a 1 1\n", "range is empty of 'a'"},
        {"sample sobol 4\nvary a 0 1 log\n", "log needs positive numbers for 'a'"},
        {"sample sobol 4\nvary a normal 0 0\n", "deviation is not positive of 'a'"},
        {"sample sobol 4\nvary a 0 1 levels 3\n", "levels are for a grid"},
        {"sample sobol 4\nvary a 0 1 cubic\n", "does not take 'cubic'"},
        {"sample sobol 4\nvary a 0 1\nvary a 0 1\n", "a.study:3: varied twice: 'a'"},
        {"sample grid\nvary a 0 1\n", "a grid needs levels of 'a'"},
        {"sample grid\nvary a 0 1 levels 0\n", "no whole number"},
        {"sample grid\nvary a 0 1 levels 1e5\nvary b 0 1 levels 1e5\nkeep q max\n", "1e9 runs"},
        {"sample list\nvary a\nkeep q max\n", "a list needs lines of values"},
        {"sample list\nvary a\nvalues 1 2\n", "not as many values"},
        {"sample list\nvary a\nvalues 1\nvary b\n", "vary comes before values"},
        {"sample list\nvary a 0 1\n", "lines of their own"},
        {"sample sobol 4\nvary a 0 1\nvalues 1\n", "values are for sample list"},
        {"keep q\n", "keep needs a column"},
        {"keep q most\n", "keep does not know 'most'"},
        {"keep q max 3\n", "keep does not take '3'"},
        {"keep q rises\n", "a number is missing behind 'rises'"},
        {"keep q at 1 1\n", "times must be positive and ascend, of column 'q'"},
        {"keep q at -1\n", "times must be positive"},
        {"keep q at\n", "at needs times"},
        {"keep q every 0.1\n", "number is missing"},
        {"keep q every 0 to 1\n", "not positive: '0'"},
        {"keep q every 0.1 up 1\n", "every H to T"},
        {"keep q every 1e-9 to 1\n", "more than 1e6 times"},
        {"limit 5\n", "limit is a number of steps"},
        {"limit 0 s\n", "not positive"},
        {"limit 5 steps\nlimit 6 steps\n", "each once"},
        {"model\n", "model needs one path"},
        {"model a\nmodel b\n", "second model"},
        {"run\nrun\n", "second line of run"},
        {"model \"a\nrun\n", "a.study:1: a quote does not end"}};
    (void)state;
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        mbsr_study *s;
        mbsr_error error;
        const int status =
            mbsr_study_read(wrong[k].text, strlen(wrong[k].text), "a.study", NULL, &s, &error);
        if (status != MBSR_ERR_FILE || s || !strstr(error.text, wrong[k].said))
            fail_msg("%s\n'%s', not '%s'", wrong[k].text, error.text, wrong[k].said);
    }
    mbsr_study *s;
    assert_int_equal(mbsr_study_read(NULL, 0, NULL, NULL, &s, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_study_read("", 0, NULL, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_study_read("a\0b", 3, NULL, NULL, &s, NULL), MBSR_ERR_FILE);
}

static void one_parameter_more_than_sobol_has_is_refused(void **state)
{
    char text[4096];
    mbsr_study *s;
    mbsr_error error;
    (void)state;
    int length = snprintf(text, sizeof text, "sample sobol 4\n");
    for (int k = 0; k <= MBSR_SOBOL_PARAMETERS; ++k)
        length += snprintf(text + length, sizeof text - (size_t)length, "vary p%d 0 1\n", k);
    assert_int_equal(mbsr_study_read(text, (size_t)length, NULL, NULL, &s, &error), MBSR_ERR_FILE);
    assert_non_null(strstr(error.text, "study:66: sobol is for 64"));
}

/* Against scipy.stats.qmc.Sobol(64, scramble=False) of SciPy 1.10. */
static void sobol_points_are_those_of_joe_and_kuo(void **state)
{
    static const int columns[] = {0, 1, 2, 5, 19, 40, 63};
    static const struct {
        long run;
        double z[7];
    } points[] = {
        {1, {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5}},
        {2, {0.75, 0.25, 0.25, 0.75, 0.25, 0.25, 0.75}},
        {5, {0.875, 0.875, 0.125, 0.625, 0.625, 0.375, 0.625}},
        {17, {0.59375, 0.96875, 0.96875, 0.46875, 0.53125, 0.90625, 0.59375}},
        {100, {0.4140625, 0.2578125, 0.7734375, 0.7421875, 0.3359375, 0.7109375, 0.6484375}},
        {199,
         {0.14453125, 0.57421875, 0.97265625, 0.74609375, 0.61328125, 0.51953125, 0.54296875}}};
    (void)state;
    mbsr_study *s = unit_study("sobol 256", MBSR_SOBOL_PARAMETERS);
    for (size_t k = 0; k < sizeof points / sizeof *points; ++k)
        for (int l = 0; l < 7; ++l)
            assert_true(fabs(value_of(s, points[k].run, columns[l]) - points[k].z[l]) < 2e-10);
    mbsr_study_destroy(s);
}

/* Each of n equal parts of each range has one run. */
static void check_parts(const char *sample, int n, int parameters)
{
    mbsr_study *s = unit_study(sample, parameters);
    for (int k = 0; k < parameters; ++k) {
        char seen[1024] = "";
        for (long run = 0; run < n; ++run) {
            const int part = (int)(value_of(s, run, k) * n);
            assert_in_range(part, 0, n - 1);
            assert_int_equal(seen[part]++, 0);
        }
    }
    mbsr_study_destroy(s);
}

static void sobol_points_and_latin_hypercubes_have_a_run_in_every_part(void **state)
{
    (void)state;
    check_parts("sobol 1024", 1024, MBSR_SOBOL_PARAMETERS);
    check_parts("sobol 1024 seed 7", 1024, MBSR_SOBOL_PARAMETERS);
    check_parts("latin 1000 seed 7", 1000, 30);
    check_parts("latin 1", 1, 2);
}

static double correlation(const mbsr_study *s, int k, int l)
{
    double sum = 0.0;
    for (long run = 0; run < s->runs; ++run)
        sum += (value_of(s, run, k) - 0.5) * (value_of(s, run, l) - 0.5);
    return 12.0 * sum / (double)s->runs;
}

static void parameters_are_independent_and_seeds_differ(void **state)
{
    static const char *const samples[] = {"random 4000 seed 3", "latin 4000 seed 3",
                                          "sobol 4096 seed 3"};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        mbsr_study *s = unit_study(samples[k], 5), *other;
        char text[40];
        assert_true(fabs(correlation(s, 0, 0) - 1.0) < 0.07);
        for (int l = 1; l < 5; ++l) assert_true(fabs(correlation(s, 0, l)) < 0.07);
        snprintf(text, sizeof text, "%.*s4", (int)strlen(samples[k]) - 1, samples[k]);
        other = unit_study(text, 5);
        assert_true(value_of(s, 17, 2) != value_of(other, 17, 2));
        mbsr_study_destroy(other);
        mbsr_study_destroy(s);
    }
}

/* SplitMix64 from state 0 gives 0xe220a8397b1dcdaf first (Vigna's reference code). */
static void random_numbers_follow_the_documented_formula(void **state)
{
    (void)state;
    mbsr_study *s = unit_study("random 10 seed 5", 2);
    for (int k = 0; k < 2; ++k) {
        uint64_t z = 5 + (uint64_t)(k + 1) * UINT64_C(0x9e3779b97f4a7c15);
        for (int twice = 0; twice < 2; ++twice) {
            if (twice) z += 10 * UINT64_C(0x9e3779b97f4a7c15); /* run 9 */
            z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
            z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
            z ^= z >> 31;
        }
        assert_true(value_of(s, 9, k) == ((double)(z >> 11) + 0.5) / 9007199254740992.0);
    }
    mbsr_study_destroy(s);
}

static void spreads_turn_numbers_into_values(void **state)
{
    (void)state;
    mbsr_study *s = read_study("sample grid\nvary a -1 3 levels 3\nvary b 1 100 log levels 3\n"
                               "vary c normal 0 1 levels 20\nvary d 2 4 levels 1\nkeep q max\n");
    assert_int_equal(s->runs, 180);
    const double a[] = {-1.0, 1.0, 3.0}, b[] = {1.0, 10.0, 100.0};
    for (long run = 0; run < 180; ++run) {
        assert_true(fabs(value_of(s, run, 0) - a[run / 60]) < 1e-15);
        assert_true(fabs(value_of(s, run, 1) - b[run / 20 % 3]) < 1e-13);
        assert_true(value_of(s, run, 3) == 3.0);
    }
    /* Phi(1.9599639845400545) = 0.975, the last of 20 parts of a normal distribution */
    assert_true(fabs(value_of(s, 19, 2) - 1.9599639845400545) < 1e-14);
    assert_true(fabs(value_of(s, 0, 2) + 1.9599639845400545) < 1e-14);
    double value[4];
    assert_int_equal(mbsr_study_values(s, 180, value), MBSR_ERR_ID);
    assert_int_equal(mbsr_study_values(s, -1, value), MBSR_ERR_ID);
    assert_int_equal(mbsr_study_values(s, 0, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_study_values(NULL, 0, value), MBSR_ERR_NULL);
    mbsr_study_destroy(s);
    s = read_study("sample list\nvary a unit kg\nvary b\nkeep q max\nvalues 1 2\nvalues -3 4e1\n");
    assert_int_equal(s->runs, 2);
    assert_true(value_of(s, 1, 0) == -3.0 && value_of(s, 1, 1) == 40.0);
    assert_string_equal(s->parameter[0].unit, "kg");
    mbsr_study_destroy(s);
}

/* ---- memory ---- */

static void *allocate(void *user, size_t size)
{
    int *left = user;
    return (*left)-- > 0 ? malloc(size) : NULL;
}

static void release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static void without_memory_nothing_is_left(void **state)
{
    static const char text[] = "sample latin 100000\nvary a 0 1\nvary b 0 1\nkeep q every 1 to 9e5";
    (void)state;
    int least = 0;
    for (;; ++least) {
        int left = least;
        const mbsr_allocator allocator = {allocate, release, &left};
        mbsr_study *s;
        mbsr_error error;
        const int status = mbsr_study_read(text, sizeof text - 1, NULL, &allocator, &s, &error);
        if (!status) {
            mbsr_study_destroy(s);
            break;
        }
        assert_int_equal(status, MBSR_ERR_NO_MEMORY);
        assert_null(s);
        assert_int_equal(error.status, MBSR_ERR_NO_MEMORY);
    }
    assert_in_range(least, 3, 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_says_what_is_varied_and_kept),
        cmocka_unit_test(what_is_wrong_is_refused_with_line_and_word),
        cmocka_unit_test(one_parameter_more_than_sobol_has_is_refused),
        cmocka_unit_test(sobol_points_are_those_of_joe_and_kuo),
        cmocka_unit_test(sobol_points_and_latin_hypercubes_have_a_run_in_every_part),
        cmocka_unit_test(parameters_are_independent_and_seeds_differ),
        cmocka_unit_test(random_numbers_follow_the_documented_formula),
        cmocka_unit_test(spreads_turn_numbers_into_values),
        cmocka_unit_test(without_memory_nothing_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
