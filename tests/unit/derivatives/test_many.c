/* Derivatives at many states: to the last bit those of single ones, whoever shares them out.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "rigid_tree.h"
#include "space.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { STATES = 11, WRONG = 7, INPUTS = 6, KINDS = 3 };

static void backwards(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    (void)user;
    for (int k = tasks - 1; k >= 0; --k) task(arg, k);
}

/* in: q, u, tau, and directions or weights; out: udot and results, of a batch and one by one. */
typedef struct scene {
    test_rigid_tree t;
    double *in[INPUTS], *many[4], *one[4];
    int status[2][STATES];
} scene;

static double *room(size_t n)
{
    double *x = calloc(n + 1, sizeof *x);
    assert_non_null(x);
    return x;
}

static void make(scene *s, test_rigid_choice choice, bool wrong)
{
    test_rng rng = test_seed(choice.seed);
    test_rigid_tree_make(&s->t, choice);
    const size_t nu = (size_t)s->t.nu;
    for (int k = 0; k < INPUTS; ++k) {
        const int n = STATES * (k == 0 ? s->t.nq : s->t.nu);
        s->in[k] = room((size_t)n);
        test_fill(&rng, n, s->in[k]);
    }
    for (int k = 0; k < 4; ++k) {
        s->many[k] = room(STATES * nu * nu);
        s->one[k] = room(STATES * nu * nu);
    }
    if (wrong) s->in[1][WRONG * s->t.nu] = INFINITY;
}

static void release(scene *s)
{
    test_rigid_tree_free(&s->t);
    for (int k = 0; k < INPUTS; ++k) free(s->in[k]);
    for (int k = 0; k < 4; ++k) free(s->many[k]), free(s->one[k]);
}

static size_t length_of(const scene *s, int kind, int k)
{
    const size_t nu = (size_t)s->t.nu;
    return kind == 2 && k > 0 ? nu * nu : nu;
}

static int results_of(int kind)
{
    return kind == 0 ? 2 : 4;
}

static void evaluate_one(scene *s, mbsr_derivatives *d, int kind, int k)
{
    const double *in[INPUTS];
    double *out[4];
    for (int l = 0; l < INPUTS; ++l) in[l] = s->in[l] + k * (l == 0 ? s->t.nq : s->t.nu);
    for (int l = 0; l < 4; ++l) out[l] = s->one[l] + (size_t)k * length_of(s, kind, l);
    int status = mbsr_derivatives_forward(d, 0.5, in[0], in[1], in[2], out[0], NULL);
    if (!status && kind == 0)
        status = mbsr_derivatives_tangent(d, in[3], in[4], in[5], out[1], NULL);
    if (!status && kind == 1)
        status = mbsr_derivatives_adjoint(d, in[3], NULL, out[1], out[2], out[3]);
    if (!status && kind == 2) status = mbsr_derivatives_matrices(d, out[1], out[2], out[3]);
    s->status[0][k] = status;
}

static int evaluate_many(scene *s, mbsr_derivatives_batch *b, int kind)
{
    double **in = s->in, **out = s->many;
    int *status = s->status[1];
    switch (kind) {
    case 0:
        return mbsr_derivatives_batch_tangent(b, 0.5, STATES, in[0], in[1], in[2], in[3], in[4],
                                              in[5], out[0], out[1], status);
    case 1:
        return mbsr_derivatives_batch_adjoint(b, 0.5, STATES, in[0], in[1], in[2], in[3], out[0],
                                              out[1], out[2], out[3], status);
    default:
        return mbsr_derivatives_batch_matrices(b, 0.5, STATES, in[0], in[1], in[2], out[0], out[1],
                                               out[2], out[3], status);
    }
}

static void compare(scene *s, const mbsr_parallel *parallel, bool wrong)
{
    mbsr_derivatives *d;
    mbsr_derivatives_batch *b;
    mbsr_error error;
    assert_ok(mbsr_derivatives_create(s->t.model, &d, &error), &error);
    assert_ok(mbsr_derivatives_batch_create(s->t.model, parallel, &b, &error), &error);
    for (int kind = 0; kind < KINDS; ++kind) {
        for (int k = 0; k < STATES; ++k) evaluate_one(s, d, kind, k);
        const int result = evaluate_many(s, b, kind);
        assert_int_equal(result, wrong ? s->status[0][WRONG] : MBSR_OK);
        assert_int_equal(mbsr_derivatives_batch_failed(b), wrong ? WRONG : -1);
        if (wrong) assert_non_null(strstr(mbsr_derivatives_batch_error(b)->text, "state 7"));
        assert_memory_equal(s->status[0], s->status[1], sizeof s->status[0]);
        for (int l = 0; l < results_of(kind); ++l) {
            const size_t n = length_of(s, kind, l);
            for (int k = 0; k < STATES; ++k) {
                const double *many = s->many[l] + (size_t)k * n, *one = s->one[l] + (size_t)k * n;
                if (wrong && k == WRONG)
                    for (size_t i = 0; i < n; ++i) assert_true(isnan(many[i]));
                else
                    assert_memory_equal(many, one, n * sizeof *one);
            }
        }
    }
    mbsr_derivatives_batch_destroy(b);
    mbsr_derivatives_destroy(d);
}

static void they_are_those_of_single_states(void **unused)
{
    (void)unused;
    mbsr_threads *threads = NULL;
    (void)mbsr_threads_create(2, &threads, NULL);
    const mbsr_parallel by_threads = mbsr_threads_parallel(threads);
    for (int k = 0; k < 6; ++k) {
        scene s;
        make(&s,
             (test_rigid_choice){.seed = 90 + (uint64_t)k,
                                 .bodies = 6,
                                 .many = k % 3 == 1 ? 0.3 : 0.0,
                                 .branching = 0.3,
                                 .length = 0.5,
                                 .forces = k % 2},
             k > 3);
        compare(&s, NULL, k > 3);
        for (int workers = 1; workers <= 13; workers += 4) {
            const mbsr_parallel parallel = {workers, backwards, NULL};
            compare(&s, &parallel, k > 3);
        }
        compare(&s, &by_threads, k > 3);
        release(&s);
    }
    mbsr_threads_destroy(threads);
}

static void bad_arguments_are_refused(void **unused)
{
    (void)unused;
    scene s;
    mbsr_error error;
    mbsr_derivatives_batch *b = (void *)&error;
    make(&s, (test_rigid_choice){.seed = 5, .bodies = 2, .length = 1.0}, false);
    const mbsr_parallel none = {0, backwards, NULL};
    assert_int_equal(mbsr_derivatives_batch_create(s.t.model, &none, &b, &error), MBSR_ERR_VALUE);
    assert_null(b);
    assert_int_equal(mbsr_derivatives_batch_create(NULL, NULL, &b, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_batch_create(s.t.model, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(evaluate_many(&s, NULL, 0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_batch_failed(NULL), -1);
    assert_int_equal(mbsr_derivatives_batch_error(NULL)->status, MBSR_ERR_NULL);
    mbsr_derivatives_batch_destroy(NULL);
    assert_ok(mbsr_derivatives_batch_create(s.t.model, NULL, &b, &error), &error);
    assert_int_equal(mbsr_derivatives_batch_matrices(b, 0.0, 0, s.in[0], s.in[1], NULL, NULL, NULL,
                                                     NULL, NULL, NULL),
                     MBSR_ERR_VALUE);
    assert_non_null(strstr(mbsr_derivatives_batch_error(b)->text, "states is 0"));
    assert_int_equal(mbsr_derivatives_batch_matrices(b, 0.0, 1, NULL, s.in[1], NULL, NULL, NULL,
                                                     NULL, NULL, NULL),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_batch_adjoint(b, 0.0, 1, s.in[0], s.in[1], NULL, NULL, NULL,
                                                    NULL, NULL, NULL, NULL),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_batch_tangent(b, 0.0, 1, s.in[0], s.in[1], NULL, s.in[3],
                                                    NULL, NULL, NULL, NULL, NULL),
                     MBSR_ERR_NULL);
    mbsr_derivatives_batch_destroy(b);
    release(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(they_are_those_of_single_states),
                                       cmocka_unit_test(bad_arguments_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
