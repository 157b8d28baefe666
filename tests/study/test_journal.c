/* Journals of studies: what is written is read again, wherever the writer was killed.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE
#include "close.h"

#include <mbsrank/study.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char TEXT[] = "sample random 20\nvary a 0 1\nkeep x at 1 2 3\n";

typedef struct desk {
    mbsr_study *study;
    char folder[64], path[2][128];
} desk;

static int lay_desk(void **state)
{
    static desk d;
    strcpy(d.folder, "journal_XXXXXX");
    assert_non_null(mkdtemp(d.folder));
    for (int k = 0; k < 2; ++k)
        snprintf(d.path[k], sizeof d.path[k], "%s/%d.journal", d.folder, 2 * k);
    *state = &d;
    return mbsr_study_read(TEXT, strlen(TEXT), NULL, NULL, &d.study, NULL);
}

static int clear_desk(void **state)
{
    desk *d = *state;
    for (int k = 0; k < 2; ++k) unlink(d->path[k]);
    rmdir(d->folder);
    mbsr_study_destroy(d->study);
    return 0;
}

static int try_open(const desk *d, int writer, uint64_t key, mbsr_journal **j, mbsr_error *error)
{
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    opt.folder = d->folder;
    opt.writer = writer;
    opt.key = key;
    return mbsr_journal_open(&opt, d->study, j, error);
}

static mbsr_journal *open_journal(const desk *d, int writer)
{
    mbsr_journal *j;
    mbsr_error error;
    if (try_open(d, writer, 7, &j, &error)) fail_msg("%s", error.text);
    return j;
}

static void add(mbsr_journal *j, long run, mbsr_outcome outcome, double first)
{
    const double value[3] = {first, NAN, -0.0};
    mbsr_error error;
    const mbsr_study_result result = {.run = run,
                                      .outcome = outcome,
                                      .status = outcome ? MBSR_NOT_FINITE : MBSR_OK,
                                      .steps = 10 * run,
                                      .value = outcome ? NULL : value,
                                      .text = outcome ? "why not" : NULL};
    if (mbsr_journal_add(j, &result, &error)) fail_msg("%s", error.text);
}

static mbsr_study_result get(mbsr_journal *j, long run)
{
    static double value[3];
    static char text[MBSR_TEXT_SIZE];
    mbsr_study_result result;
    mbsr_error error;
    if (mbsr_journal_get(j, run, value, text, &result, &error)) fail_msg("%s", error.text);
    return result;
}

static void runs_of_all_writers_are_read_again(void **state)
{
    const desk *d = *state;
    mbsr_journal *first = open_journal(d, 0), *second = open_journal(d, 2);
    add(first, 3, MBSR_RUN_DONE, 1.5);
    add(first, 5, MBSR_RUN_FAILED, 0.0);
    add(second, 4, MBSR_RUN_DONE, 2.5);
    assert_int_equal(get(first, 3).steps, 30);
    assert_false(mbsr_journal_has(first, 4)); /* not since it was opened */
    assert_int_equal(mbsr_journal_close(second, 1), MBSR_OK);
    assert_int_equal(mbsr_journal_close(first, 0), MBSR_OK);
    mbsr_journal *all = open_journal(d, -1);
    assert_true(get(all, 3).value[0] == 1.5 && get(all, 4).value[0] == 2.5);
    const mbsr_study_result done = get(all, 4);
    assert_true(isnan(done.value[1]) && signbit(done.value[2]));
    assert_int_equal(done.steps, 40);
    const mbsr_study_result failed = get(all, 5);
    assert_int_equal(failed.outcome, MBSR_RUN_FAILED);
    assert_int_equal(failed.status, MBSR_NOT_FINITE);
    assert_string_equal(failed.text, "why not");
    assert_true(isnan(failed.value[0]));
    assert_int_equal(get(all, 6).outcome, MBSR_RUN_MISSING);
    assert_true(mbsr_journal_has(all, 5));
    assert_false(mbsr_journal_has(all, 6));
    assert_false(mbsr_journal_has(all, 20));
    assert_false(mbsr_journal_has(NULL, 0));
    mbsr_journal_close(all, 0);
    mbsr_journal_close(NULL, 0);
}

static void a_run_ended_by_time_gives_way_and_others_count_once(void **state)
{
    const desk *d = *state;
    mbsr_journal *j = open_journal(d, 0);
    add(j, 1, MBSR_RUN_TIME, 0.0);
    assert_int_equal(mbsr_journal_outcome(j, 1), MBSR_RUN_TIME);
    assert_false(mbsr_journal_has(j, 1));
    add(j, 1, MBSR_RUN_DONE, 4.0);
    add(j, 1, MBSR_RUN_TIME, 0.0);
    add(j, 1, MBSR_RUN_DONE, 5.0);
    assert_true(get(j, 1).value[0] == 4.0);
    mbsr_journal_close(j, 0);
    j = open_journal(d, 2); /* which reads what 0 has written */
    assert_true(mbsr_journal_has(j, 1));
    assert_true(get(j, 1).value[0] == 4.0);
    mbsr_journal_close(j, 0);
}

static long size_of(const char *path)
{
    struct stat s;
    assert_int_equal(stat(path, &s), 0);
    return (long)s.st_size;
}

/* At every byte: the head, fixed parts, numbers, texts. */
static void a_writer_killed_anywhere_goes_on_behind_the_last_whole_run(void **state)
{
    const desk *d = *state;
    for (long cut = -1;; ++cut) {
        unlink(d->path[0]);
        mbsr_journal *j = open_journal(d, 0);
        add(j, 0, MBSR_RUN_DONE, 10.0);
        mbsr_journal_close(j, 0);
        const long one = size_of(d->path[0]);
        j = open_journal(d, 0);
        add(j, 1, MBSR_RUN_FAILED, 0.0);
        mbsr_journal_close(j, 0);
        const long two = size_of(d->path[0]);
        if (cut >= two) break;
        if (cut >= 0) assert_int_equal(truncate(d->path[0], cut), 0);
        j = open_journal(d, -1); /* reads it as it is */
        assert_int_equal(mbsr_journal_has(j, 0), cut < 0 || cut >= one);
        assert_int_equal(mbsr_journal_has(j, 1), cut < 0);
        mbsr_journal_close(j, 0);
        j = open_journal(d, 0);
        add(j, 2, MBSR_RUN_DONE, 12.0);
        mbsr_journal_close(j, 0);
        j = open_journal(d, -1);
        assert_int_equal(mbsr_journal_has(j, 0), cut < 0 || cut >= one);
        assert_true(get(j, 2).value[0] == 12.0);
        mbsr_journal_close(j, 0);
    }
}

/* Each byte of a journal, changed: what is left are whole runs or a refusal. */
static void a_damaged_byte_is_noticed(void **state)
{
    const desk *d = *state;
    mbsr_journal *j = open_journal(d, 0);
    add(j, 0, MBSR_RUN_DONE, 10.0);
    add(j, 1, MBSR_RUN_FAILED, 0.0);
    mbsr_journal_close(j, 0);
    const long size = size_of(d->path[0]);
    for (long k = 0; k < size; ++k) {
        mbsr_error error;
        FILE *file = fopen(d->path[0], "r+b");
        assert_non_null(file);
        fseek(file, k, SEEK_SET);
        const int byte = fgetc(file);
        fseek(file, k, SEEK_SET);
        fputc(byte ^ 0x10, file);
        fclose(file);
        const int status = try_open(d, -1, 7, &j, &error);
        if (k < 64) {
            assert_int_equal(status, MBSR_ERR_MISMATCH);
            assert_null(j);
        } else {
            assert_int_equal(status, MBSR_OK);
            assert_false(mbsr_journal_has(j, 1));
            if (mbsr_journal_has(j, 0)) assert_true(get(j, 0).value[0] == 10.0);
            mbsr_journal_close(j, 0);
        }
        file = fopen(d->path[0], "r+b");
        fseek(file, k, SEEK_SET);
        fputc(byte, file);
        fclose(file);
    }
}

static void other_studies_and_wrong_use_are_refused(void **state)
{
    const desk *d = *state;
    mbsr_error error;
    mbsr_journal *j = open_journal(d, 0);
    add(j, 0, MBSR_RUN_DONE, 1.0);
    const mbsr_study_result wrong = {.run = 20, .outcome = MBSR_RUN_FAILED},
                            missing = {.outcome = MBSR_RUN_MISSING}, none = {.run = 1};
    assert_int_equal(mbsr_journal_add(j, &wrong, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_journal_add(j, &missing, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_journal_add(j, &none, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_add(NULL, &none, NULL), MBSR_ERR_NULL);
    mbsr_journal_close(j, 0);
    j = open_journal(d, -1);
    const mbsr_study_result failed = {.run = 1, .outcome = MBSR_RUN_FAILED};
    assert_int_equal(mbsr_journal_add(j, &failed, &error), MBSR_ERR_SEQUENCE);
    mbsr_journal_close(j, 0);
    assert_int_equal(try_open(d, -1, 8, &j, &error), MBSR_ERR_MISMATCH);
    assert_non_null(strstr(error.text, "belongs to another study"));
    assert_int_equal(try_open(d, 0, 8, &j, &error), MBSR_ERR_MISMATCH);
    assert_null(j);
    FILE *file = fopen(d->path[1], "wb");
    for (int k = 0; k < 100; ++k) fputc('x', file);
    fclose(file);
    assert_int_equal(try_open(d, 0, 7, &j, &error), MBSR_ERR_MISMATCH);
    assert_non_null(strstr(error.text, "is no journal"));
    mbsr_journal_opt opt = {0};
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_NO_DEFAULT);
    opt = mbsr_default_journal_opt();
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_NULL);
    opt.folder = "/nowhere/at/all";
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_FILE);
    assert_non_null(strstr(error.text, "/nowhere/at/all cannot be made"));
    opt.writer = -2;
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_VALUE);
    opt.writer = 65536;
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_VALUE);
    static char far[5000];
    memset(far, 'a', sizeof far - 1);
    opt.writer = 0, opt.folder = far;
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_journal_open(&opt, d->study, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_close(NULL, 1), MBSR_OK);
}

/* A journal without a writer has no runs where there is no folder, and none beyond those of the
 * study; files of other names are no journals. */
static void what_is_not_there_is_missing(void **state)
{
    const desk *d = *state;
    static const char *const others[] = {"0.journals", "x.journal",     ".journal",
                                         "01.journal", "70000.journal", "3journal"};
    enum { OTHERS = sizeof others / sizeof *others };
    mbsr_journal *j;
    mbsr_error error;
    char path[OTHERS][160], text[MBSR_TEXT_SIZE];
    double value[3];
    mbsr_study_result result;
    for (int k = 0; k < OTHERS; ++k) {
        snprintf(path[k], sizeof path[k], "%s/%s", d->folder, others[k]);
        FILE *to = fopen(path[k], "w");
        assert_non_null(to);
        fputs("this is no journal", to);
        fclose(to);
    }
    j = open_journal(d, -1);
    assert_int_equal(mbsr_journal_outcome(j, 0), MBSR_RUN_MISSING);
    assert_int_equal(mbsr_journal_outcome(j, -1), MBSR_RUN_MISSING);
    assert_int_equal(mbsr_journal_outcome(j, 20), MBSR_RUN_MISSING);
    assert_int_equal(mbsr_journal_outcome(NULL, 0), MBSR_RUN_MISSING);
    assert_int_equal(mbsr_journal_get(j, 20, value, text, &result, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_journal_get(j, -1, value, text, &result, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_journal_get(j, 0, NULL, text, &result, &error), MBSR_ERR_NULL);
    assert_int_equal(get(j, 0).outcome, MBSR_RUN_MISSING);
    result = (mbsr_study_result){.run = -1, .outcome = MBSR_RUN_TIME};
    assert_int_equal(mbsr_journal_add(j, &result, &error), MBSR_ERR_ID);
    result.run = 20;
    assert_int_equal(mbsr_journal_add(j, &result, &error), MBSR_ERR_ID);
    result.run = 0;
    assert_int_equal(mbsr_journal_add(j, &result, &error), MBSR_ERR_SEQUENCE);
    result.outcome = MBSR_RUN_MISSING;
    assert_int_equal(mbsr_journal_add(j, &result, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_journal_close(j, 1), MBSR_OK);
    for (int k = 0; k < OTHERS; ++k) unlink(path[k]);
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    opt.folder = "nowhere_at_all", opt.writer = -1;
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_OK);
    assert_int_equal(mbsr_journal_has(j, 0), 0);
    assert_int_equal(mbsr_journal_close(j, 0), MBSR_OK);
    opt.folder = d->path[0], opt.writer = 0; /* a file, no folder */
    FILE *to = fopen(d->path[0], "w");
    assert_non_null(to);
    fclose(to);
    assert_int_equal(mbsr_journal_open(&opt, d->study, &j, &error), MBSR_ERR_FILE);
}

static void pointers_that_are_missing(void **state)
{
    const desk *d = *state;
    mbsr_journal *j = open_journal(d, 0), *none;
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    double value[3];
    char text[MBSR_TEXT_SIZE];
    mbsr_study_result result = {.run = 1, .outcome = MBSR_RUN_DONE};
    opt.folder = d->folder, opt.writer = 1;
    assert_int_equal(mbsr_journal_open(NULL, d->study, &none, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_open(&opt, NULL, &none, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_open(&opt, d->study, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_add(j, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_add(j, &result, NULL), MBSR_ERR_NULL); /* its value */
    assert_int_equal(mbsr_journal_get(NULL, 0, value, text, &result, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_get(j, 0, NULL, text, &result, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_get(j, 0, value, NULL, &result, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_journal_get(j, 0, value, text, NULL, NULL), MBSR_ERR_NULL);
    mbsr_journal_close(j, 0);
}

/* What cannot be read is refused: its runs would be done again, and a writer would cut them off. */
static void what_cannot_be_read_is_refused(void **state)
{
    const desk *d = *state;
    mbsr_journal *j;
    mbsr_error error;
    assert_int_equal(mkdir(d->path[1], 0777), 0); /* opened, but not read */
    for (int writer = -1; writer < 1; ++writer) {
        assert_int_equal(try_open(d, writer, 7, &j, &error), MBSR_ERR_FILE);
        assert_null(j);
        assert_non_null(strstr(error.text, "2.journal cannot be read: "));
    }
    assert_int_equal(rmdir(d->path[1]), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(runs_of_all_writers_are_read_again, lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(a_run_ended_by_time_gives_way_and_others_count_once,
                                        lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(a_writer_killed_anywhere_goes_on_behind_the_last_whole_run,
                                        lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(a_damaged_byte_is_noticed, lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(other_studies_and_wrong_use_are_refused, lay_desk,
                                        clear_desk),
        cmocka_unit_test_setup_teardown(what_is_not_there_is_missing, lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(pointers_that_are_missing, lay_desk, clear_desk),
        cmocka_unit_test_setup_teardown(what_cannot_be_read_is_refused, lay_desk, clear_desk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
