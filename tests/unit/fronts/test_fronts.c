/* Fronts of models with many loops that are open at once: the plan grows with the bodies, and
 * solutions hold.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "loops_equations.h"

#include "fronts/plan.h"
#include "loops/forward.h"
#include "model/record.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>

/* ---- mechanisms ---- */

static void add_pin(loops *s, int a, double ax, double ay, int b, double bx, double by)
{
    (void)loops_pin(s, "pin", a, ax, ay, b, bx, by);
}

/* Rockers on the ground, each coupled to the next. */
static void four_bars_on_the_ground(loops *s, int count)
{
    int before = loops_rod(s, "rocker", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int coupler = loops_rod(s, "coupler", before, 1.0, 0.0, 0.5, 1.0),
                  rocker = loops_rod(s, "rocker", MBSR_GROUND, k, 0.0, 1.0, 1.0);
        add_pin(s, coupler, 1.0, 0.1, rocker, 1.0, 0.1);
        before = rocker;
    }
}

/* A chain of couplers, from each of which a rocker goes to the ground. */
static void chain_on_the_ground(loops *s, int count)
{
    int before = loops_rod(s, "rocker", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int coupler = loops_rod(s, "coupler", before, 1.0, 0.0, 0.5, 1.0),
                  rocker = loops_rod(s, "rocker", coupler, 1.0, 0.0, 1.0, 1.0);
        add_pin(s, rocker, 0.2, -1.0, MBSR_GROUND, 1.0 + k, -1.0);
        before = coupler;
    }
}

/* Two rails, tied at the ends of so many rods. */
static void add_rails(loops *s, int count, int rods)
{
    int left = MBSR_GROUND, right = MBSR_GROUND;
    for (int k = 0; k < rods * count; ++k) {
        left = loops_rod(s, "left", left, k > 0 ? 1.0 : 0.0, 0.0, 1.0, 1.0);
        right = loops_rod(s, "right", right, k > 0 ? 1.0 : 0.0, k > 0 ? 0.0 : 1.0, 1.0, 1.0);
        if (k % rods == rods - 1) add_pin(s, left, 1.0, 0.5, right, 1.0, -0.5);
    }
}

static void ladder(loops *s, int count)
{
    add_rails(s, count, 3);
}

static void long_rails(loops *s, int count)
{
    add_rails(s, count, 4);
}

/* Legs of so many rods, that carry the end of the first one. */
static void add_legs(loops *s, int count, int rods)
{
    int carried = MBSR_GROUND;
    for (int leg = 0; leg <= count; ++leg) {
        int rod = MBSR_GROUND;
        for (int k = 0; k < rods; ++k)
            rod = loops_rod(s, "leg", rod, k > 0 ? 1.0 : 0.0, k > 0 ? 0.0 : 0.1 * leg, 1.0, 1.0);
        if (leg == 0)
            carried = rod;
        else
            add_pin(s, rod, 1.0, 0.0, carried, 1.0, 0.1 * leg);
    }
}

static void platform(loops *s, int count)
{
    add_legs(s, count, 4);
}

/* Each leg has as many rates as its pin has rows. */
static void short_legs(loops *s, int count)
{
    add_legs(s, count, 2);
}

typedef void (*family)(loops *, int);
static const family families[] = {four_bars_on_the_ground, chain_on_the_ground, ladder, platform,
                                  short_legs};
enum { FAMILIES = sizeof families / sizeof families[0] };

/* ---- plans ---- */

/* Multiplications a body, and numbers in the widest front. */
static double operations(family add, int count, int *widest)
{
    loops s = {0};
    loops_begin(&s, NULL);
    add(&s, count);
    loops_build(&s);
    const double result = s.m->plan->operations / s.m->bodies;
    *widest = s.m->plan->widest;
    loops_free(&s);
    return result;
}

static void plans_grow_with_the_bodies(void **state)
{
    (void)state;
    for (int f = 0; f < FAMILIES; ++f) {
        int few, many;
        const double small = operations(families[f], 10, &few),
                     large = operations(families[f], 200, &many);
        if (large > 1.2 * small || many > few + 2) print_error("family %d\n", f);
        assert_true(large <= 1.2 * small);
        assert_true(many <= few + 2);
        assert_true(operations(families[f], 600, &many) <= 1.05 * large);
    }
}

/* ---- solutions ---- */

/* Accelerations obey the rows, and forces of joints and loops balance. */
static void check_solution(loops *s)
{
    const size_t n = (size_t)s->nu, rows = (size_t)s->rows;
    double *q = calloc(5 * n + 3 * rows, sizeof *q), *u = q + n, *udot = u + n, *need = udot + n,
           *loads = need + n, *lambda = loads + n, *bias = lambda + rows, *rate = bias + rows;
    test_rng rng = {7};
    for (size_t k = 0; k < n; ++k) q[k] = 0.1 * test_uniform(&rng);
    for (size_t k = 0; k < n; ++k) u[k] = 0.1 * test_uniform(&rng);
    assert_ok(mbsr_forward_dynamics(s->m, s->d, 0.0, q, u, NULL, udot), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_lambda(s->m, s->d, lambda), mbsr_data_error(s->d));
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, q, u, udot, NULL, need),
              mbsr_data_error(s->d));
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, q), mbsr_data_error(s->d));
    assert_ok(mbsr_stage_velocities(s->m, s->d, u), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_bias(s->m, s->d, bias), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_apply(s->m, s->d, udot, rate), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_transpose(s->m, s->d, lambda, loads), mbsr_data_error(s->d));
    const double size = test_largest((int)n, udot), force = test_largest((int)n, loads);
    for (size_t k = 0; k < rows; ++k) assert_close(rate[k], -bias[k], 1e-9 * size);
    for (size_t k = 0; k < n; ++k) assert_close(need[k], loads[k], 1e-8 * force);
    free(q);
}

static void solutions_hold(void **state)
{
    (void)state;
    for (int f = 0; f < FAMILIES; ++f) {
        loops s = {0};
        loops_begin(&s, NULL);
        families[f](&s, 60);
        loops_build(&s);
        mbsri_sweep_loops *plan = loops_hide_plan(s.m);
        check_solution(&s);
        loops_show_plan(s.m, plan);
        loops_free(&s);
    }
}

/* Loop forces of long mechanisms, changed by refinement no more than this, beside a rod's weight:
 * where forces go as soon as they can digits get lost from loop to loop. */
static void digits_of_long_mechanisms(void **state)
{
    (void)state;
    const family add[] = {four_bars_on_the_ground, chain_on_the_ground, ladder, long_rails};
    for (int f = 0; f < 4; ++f) {
        loops s = {0};
        loops_begin(&s, NULL);
        add[f](&s, 500);
        loops_build(&s);
        const size_t n = (size_t)s.nu, rows = (size_t)s.rows;
        double *q = calloc(2 * n + 2 * rows, sizeof *q), *span = q + n, *lambda = span + n,
               *doubt = lambda + rows, load;
        bool *left_out = calloc(rows, sizeof *left_out);
        for (size_t k = 0; k < n; ++k) span[k] = 1.0;
        assert_ok(
            mbsri_loops_settled(s.m, s.d, 0.0, q, q, left_out, span, lambda, doubt, &load, "test"),
            mbsr_data_error(s.d));
        assert_less(test_largest((int)rows, doubt), 1e-8 * 9.81);
        free(left_out);
        free(q);
        loops_free(&s);
    }
}

/* ---- memory ---- */

/* Allocations of one call of forward dynamics, of fronts alone. */
static long allocations(loops *s, test_rng *rng, int *status)
{
    test_counting counting = {0};
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu;
    double *q = calloc(nq + 2 * nu, sizeof *q), *u = q + nq, *udot = u + nu;
    for (size_t k = 0; k < nq; ++k) q[k] = 0.3 * test_uniform(rng);
    for (size_t k = 0; k < nu; ++k) u[k] = 0.3 * test_uniform(rng);
    const mbsr_allocator before = s->m->allocator;
    mbsri_sweep_loops *plan = loops_hide_plan(s->m);
    s->m->allocator = test_counting_allocator(&counting);
    *status = mbsr_forward_dynamics(s->m, s->d, 0.0, q, u, NULL, udot);
    s->m->allocator = before;
    loops_show_plan(s->m, plan);
    free(q);
    return counting.calls;
}

static void nothing_is_allocated(void **state)
{
    (void)state;
    int status;
    test_rng rng = {11};
    for (int f = 0; f < FAMILIES; ++f) {
        for (int count = 2; count <= 128; count *= 4) {
            loops s = {0};
            loops_begin(&s, NULL);
            families[f](&s, count);
            loops_build(&s);
            assert_int_equal(allocations(&s, &rng, &status), 0);
            assert_int_equal(status, MBSR_OK);
            loops_free(&s);
        }
    }
}

/* Rows that are redundant, and motions without mass, are late. */
static void late_unknowns_have_room(void **state)
{
    (void)state;
    enum { MODELS = 300 };
    int found = 0, status;
    for (uint64_t seed = 1; seed <= MODELS; ++seed) {
        test_rng rng = {seed};
        loops s;
        loops_make_random(&s, &rng, 4 + (int)(seed % 12), 1 + (int)(seed % 6), seed % 2 == 0,
                          (int)(seed % 5));
        assert_int_equal(allocations(&s, &rng, &status), 0);
        found += status == MBSR_OK;
        loops_free(&s);
    }
    assert_true(found > MODELS / 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plans_grow_with_the_bodies), cmocka_unit_test(nothing_is_allocated),
        cmocka_unit_test(late_unknowns_have_room),    cmocka_unit_test(solutions_hold),
        cmocka_unit_test(digits_of_long_mechanisms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
