/* Starts of random models that move: a run goes on with the accelerations of its start.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"
#include "duration.h"

#include <mbsrank/driver.h>
#include <mbsrank/ida.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { LENGTH = 8 * ANY_MOST };

/* The largest of what u' of the start is missing by in the mean over `time`, s; the size of u'. */
static double miss(const any_model *s, mbsr_data *d, double time, const double *y, const double *yp,
                   double *size)
{
    const int first = s->nq + s->nu;
    double after[LENGTH], rates[LENGTH], most = 0.0;
    mbsr_ida *ida;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = 1e-7;
    opt.atol = opt.atol_angle = opt.atol_length = 1e-8;
    opt.atol_angular_velocity = opt.atol_velocity = 1e-8;
    memcpy(after, y, sizeof after);
    memcpy(rates, yp, sizeof rates);
    assert_ok(mbsr_ida_create(s->m, d, &opt, &ida, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_start(ida, 0.0, after, rates), mbsr_ida_error(ida));
    const int status = mbsr_ida_advance(ida, time, NULL, after, rates);
    if (status != MBSR_RANK_CHANGED) assert_ok(status, mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    *size = 1.0;
    if (status) return 0.0; /* the rank is of that state alone */
    for (int k = first; k < first + s->nu; ++k) {
        most = fmax(most, fabs((after[k] - y[k]) / time - yp[k]));
        *size = fmax(*size, fabs(yp[k]));
    }
    return most;
}

/* 1: the model starts, from velocities between -1 and 1. */
static int check(uint64_t seed)
{
    test_rng rng = test_seed(seed);
    double u[ANY_MOST] = {0.0}, y[LENGTH] = {0.0}, yp[LENGTH] = {0.0}, size;
    any_model s;
    mbsr_data *d;
    if (!any_model_make(&s, seed, systems, false)) return 0;
    assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
    assert_true(mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= LENGTH);
    for (int k = 0; k < s.nu; ++k) u[k] = test_uniform(&rng);
    assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, s.q, u, y), mbsr_data_error(d));
    const int status = mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (!status) {
        const double longer = miss(&s, d, 1e-3, y, yp, &size),
                     shorter = miss(&s, d, 1e-4, y, yp, &size);
        const bool slow = size < 1e3; /* others change much in these times */
        if (slow && shorter > 0.3 * longer + 5e-3 * size) print_error("seed %d\n", (int)seed);
        assert_true(!slow || shorter <= 0.3 * longer + 5e-3 * size);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(s.m);
    return status == MBSR_OK;
}

static void runs_go_on_as_they_start(void **state)
{
    (void)state;
    const int seeds = test_long() ? 400 : test_seeds(20, 50);
    int started = 0;
    for (int seed = 1; seed <= seeds; ++seed) started += check((uint64_t)seed);
    assert_true(started > seeds / 5);
}

/* Springs hold what has no mass beside loops, whose forces have a share of inertia that turns. */
static void springs_beside_loops(void **state)
{
    (void)state;
    static const uint64_t seed[] = {849, 1331, 2739};
    for (size_t k = 0; k < sizeof seed / sizeof seed[0]; ++k) assert_int_equal(check(seed[k]), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(runs_go_on_as_they_start),
                                       cmocka_unit_test(springs_beside_loops)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
