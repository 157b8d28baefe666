/* Batches whose calls are shared out: the same numbers, statuses and failures as by one thread.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "rigid_tree.h"
#include "space.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STATES = 70 };

static void backwards(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    (void)user;
    for (int k = tasks - 1; k >= 0; --k) task(arg, k);
}

static double *room(int n)
{
    double *x = calloc((size_t)n + 1, sizeof *x);
    assert_non_null(x);
    return x;
}

typedef struct states {
    test_rigid_tree t;
    double *q, *u, *load, *one, *many;
    int status[2][STATES];
} states;

static void make(states *s, test_rigid_choice choice)
{
    test_rng rng = test_seed(choice.seed);
    test_rigid_tree_make(&s->t, choice);
    s->q = room(STATES * s->t.nq);
    s->u = room(STATES * s->t.nu);
    s->load = room(STATES * s->t.nu);
    s->one = room(STATES * s->t.nu);
    s->many = room(STATES * s->t.nu);
    test_fill(&rng, STATES * s->t.nq, s->q);
    test_fill(&rng, STATES * s->t.nu, s->u);
    test_fill(&rng, STATES * s->t.nu, s->load);
}

static void release(states *s)
{
    test_rigid_tree_free(&s->t);
    free(s->q), free(s->u), free(s->load), free(s->one), free(s->many);
}

static int evaluate(states *s, mbsr_batch *batch, int count, int inverse, double *out, int *status)
{
    return inverse ? mbsr_batch_inverse_dynamics(s->t.model, batch, 0.0, count, s->q, s->u, s->load,
                                                 out, status)
                   : mbsr_batch_forward_dynamics(s->t.model, batch, 0.0, count, s->q, s->u, s->load,
                                                 out, status);
}

static void compare(states *s, const mbsr_parallel *parallel)
{
    mbsr_batch *one, *many;
    const int nu = s->t.nu;
    assert_ok(mbsr_batch_create(s->t.model, &one, NULL), NULL);
    assert_ok(mbsr_batch_create_parallel(s->t.model, parallel, &many, NULL), NULL);
    assert_int_equal(mbsr_batch_lanes(one), mbsr_batch_lanes(many));
    for (int count = 1; count <= STATES; count += count < 20 ? 1 : 25) {
        for (int inverse = 0; inverse < 2; ++inverse) {
            memset(s->many, 0xff, (size_t)(STATES * nu) * sizeof *s->many);
            const int status = evaluate(s, one, count, inverse, s->one, s->status[0]);
            assert_int_equal(evaluate(s, many, count, inverse, s->many, s->status[1]), status);
            assert_memory_equal(s->one, s->many, (size_t)(count * nu) * sizeof *s->one);
            assert_memory_equal(s->status[0], s->status[1], (size_t)count * sizeof(int));
            assert_int_equal(mbsr_batch_failed(one), mbsr_batch_failed(many));
            assert_int_equal(mbsr_batch_one_by_one(one), mbsr_batch_one_by_one(many));
            if (status) {
                assert_string_equal(mbsr_batch_error(one)->text, mbsr_batch_error(many)->text);
            }
            for (int k = count * nu; k < STATES * nu; ++k) assert_true(isnan(s->many[k]));
        }
    }
    mbsr_batch_destroy(one);
    mbsr_batch_destroy(many);
}

/* Bodies that lanes serve, and others; a state that fails in between. */
static void shares_are_those_of_one_batch(void **unused)
{
    (void)unused;
    mbsr_threads *threads = NULL;
    (void)mbsr_threads_create(2, &threads, NULL);
    const mbsr_parallel by_threads = mbsr_threads_parallel(threads);
    for (int k = 0; k < 12; ++k) {
        states s;
        make(&s, (test_rigid_choice){.seed = 60 + (uint64_t)k,
                                     .bodies = 9,
                                     .massless = k % 4 == 1 ? 0.2 : 0.0,
                                     .many = k % 3 == 1 ? 0.2 : 0.0,
                                     .branching = 0.3,
                                     .length = 0.5,
                                     .forces = k % 5 == 2});
        if (k % 2) s.u[37 * s.t.nu] = 1e250;
        for (int workers = 1; workers <= 6; ++workers) {
            const mbsr_parallel parallel = {workers, backwards, NULL};
            compare(&s, &parallel);
        }
        compare(&s, &by_threads);
        release(&s);
    }
    mbsr_threads_destroy(threads);
}

static void bad_arguments_are_refused(void **unused)
{
    (void)unused;
    states s;
    mbsr_error error;
    mbsr_batch *batch = (void *)&error;
    make(&s, (test_rigid_choice){.seed = 5, .bodies = 2, .length = 1.0});
    mbsr_parallel parallel = {0, backwards, NULL};
    assert_int_equal(mbsr_batch_create_parallel(s.t.model, &parallel, &batch, &error),
                     MBSR_ERR_VALUE);
    assert_null(batch);
    assert_int_equal(mbsr_batch_create_parallel(s.t.model, NULL, &batch, &error), MBSR_ERR_NULL);
    parallel.workers = 2;
    assert_int_equal(mbsr_batch_create_parallel(NULL, &parallel, &batch, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_batch_create_parallel(s.t.model, &parallel, NULL, &error), MBSR_ERR_NULL);
    release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shares_are_those_of_one_batch),
                                       cmocka_unit_test(bad_arguments_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
