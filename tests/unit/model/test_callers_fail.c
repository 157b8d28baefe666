/* Functions of the caller's fail at each of their calls in turn: what was called says so by their
 * status, nothing is lost, and the next call gives the same bits as if nothing had been.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "duration.h"
#include "expect.h"

#include <string.h>

/* The k-th call fails, alone or with all behind it. A single one may be evaded: another way is
 * taken, or a shorter step. */
static void one_fails(test_acts_scene *s, const test_acts *a, const char *what, long k, bool rest)
{
    test_acts_of.with = k % 2 ? 41 : -41;
    test_acts_of.asked = 0, test_acts_of.fail_at = k, test_acts_of.fail_on = rest;
    const int status = a->act(s);
    if (test_acts_of.asked < k || (status != test_acts_of.with && (rest || status != MBSR_OK)))
        fail_msg("%s: %s: call %ld fails with %d: %s (%d)", what, a->name, k, test_acts_of.with,
                 mbsr_status_name(status), status);
    test_acts_of.fail_at = 0;
}

/* The first calls, then ever fewer of them. */
static void each_fails(test_acts_scene *s, const test_acts *a, const char *what)
{
    static double good[TEST_ACTS_PARTS * TEST_ACTS_PART];
    memset(s->out, 0, sizeof s->out);
    test_acts_of.asked = 0;
    assert_ok(a->act(s), mbsr_data_error(s->data));
    memcpy(good, s->out, sizeof good);
    const long calls = test_acts_of.asked, slow = calls > 100000, fewer = test_seeds(1, 4);
    for (long k = 1; k <= calls; k += slow ? 100 * k : 1 + k / fewer) {
        one_fails(s, a, what, k, true);
        one_fails(s, a, what, k, false);
        if (calls > 1000 && k < calls / 2) continue;
        memset(s->out, 0, sizeof s->out);
        assert_ok(a->act(s), mbsr_data_error(s->data));
        if (memcmp(good, s->out, sizeof good) != 0)
            fail_msg("%s: %s: other numbers after call %ld of %ld failed", what, a->name, k, calls);
    }
}

static void every_status_is_handed_on(void **state)
{
    static const char *const what[] = {"open", "closed", "open, without mass",
                                       "closed, without mass"};
    (void)state;
    for (int k = 0; k < 4; ++k) {
        static test_acts_scene s;
        test_acts_make(&s, k & 1, (test_acts_slider)(k / 2));
        for (const test_acts *a = test_acts_table; a->name; ++a)
            if (a->models & 1 << k) each_fails(&s, a, what[k]);
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.model);
        assert_int_equal(test_acts_of.memory.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_status_is_handed_on)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
