/* Trees by several threads: the same bits as by one, in whatever order the pieces are done.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "rigid_tree.h"
#include "space.h"

#include "sweeps/split.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BODIES = 3000 };

/* The last piece first. */
static void backwards(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    int *pieces = user;
    for (int k = tasks - 1; k >= 0; --k) task(arg, k);
    *pieces += tasks;
}

static double *room(int n)
{
    double *x = calloc((size_t)n + 1, sizeof *x);
    assert_non_null(x);
    return x;
}

/* u', tau, and F of the momentum form, whose y and y' are the state and anything. */
typedef struct results {
    int status[3];
    double *udot, *tau, *F;
} results;

static void evaluate(const test_rigid_tree *t, const double *y, const double *yp, results *r)
{
    r->status[0] = mbsr_forward_dynamics(t->model, t->data, t->t, t->q, t->u, t->tau, r->udot);
    r->status[1] = mbsr_inverse_dynamics(t->model, t->data, t->t, t->q, t->u, t->tau, NULL, r->tau);
    r->status[2] = mbsr_dae_residual(t->model, t->data, MBSR_DAE_MOMENTUM, t->t, y, yp, r->F);
}

static void assert_same(int n, const double *x, const double *y)
{
    assert_memory_equal(x, y, (size_t)n * sizeof *x);
}

/* Returns how many pieces were done. */
static int compare(test_rigid_choice choice, int workers, bool *served)
{
    test_rigid_tree t;
    test_rigid_tree_make(&t, choice);
    const int size = mbsr_dae_size(t.model, MBSR_DAE_MOMENTUM);
    double *y = room(size), *yp = room(size);
    results one = {.udot = room(t.nu), .tau = room(t.nu), .F = room(size)},
            many = {.udot = room(t.nu), .tau = room(t.nu), .F = room(size)};
    int pieces = 0;
    const mbsr_parallel parallel = {workers, backwards, &pieces};
    mbsr_split *split;
    mbsr_error error;
    assert_ok(mbsr_dae_pack(t.model, t.data, MBSR_DAE_MOMENTUM, t.t, t.q, t.u, y),
              mbsr_data_error(t.data));
    for (int k = 0; k < size; ++k) yp[k] = sin(k);
    evaluate(&t, y, yp, &one);
    assert_ok(mbsr_split_create(t.model, &parallel, &split, &error), &error);
    assert_int_equal(mbsr_data_use_split(t.data, split), MBSR_OK);
    for (int again = 0; again < 2; ++again) {
        evaluate(&t, y, yp, &many);
        assert_memory_equal(one.status, many.status, sizeof one.status);
        if (!one.status[0] || one.status[0] == MBSR_UNDETERMINED)
            assert_same(t.nu, one.udot, many.udot);
        if (!one.status[1]) assert_same(t.nu, one.tau, many.tau);
        if (!one.status[2]) assert_same(size, one.F, many.F);
    }
    *served = mbsr_split_tasks(split) > 0;
    assert_true(*served || pieces == 0);
    assert_int_equal(mbsr_data_use_split(t.data, NULL), MBSR_OK);
    mbsr_split_destroy(split);
    test_rigid_tree_free(&t);
    free(y), free(yp);
    free(one.udot), free(one.tau), free(one.F);
    free(many.udot), free(many.tau), free(many.F);
    return pieces;
}

/* One axis or several, massless bodies, joints without rank, a moving root, springs along joints,
 * ids in any order. */
static void results_are_those_of_one_thread(void **state)
{
    (void)state;
    int trees = 0, split = 0;
    for (int k = 0; k < 12; k += test_seeds(5, 1), ++trees) {
        bool served;
        const test_rigid_choice choice = {.seed = 900 + (uint64_t)k,
                                          .bodies = BODIES,
                                          .massless = k % 3 == 1 ? 0.2 : 0.0,
                                          .points = k % 4 == 1 ? 0.1 : 0.0,
                                          .many = k % 2 ? 0.2 : 0.0,
                                          .branching = 0.05 * (1 + k % 5),
                                          .length = 0.3,
                                          .armature = k % 5 == 2 ? 0.3 : 0.0,
                                          .moving = k % 6 == 5,
                                          .shuffle = k % 7 == 3};
        const int pieces = compare(choice, 2 + k % 3, &served);
        split += served;
        /* of each call at least one round */
        if (served) assert_true(pieces >= 2 * 3 * 2);
    }
    assert_true(2 * split >= trees);
}

/* With elements on bodies, or without branches, one thread does it. */
static void other_trees_are_not_split(void **state)
{
    (void)state;
    bool served;
    assert_int_equal(
        compare(
            (test_rigid_choice){
                .seed = 7, .bodies = 1500, .branching = 0.1, .length = 0.3, .forces = 1},
            2, &served),
        0);
    assert_false(served);
    assert_int_equal(
        compare((test_rigid_choice){.seed = 8, .bodies = 1500, .length = 0.3}, 2, &served), 0);
    assert_false(served);
    assert_int_equal(
        compare((test_rigid_choice){.seed = 9, .bodies = 50, .branching = 0.3, .length = 0.3}, 2,
                &served),
        0);
    assert_false(served);
}

/* Chains on a body, or on a chain that is not too long; a chain with short ones on it stays whole.
 */
static int tasks_of(int trunk, int chains, int length)
{
    mbsr_model *m = NULL;
    const double z[3] = {0.0, 0.0, 1.0};
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    const mbsr_frame at = mbsr_frame_at(0.1, 0.0, 0.0);
    body.joint = mbsr_joint_revolute(&at, NULL, z);
    body.inertia = mbsr_inertia_particle(1.0);
    int base = MBSR_GROUND;
    for (int k = 0; k < trunk; ++k) {
        body.parent = base;
        assert_ok(mbsr_model_add_body(m, &body, &base), mbsr_model_error(m));
    }
    for (int k = 0; k < chains; ++k) {
        body.parent = base;
        for (int l = 0; l < length; ++l)
            assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    int pieces;
    const mbsr_parallel parallel = {2, backwards, &pieces};
    mbsr_split *split;
    assert_ok(mbsr_split_create(m, &parallel, &split, NULL), NULL);
    const int tasks = mbsr_split_tasks(split);
    mbsr_split_destroy(split);
    mbsr_model_destroy(m);
    return tasks;
}

static void trees_are_cut_at_their_branches(void **state)
{
    (void)state;
    assert_int_equal(tasks_of(0, 1, 3000), 0);
    assert_int_equal(tasks_of(0, 2, 2000), 2);
    assert_int_equal(tasks_of(0, 3, 2000), 3);
    assert_int_equal(tasks_of(800, 2, 2000), 2);
    assert_int_equal(tasks_of(5000, 2, 2000), 0);
    assert_int_equal(tasks_of(10, 2, 200), 0);
    /* 5000 bodies in tasks of half an eighth at least */
    assert_in_range(tasks_of(0, 100, 50), 8, 16);
    assert_in_range(tasks_of(3, test_seeds_short(200, 1000), 40), 8, 16);
}

/* What is not finite is found and named as by one thread. */
static void failures_are_those_of_one_thread(void **state)
{
    (void)state;
    test_rigid_tree t;
    test_rigid_tree_make(
        &t, (test_rigid_choice){.seed = 903, .bodies = BODIES, .branching = 0.05, .length = 0.3});
    int pieces = 0, failures = 0;
    const mbsr_parallel parallel = {2, backwards, &pieces};
    mbsr_split *split;
    assert_ok(mbsr_split_create(t.model, &parallel, &split, NULL), NULL);
    assert_true(mbsr_split_tasks(split) >= 2);
    for (int place = 0; place < t.nu; place += t.nu / 7) {
        mbsr_error one;
        const double u = t.u[place];
        t.u[place] = 1e200;
        const int status = mbsr_forward_dynamics(t.model, t.data, 0.0, t.q, t.u, t.tau, t.udot);
        one = *mbsr_data_error(t.data);
        failures += status != MBSR_OK;
        mbsr_data_use_split(t.data, split);
        assert_int_equal(mbsr_forward_dynamics(t.model, t.data, 0.0, t.q, t.u, t.tau, t.udot),
                         status);
        if (status) assert_string_equal(mbsr_data_error(t.data)->text, one.text);
        mbsr_data_use_split(t.data, NULL);
        t.u[place] = u;
    }
    assert_true(pieces > 0 && failures > 3);
    mbsr_split_destroy(split);
    test_rigid_tree_free(&t);
}

/* By threads, many times. */
static void threads_give_the_same_bits(void **state)
{
    (void)state;
    test_rigid_tree t;
    mbsr_threads *threads;
    mbsr_split *split;
    if (mbsr_threads_create(3, &threads, NULL) == MBSR_ERR_UNAVAILABLE) return;
    test_rigid_tree_make(
        &t, (test_rigid_choice){
                .seed = 904, .bodies = BODIES, .branching = 0.05, .many = 0.1, .length = 0.3});
    const mbsr_parallel parallel = mbsr_threads_parallel(threads);
    assert_ok(mbsr_split_create(t.model, &parallel, &split, NULL), NULL);
    assert_true(mbsr_split_tasks(split) >= 2);
    assert_ok(mbsr_forward_dynamics(t.model, t.data, 0.0, t.q, t.u, t.tau, t.expected),
              mbsr_data_error(t.data));
    mbsr_data_use_split(t.data, split);
    const int rounds = test_long() ? 200 : test_seeds_short(4, 40);
    for (int round = 0; round < rounds; ++round) {
        memset(t.udot, 0xff, (size_t)t.nu * sizeof *t.udot);
        assert_ok(mbsr_forward_dynamics(t.model, t.data, 0.0, t.q, t.u, t.tau, t.udot),
                  mbsr_data_error(t.data));
        assert_same(t.nu, t.expected, t.udot);
    }
    mbsr_data_use_split(t.data, NULL);
    mbsr_split_destroy(split);
    mbsr_threads_destroy(threads);
    test_rigid_tree_free(&t);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    test_rigid_tree t, other;
    const test_rigid_choice choice = {.seed = 1, .bodies = 3, .length = 1.0};
    test_rigid_tree_make(&t, choice);
    test_rigid_tree_make(&other, choice);
    mbsr_split *split = (void *)&t;
    mbsr_error error;
    mbsr_parallel parallel = mbsr_threads_parallel(NULL);
    assert_int_equal(mbsr_split_create(t.model, NULL, &split, &error), MBSR_ERR_NULL);
    assert_null(split);
    assert_int_equal(mbsr_split_create(NULL, &parallel, &split, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_split_create(t.model, &parallel, NULL, &error), MBSR_ERR_NULL);
    parallel.workers = 0;
    assert_int_equal(mbsr_split_create(t.model, &parallel, &split, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "workers is 0"));
    parallel = (mbsr_parallel){1, NULL, NULL};
    assert_int_equal(mbsr_split_create(t.model, &parallel, &split, &error), MBSR_ERR_VALUE);
    parallel = mbsr_threads_parallel(NULL);
    assert_ok(mbsr_split_create(t.model, &parallel, &split, &error), &error);
    assert_int_equal(mbsr_data_use_split(other.data, split), MBSR_ERR_MISMATCH);
    assert_int_equal(mbsr_data_use_split(NULL, split), MBSR_ERR_NULL);
    mbsr_split_destroy(split);
    mbsr_split_destroy(NULL);
    test_rigid_tree_free(&t);
    test_rigid_tree_free(&other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(results_are_those_of_one_thread),
                                       cmocka_unit_test(other_trees_are_not_split),
                                       cmocka_unit_test(trees_are_cut_at_their_branches),
                                       cmocka_unit_test(failures_are_those_of_one_thread),
                                       cmocka_unit_test(threads_give_the_same_bits),
                                       cmocka_unit_test(bad_arguments_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
