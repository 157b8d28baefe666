/* Of small mechanisms all is asked, and each place of the core at which a status is taken fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "duration.h"
#include "faults.h"
#include "kinds.h"
#include "medley.h"

static long failed;

static test_acts_scene scene;

typedef struct asked {
    test_acts_scene *scene;
    const test_acts *act;
} asked;

static int ask(void *user)
{
    asked *a = user;
    return a->act->act(a->scene);
}

/* Acts that are refused for a model are not for it. */
static void all_fail(void)
{
    for (const test_acts *a = test_acts_table; a->name; ++a) {
        const bool steps = strcmp(a->name, "is_stepped") == 0,
                   completed = strcmp(a->name, "is_completed") == 0, /* by differences */
            starts = strncmp(a->name, "starts", 6) == 0;
        asked user = {&scene, a};
        const test_faults_act act = {a->name,
                                     ask,
                                     &user,
                                     scene.out,
                                     sizeof scene.out / sizeof *scene.out,
                                     steps       ? 1e-4
                                     : completed ? 1e-5
                                                 : 1e-7,
                                     steps || starts};
        if (strcmp(a->name, "has_small_masses") != 0) failed += test_faults_each(&act);
    }
}

static void of_linkages(void **state)
{
    (void)state;
    for (int k = 0; k < 8; ++k) {
        test_acts_make(&scene, k & 1, (test_acts_slider)(k / 2));
        all_fail();
        mbsr_data_destroy(scene.data);
        mbsr_model_destroy(scene.model);
    }
}

static void of_all_sorts(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (uint64_t)test_seeds(12, 16); ++seed) {
        medley s;
        medley_choice c = medley_choose(seed);
        if (c.bodies > 8) c.bodies = 8;
        const bool made = medley_make(&s, &c);
        if (made && test_acts_take(&scene, s.m, s.d, s.t, s.q, s.u)) all_fail();
        medley_free(&s);
    }
}

static void of_trees(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (uint64_t)test_seeds(12, 16); ++seed) {
        test_kinds_tree s;
        test_kinds_choice c = {.seed = seed, .bodies = 6, .plane = seed % 3 == 0};
        c.own = c.many = 0.1 * (double)(seed % 4);
        c.general = seed % 4 < 2 ? 0.0 : 0.2, c.massless = seed % 2 ? 0.2 : 0.0;
        c.springs = (int)(seed % 5);
        test_kinds_make(&s, c);
        if (test_acts_take(&scene, s.model, s.data, s.t, s.q, s.u)) all_fail();
        test_kinds_free(&s);
    }
}

static void many_do(void **state)
{
    (void)state;
    assert_in_range(failed, 100, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_linkages), cmocka_unit_test(of_trees),
                                       cmocka_unit_test(of_all_sorts), cmocka_unit_test(many_do)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
