/* Studies are read, journals written and read again, parameters fitted, where each place fails at
 * which a status is taken, a piece of memory or the system asked.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE
#include "faults.h"

#include <mbsrank/fit.h>
#include <mbsrank/study.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { NUMBERS = 64, RUNS = 4, KEPT = 3 };

static double out[NUMBERS];

static const char text[] =
    "model \"car.xml\"\nrun --t-end 2 --start pushed\nlimit 100 steps\nsample sobol 4 seed 1\n"
    "vary a 0 1\nvary b 1 2 log unit kg\nvary c normal 5 1\nkeep x at 1 2\nkeep x max unit m\n";

static int is_read(void *user)
{
    mbsr_study *study = NULL;
    (void)user;
    int status = mbsr_study_read(text, sizeof text - 1, "a.study", NULL, &study, NULL);
    for (long run = 0; run < RUNS && !status; ++run)
        status = mbsr_study_values(study, run, out + 3 * run);
    if (!status) out[30] = study->numbers;
    mbsr_study_destroy(study);
    return status;
}

/* ---- journals ---- */

static mbsr_study *study;
static char folder[] = "faults_XXXXXX";

static int open_journal(int writer, mbsr_journal **journal)
{
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    opt.folder = folder, opt.writer = writer, opt.key = 5;
    return mbsr_journal_open(&opt, study, journal, NULL);
}

static int add_runs(mbsr_journal *j, long from, long to)
{
    const double value[KEPT] = {1.0, 2.0, (double)from};
    int status = MBSR_OK;
    for (long run = from; run < to && !status; ++run) {
        const mbsr_study_result result = {.run = run,
                                          .outcome = run % 2 ? MBSR_RUN_FAILED : MBSR_RUN_DONE,
                                          .steps = 7 * run,
                                          .value = value,
                                          .text = run % 2 ? "why not" : NULL};
        status = mbsr_journal_add(j, &result, NULL);
    }
    return status;
}

static int take_runs(mbsr_journal *j)
{
    double value[KEPT];
    char why[MBSR_TEXT_SIZE];
    int status = MBSR_OK;
    for (long run = 0; run < RUNS && !status; ++run) {
        mbsr_study_result result;
        status = mbsr_journal_get(j, run, value, why, &result, NULL);
        out[10 * run] = (double)result.steps, out[10 * run + 1] = (double)result.outcome;
        out[10 * run + 2] = (double)strlen(why);
        for (int k = 0; k < KEPT; ++k) out[10 * run + 3 + k] = isnan(value[k]) ? -1.0 : value[k];
    }
    return status;
}

static void forget(void)
{
    char path[64];
    for (int k = 0; k < 2; ++k) {
        snprintf(path, sizeof path, "%s/%d.journal", folder, k);
        unlink(path);
    }
}

/* Opened, runs added, all of them read if they are `wanted`, and closed whatever came. */
static int use_journal(int writer, long from, long to, bool wanted)
{
    mbsr_journal *j = NULL;
    int status = open_journal(writer, &j);
    if (status) return status;
    status = add_runs(j, from, to);
    if (!status && wanted) status = take_runs(j);
    const int closed = mbsr_journal_close(j, 1);
    return status ? status : closed;
}

/* By two writers, one of whom goes on; what is there is read again. */
static int is_kept(void *user)
{
    (void)user;
    test_faults_rest(true);
    forget();
    test_faults_rest(false);
    int status = use_journal(0, 0, 2, false);
    if (!status) status = use_journal(1, 2, 3, false);
    if (!status) status = use_journal(0, 3, 4, true);
    if (!status) status = use_journal(-1, 0, 0, true);
    return status;
}

/* ---- fits ---- */

static int misses(void *user, const double *p, double *r)
{
    (void)user;
    for (int k = 0; k < 8; ++k)
        r[k] = p[0] * exp(-p[1] * 0.3 * k) - exp(-0.25 * k) - 0.01 * (k % 3);
    return 0;
}

static int is_fitted(void *user)
{
    static const double start[2] = {0.7, 1.0};
    mbsr_fit_opt opt = mbsr_default_fit_opt();
    mbsr_fit *f = NULL;
    (void)user;
    opt.parameters = 2, opt.residuals = 8, opt.start = start, opt.residual = misses;
    const int status = mbsr_fit_create(&opt, &f, NULL);
    for (int k = 0; k < 2 && !status; ++k)
        out[k] = f->value[k], out[2 + k] = f->deviation[k], out[4 + k] = f->low[k];
    mbsr_fit_destroy(f);
    return status;
}

static bool everywhere(test_faults_list list, const char *caller)
{
    (void)list, (void)caller;
    return true;
}

static long each(const char *name, int (*call)(void *user))
{
    const test_faults_act act = {name, call, NULL, out, NUMBERS, 0.0, 0};
    assert_int_equal(call(NULL), MBSR_OK);
    return test_faults_each(&act);
}

static void of_studies(void **state)
{
    (void)state;
    test_faults_only(everywhere);
    long failed = each("is read", is_read) + each("is fitted", is_fitted);
    assert_int_equal(mbsr_study_read(text, sizeof text - 1, "a.study", NULL, &study, NULL),
                     MBSR_OK);
    assert_non_null(mkdtemp(folder));
    failed += each("is kept", is_kept);
    forget();
    assert_int_equal(rmdir(folder), 0);
    mbsr_study_destroy(study);
    test_faults_only(NULL);
    assert_in_range(failed, 20, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_studies)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
