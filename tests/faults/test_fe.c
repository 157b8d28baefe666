/* Finite elements are reduced, SID files read and written, where each place of the component fe at
 * which a status is taken fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "faults.h"

#include "../fe/solid.h"
#include "../fuzz/small_sid.h"

#include <mbsrank/sid.h>

enum { NUMBERS = 64 };

static double out[NUMBERS];
static test_solid *solid;
static mbsr_flex *bar;

static void take(const mbsr_flex *flex)
{
    mbsr_flex_def def;
    if (mbsr_flex_definition(flex, &def)) return;
    out[0] = def.mass, out[1] = def.modes;
    for (int k = 0; k < def.modes && k < 8; ++k) out[2 + k] = def.K[k * (def.modes + 1)];
}

static int is_reduced(void *user)
{
    mbsr_flex *flex = NULL;
    mbsr_fe_report *report = NULL;
    (void)user;
    const int status = mbsr_fe_reduce(&solid->def, &flex, &report, NULL);
    if (!status) take(flex);
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    return status;
}

static int is_written(void *user)
{
    mbsr_sid_text *text = NULL;
    mbsr_flex *flex = NULL;
    mbsr_sid_report *report = NULL;
    (void)user;
    int status = mbsr_sid_write(bar, NULL, NULL, &text, NULL);
    if (!status) out[20] = (double)text->size;
    if (!status) status = mbsr_sid_read(text->text, text->size, NULL, NULL, &flex, &report, NULL);
    if (!status) take(flex);
    mbsr_sid_text_destroy(text);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(flex);
    return status;
}

static int is_read(void *user)
{
    mbsr_flex *flex = NULL;
    mbsr_sid_report *report = NULL;
    mbsr_sid_opt opt = mbsr_default_sid_opt();
    (void)user;
    opt.change = MBSR_SID_COUPLING;
    const int status =
        mbsr_sid_read(test_small_sid, strlen(test_small_sid), NULL, &opt, &flex, &report, NULL);
    if (!status) take(flex);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(flex);
    return status;
}

static long each(const char *name, int (*call)(void *user))
{
    const test_faults_act act = {name, call, NULL, out, NUMBERS, 1e-9, 1};
    return test_faults_each(&act);
}

static void of_a_bar(void **state)
{
    (void)state;
    long failed = 0;
    solid = test_bar(4, 1, 1);
    for (int solver = 0; solver <= test_solvers; ++solver) {
        solid->def.solver = (mbsr_fe_solver)solver;
        for (int free = 0; free < 2; ++free) {
            solid->def.free = free;
            solid->def.modes = 4;
            failed += each("is reduced", is_reduced);
        }
    }
    assert_int_equal(mbsr_fe_reduce(&solid->def, &bar, NULL, NULL), MBSR_OK);
    failed += each("is written", is_written);
    failed += each("is read", is_read);
    mbsr_flex_destroy(bar);
    test_solid_destroy(solid);
    assert_in_range(failed, 30, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_a_bar)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
