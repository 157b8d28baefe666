/* What a report on small masses costs: counted evaluations, whatever the number of bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/small_masses.h>

#include <stdlib.h>

enum { SMALL = 5 };

/* A chain of blocks on slides, each on the one before with a spring and a damper; `SMALL` of them
 * have little mass. The last is pushed by a force that counts. */
static int push(void *user, double t, int n, double *value)
{
    (void)t, (void)n;
    ++*(long *)user;
    value[0] = 1.0;
    return MBSR_OK;
}

static mbsr_model *chain(int bodies, long *calls)
{
    const mbsr_planar_frame at = {0.0, 0.0, 0.0};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int i = 0; i < bodies; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        const int little = i % (bodies / SMALL) == 1;
        body.parent = i == 0 ? MBSR_GROUND : i - 1;
        body.joint = mbsr_joint_planar_prismatic(at, at);
        body.inertia = mbsr_inertia_particle(little ? 1e-4 : 1.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const mbsr_force_def spring = mbsr_force_joint_spring(i, 0, 100.0, 5.0, 0.0);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def force = mbsr_force_joint_applied(bodies - 1, push, calls);
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

typedef struct cost {
    long factorisations, start, step;
} cost;

/* Of a report at rest, and of one step more. */
static cost measure(int bodies)
{
    long calls = 0;
    mbsr_model *m = chain(bodies, &calls);
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_small_masses *small;
    mbsr_small_masses_report report;
    mbsr_error error;
    const size_t n = (size_t)bodies;
    double *q = calloc(2 * n, sizeof *q), *y = calloc(6 * n, sizeof *y), t;
    assert_non_null(q);
    assert_non_null(y);
    opt.duration = 1.0;
    opt.ratio = 1e-3;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
    calls = 0;
    assert_ok(mbsr_small_masses_start(small, 0.0, q, q + n), mbsr_small_masses_error(small));
    cost c = {.start = calls};
    assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
    assert_int_equal(report.masses, SMALL);
    c.factorisations = report.factorisations;
    assert_ok(mbsr_small_masses_state(small, &t, y, y + 3 * n), NULL);
    calls = 0;
    assert_ok(mbsr_small_masses_step(small, 1e-3, y, y + 3 * n), mbsr_small_masses_error(small));
    c.step = calls;
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
    free(q);
    free(y);
    return c;
}

/* Each evaluation, factorisation and solution is O(bodies) (bench/bench_newton.c). */
static void evaluations_do_not_grow_with_the_bodies(void **unused)
{
    (void)unused;
    const cost few = measure(10);
    print_message("%ld factorisations, %ld evaluations, %ld a step\n", few.factorisations,
                  few.start, few.step);
    assert_int_equal(few.factorisations, 5);
    assert_in_range(few.start, 1, 200);
    assert_in_range(few.step, 1, 20);
    for (int bodies = 100; bodies <= 1000; bodies *= 10) {
        const cost many = measure(bodies);
        assert_int_equal(many.factorisations, 5);
        assert_in_range(many.start, 1, few.start + 5); /* starts iterate */
        assert_in_range(many.step, 1, 20);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(evaluations_do_not_grow_with_the_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
