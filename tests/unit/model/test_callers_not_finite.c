/* Functions of the caller's give a number that is not finite at each of their calls in turn: what
 * was called says so, or its own numbers are finite; and the next call gives the same bits as if
 * nothing had been.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "duration.h"
#include "expect.h"
#include "kinds.h"
#include "medley.h"
#include "spoil.h"

#include <string.h>

enum { SIZE = TEST_ACTS_PARTS * TEST_ACTS_PART };

static const double odd[] = {NAN, INFINITY, -INFINITY, 1e300};

static double good[SIZE];

static void runs_well(test_acts_scene *s, const test_acts *a, bool first)
{
    double *to = first ? good : s->out;
    memset(s->out, 0, sizeof s->out);
    assert_ok(a->act(s), mbsr_data_error(s->data));
    if (first) memcpy(to, s->out, sizeof good);
    if (memcmp(good, s->out, sizeof good) != 0)
        fail_msg("%s: other numbers after a call was not finite", a->name);
}

static void one_is_odd(test_acts_scene *s, const test_acts *a, const char *what, long call)
{
    memset(s->out, 0, sizeof s->out);
    const int status = a->act(s);
    for (int k = 0; k < SIZE && status == MBSR_OK; ++k)
        if (!isfinite(s->out[k]) && isfinite(good[k]))
            fail_msg("%s: %s: call %ld is not finite, nor is number %d", what, a->name, call, k);
}

/* The first calls, then ever fewer of them. */
static long next(long k)
{
    return k + 1 + (test_long() ? k / 8 : k);
}

/* Runs of a kind that take long are of other tests. */
static bool is_for_it(const test_acts *a)
{
    return strcmp(a->name, "has_small_masses") != 0;
}

static void of_functions(void **state)
{
    static const char *const what[] = {"open", "closed", "open, without mass",
                                       "closed, without mass"};
    (void)state;
    for (int k = 0; k < 4; ++k) {
        static test_acts_scene s;
        test_acts_make(&s, k & 1, (test_acts_slider)(k / 2));
        for (const test_acts *a = test_acts_table; a->name; ++a) {
            if (!(a->models & 1 << k) || !is_for_it(a)) continue;
            test_acts_of.asked = 0;
            runs_well(&s, a, true);
            const long calls = test_acts_of.asked;
            for (long call = 1; call <= calls && call < 1000; call = next(call)) {
                test_acts_of.asked = 0, test_acts_of.fail_at = call, test_acts_of.with = 0;
                test_acts_of.gives = odd[call % 4];
                one_is_odd(&s, a, what[k], call);
                test_acts_of.fail_at = 0;
            }
            runs_well(&s, a, false);
        }
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.model);
        assert_int_equal(test_acts_of.memory.live, 0);
    }
}

/* All acts that have an answer. */
static void all_are_odd(test_acts_scene *s, const char *what)
{
    for (const test_acts *a = test_acts_table; a->name; ++a) {
        if (!is_for_it(a)) continue;
        memset(s->out, 0, sizeof s->out);
        test_spoil_of = (test_spoil_counts){.asked = 0};
        if (a->act(s) != MBSR_OK) continue;
        const long calls = test_spoil_of.asked;
        runs_well(s, a, true);
        for (long call = 1; call <= calls && call < 2000; call = next(call)) {
            test_spoil_of = (test_spoil_counts){.at = call, .with = odd[call % 4]};
            one_is_odd(s, a, what, call);
        }
        test_spoil_of = (test_spoil_counts){.asked = 0};
        runs_well(s, a, false);
    }
}

/* A copy with tables of the caller's. */
static bool copy_is_odd(const mbsr_model *model, double t, const double *q, const double *u,
                        const char *what)
{
    static test_acts_scene s;
    mbsr_data *d = NULL;
    mbsr_model *m = test_spoil_copy(model);
    bool good_copy = m && !mbsr_model_finish(m) && !mbsr_data_create(m, &d, NULL);
    good_copy =
        good_copy && mbsr_model_nq(m) == mbsr_model_nq(model) && test_acts_take(&s, m, d, t, q, u);
    if (good_copy) all_are_odd(&s, what);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    test_spoil_end();
    return good_copy;
}

static void of_tables_in_trees(void **state)
{
    (void)state;
    int copies = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)(test_long() ? 24 : test_seeds(3, 6)); ++seed) {
        test_kinds_tree s;
        test_kinds_choice c = {.seed = seed, .bodies = 5, .plane = seed % 3 == 0};
        c.many = 0.3, c.massless = seed % 2 ? 0.2 : 0.0, c.springs = (int)(seed % 4);
        test_kinds_make(&s, c);
        copies += copy_is_odd(s.model, s.t, s.q, s.u, "a tree");
        test_kinds_free(&s);
    }
    assert_in_range(copies, 2, 1000);
}

static void of_tables_of_all_sorts(void **state)
{
    (void)state;
    int copies = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)(test_long() ? 32 : test_seeds(3, 5)); ++seed) {
        medley s;
        medley_choice c = medley_choose(seed);
        if (c.bodies > 6) c.bodies = 6;
        c.own = 0.0;
        if (medley_make(&s, &c)) copies += copy_is_odd(s.m, s.t, s.q, s.u, "all sorts");
        medley_free(&s);
    }
    assert_in_range(copies, 1, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_functions),
                                       cmocka_unit_test(of_tables_in_trees),
                                       cmocka_unit_test(of_tables_of_all_sorts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
