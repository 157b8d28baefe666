/* Steps of fixed size of mechanisms of everything at once: each goes through, rigid loops stay
 * closed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "medley.h"

#include <stdlib.h>

/* Largest gap of the stepper's state. */
static double gap_of(const medley *s, mbsr_stepper *stepper)
{
    mbsr_closure_report report;
    double t, *q = calloc((size_t)s->nq + 1, sizeof *q);
    assert_non_null(q);
    assert_int_equal(mbsr_stepper_motion(stepper, &t, q, NULL), MBSR_OK);
    assert_ok(mbsr_closures_report(s->m, s->d, t, q, &report, NULL, NULL), mbsr_data_error(s->d));
    free(q);
    return report.gap;
}

/* 0 where there is no such mechanism, or no start of it. */
static int run(uint64_t seed)
{
    const medley_choice choice = medley_choose(seed);
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_stepper *stepper;
    mbsr_error error;
    medley s;
    if (!medley_make(&s, &choice)) {
        medley_free(&s);
        return 0;
    }
    opt.order = 1 + (int)(seed % 2);
    assert_ok(mbsr_stepper_create(s.m, s.d, &opt, &stepper, &error), &error);
    const int started = mbsr_stepper_start(stepper, s.t, s.q, s.u) == MBSR_OK;
    for (int k = 0; k < 20 && started; ++k) {
        if (mbsr_stepper_step(stepper))
            fail_msg("seed %d: %s", (int)seed, mbsr_stepper_error(stepper)->text);
        if (s.position_rows > 0 && !(choice.stiff > 0.0)) assert_true(gap_of(&s, stepper) < 1e-8);
    }
    mbsr_stepper_destroy(stepper);
    medley_free(&s);
    return started;
}

static void mechanisms_of_all_sorts_are_stepped(void **state)
{
    (void)state;
    const int seeds = test_seeds_short(20, 60);
    int started = 0;
    for (int k = 0; k < seeds; ++k) started += run(101 + (uint64_t)k);
    assert_true(started > seeds / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(mechanisms_of_all_sorts_are_stepped)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
