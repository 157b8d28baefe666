/* Mechanisms with closed loops, integrated by the driver, against digits that two formulations
 * agree on.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "loops.h"

#include <mbsrank/ida.h>
#include <mbsrank/driver.h>

/* Integrates the state of s to t_end; returns the number of steps. */
static long run(loops *s, double tolerance, double t_end, double *gap)
{
    double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST], g[LOOPS_MOST], t = 0.0;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida_stats stats;
    mbsr_error error;
    mbsr_ida *ida;
    opt.rtol = opt.atol = tolerance;
    loops_state(s, 0.0, y, yp);
    assert_ok(mbsr_ida_create(s->m, s->d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, t_end, &t, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_get_stats(ida, &stats), NULL);
    assert_ok(mbsr_dae_unpack(s->m, s->d, MBSR_DAE_MOMENTUM, t, y, s->q, s->u), NULL);
    assert_ok(mbsr_stage_positions(s->m, s->d, t, s->q), NULL);
    assert_ok(mbsr_closures_gap(s->m, s->d, g), NULL);
    for (int k = 0; k < s->rows; ++k) s->lambda[k] = yp[s->nq + 2 * s->nu + k];
    if (gap) *gap = test_largest(s->position_rows, g);
    mbsr_ida_destroy(ida);
    return stats.steps;
}

static void start(loops *s)
{
    loops_close(s, 0.0);
    loops_velocities(s, 0.0);
    loops_accelerations(s, 0.0, NULL);
}

/* Crank 1 m, coupler 2.5 m, rocker 2 m over 2 m of ground. */
static void finish_four_bar(loops *s, double coupler)
{
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(s, "coupler", a, 1.0, 0.0, coupler, 2.5);
    const int c = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(s);
    s->q[0] = 1.2, s->q[1] = -0.9, s->q[2] = 1.3, s->u[0] = 6.0;
}

static void four_bar(loops *s, double coupler)
{
    loops_begin(s, NULL);
    finish_four_bar(s, coupler);
}

/* Steps summed over the tolerances; the reference is known to 2e-9. */
static void a_four_bar(void **state)
{
    (void)state;
    static const double q[2][3] = {{20.603931600, -20.186219784, 1.519524361},
                                   {7.6112329725, -7.2207531772, 1.2910685899}};
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    static const long most[2] = {487 + 1013 + 2318, 161 + 328 + 746};
    for (int massless = 0; massless < 2; ++massless) {
        long steps = 0;
        for (int k = 0; k < 3; ++k) {
            loops s;
            double gap;
            four_bar(&s, massless ? 0.0 : 2.5);
            start(&s);
            steps += run(&s, tolerance[k], 2.0, &gap);
            for (int j = 0; j < 3; ++j) assert_close(s.q[j], q[massless][j], 1e3 * tolerance[k]);
            assert_less(gap, tolerance[k]);
            loops_free(&s);
        }
        assert_true(steps <= most[massless]);
    }
}

/* A coupler on legs side by side: all rows but those of the first loop depend on others. */
static void finish_legs(loops *s)
{
    enum { LEGS = 30 };
    const int first = loops_rod(s, "leg", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              coupler = loops_rod(s, "coupler", first, 1.0, 0.0, LEGS, LEGS);
    for (int k = 1; k < LEGS; ++k) {
        const int leg = loops_rod(s, "leg", MBSR_GROUND, k, 0.0, 1.0, 1.0);
        loops_pin(s, "pin", coupler, k, 0.0, leg, 1.0, 0.0);
    }
    loops_finish(s);
    for (int k = 0; k <= LEGS; ++k) s->q[k] = k == 1 ? -0.8 : 0.8;
    s->u[0] = 1.0;
}

/* Tolerances of momenta in closed models take memory where many rows depend on others: a start
 * without it is refused, and the next one runs. */
static void a_start_without_memory_is_refused(void **state)
{
    (void)state;
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST], mass[LOOPS_MOST], t = 0.0;
    int redundant[LOOPS_MOST], none[LOOPS_MOST] = {0};
    mbsr_ida *ida = NULL;
    loops s = {0};
    def.allocator = test_counting_allocator(&counting);
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    finish_legs(&s);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(s.d));
    assert_ok(mbsr_closures_redundant(s.m, s.d, redundant), NULL);
    assert_ok(mbsr_closures_set_redundant(s.m, s.d, none), NULL);
    assert_ok(mbsr_ida_create(s.m, s.d, NULL, &ida, NULL), NULL);
    const long live = counting.live;
    long refused = 0;
    do {
        counting.failed = 0;
        counting.fail_at = counting.calls + 1 + refused;
        const int status = mbsr_ida_start(ida, 0.0, y, yp);
        assert_int_equal(counting.live, live);
        assert_int_equal(status, counting.failed ? MBSR_ERR_NO_MEMORY : MBSR_OK);
        if (counting.failed) assert_contains(mbsr_ida_error(ida)->text, "no memory");
        refused += counting.failed;
    } while (counting.failed);
    assert_true(refused >= 1);
    counting.fail_at = counting.calls + 1;
    assert_ok(mbsr_stage_backward(s.m, s.d), mbsr_data_error(s.d));
    assert_int_equal(mbsr_momentum_scales(s.m, s.d, mass), MBSR_ERR_NO_MEMORY);
    assert_ok(mbsr_closures_set_redundant(s.m, s.d, redundant), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.1, &t, y, yp), mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    loops_free(&s);
    assert_int_equal(counting.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_four_bar),
                                       cmocka_unit_test(a_start_without_memory_is_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
