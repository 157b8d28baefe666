/* Newton systems where many loops close on one body, each beside few others: trains of wheels, ladders. As by blocks
 * and as the dense matrix, and in fronts that do not grow with the number of loops.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton/blocks/record.h"
#include "newton/sweeps/record.h"
#include "newton_system.h"

#include <stdlib.h>

enum { MOST = 200 };

static mbsr_newton *solver(const loops *s, int by_blocks)
{
    mbsr_newton *newton;
    mbsr_error error;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = by_blocks;
    assert_ok(mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

static void solve(mbsr_newton *newton, const test_newton_state *at, double c, const double *r,
                  double *x)
{
    assert_ok(mbsr_newton_factor(newton, at->data, 0.0, at->y, at->yp, c),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
}

/* Unknowns of the largest front where loops close. */
static int widest(const mbsr_newton *newton)
{
    int most = 0;
    for (int k = newton->model->bodies + 1; k < newton->carried.fronts; ++k) {
        const int size = newton->carried.pool[k].most;
        most = size > most ? size : most;
    }
    return most;
}

/* most: unknowns of any front. */
static void compare(loops *s, int most)
{
    static const double factors[] = {1.0, 50.0, 1e5, -30.0};
    test_newton_state at;
    test_rng rng = test_seed(11);
    loops_finish(s);
    for (int k = 0; k < s->nq; ++k) s->q[k] = 0.3 * test_uniform(&rng);
    test_fill(&rng, s->nu, s->u);
    mbsr_newton *newton = solver(s, 0), *blocks = solver(s, 1);
    assert_in_range(widest(newton), 1, most);
    assert_ok(test_newton_start(&at, s->m, s->d, 0.0, s->q, s->u, NULL), mbsr_data_error(s->d));
    assert_ok(test_newton_matrices(&at, s->m, s->d), NULL);
    double *r = calloc(3 * (size_t)at.n, sizeof *r), *x = r + at.n, *y = x + at.n;
    for (int k = 0; k < 4; ++k) {
        test_fill(&rng, at.n, r);
        solve(newton, &at, factors[k], r, x);
        assert_true(newton->by_sweeps && newton->sweeps->looped);
        solve(blocks, &at, factors[k], r, y);
        assert_false(blocks->by_sweeps);
        const test_newton_errors e = test_newton_compare(&at, factors[k], r, x);
        assert_less(test_newton_distance(&at, x, y), 1e-12 * (1.0 + e.amplification));
        assert_less(e.net_delta, 1e-10);
        assert_less(e.delta, 1e-10 * (1.0 + e.amplification));
    }
    free(r);
    mbsr_newton_destroy(newton);
    mbsr_newton_destroy(blocks);
    test_newton_free(&at);
    loops_free(s);
}

static void gear(loops *s, int a, int b, double stiffness)
{
    mbsr_closure_def def =
        mbsr_closure_coupling(2, (int[2]){a, b}, (int[2]){0, 0}, (double[2]){1.0, 0.7}, 0.0);
    def.stiffness[0] = stiffness, def.damping[0] = 1e-3 * stiffness;
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* Wheels on a carrier, or on the ground, in any order: each geared to the next. */
static void train(loops *s, int count, int on_ground, double mass, double stiffness)
{
    int wheel[MOST], at[MOST];
    test_rng rng = test_seed(5);
    const int carrier =
        on_ground ? MBSR_GROUND : loops_rod(s, "carrier", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0);
    for (int k = 0; k < count; ++k) {
        wheel[k] = loops_rod(s, NULL, carrier, 0.1 * k, 0.05, k % 2 ? mass : 1.0, 0.1);
        at[k] = k;
    }
    for (int k = count - 1; k > 0; --k) {
        const int other = test_integer(&rng, 0, k), was = at[k];
        at[k] = at[other], at[other] = was;
    }
    for (int k = 1; k < count; ++k) gear(s, wheel[at[k - 1]], wheel[at[k]], stiffness);
}

static void trains(void **state)
{
    (void)state;
    static const double stiffness[] = {0.0, 1e3, 1e9};
    for (int k = 0; k < 6; ++k) {
        loops s;
        loops_begin(&s, NULL);
        train(&s, 7, k % 2, 1.0, stiffness[k / 2]);
        compare(&s, 8);
    }
}

static void wheels_without_mass(void **state)
{
    (void)state;
    for (int k = 0; k < 2; ++k) {
        loops s;
        loops_begin(&s, NULL);
        train(&s, 7, k, 0.0, 0.0);
        compare(&s, 12);
    }
}

/* Legs of two rods on a carrier, each pinned to the next; the first also to the ground, past the carrier. */
static void ladders(void **state)
{
    (void)state;
    loops s;
    int last = MBSR_NONE;
    loops_begin(&s, NULL);
    const int first = loops_rod(&s, "first", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0),
              carrier = loops_rod(&s, "carrier", first, 1.0, 0.0, 2.0, 1.0);
    for (int k = 0; k < 6; ++k) {
        const int upper = loops_rod(&s, NULL, carrier, 0.2 * k, 0.0, 1.0, 0.5),
                  lower = loops_rod(&s, NULL, upper, 0.5, 0.0, 1.0, 0.5);
        const mbsr_closure_def rod = mbsr_closure_distance(
            k == 0 ? MBSR_GROUND : last, (double[3]){0.4, k == 0 ? 2.0 : 0.0, 0.0}, lower,
            (double[3]){0.4, 0.1, 0.0}, k == 0 ? 2.0 : 0.3);
        assert_ok(mbsr_model_add_closure(s.m, &rod, NULL), mbsr_model_error(s.m));
        last = lower;
    }
    compare(&s, 30);
}

/* A wheel geared to all others leaves nothing to divide: 12 multipliers, and 7 rates that might be delayed. */
static void one_front(void **state)
{
    (void)state;
    loops s;
    loops_begin(&s, NULL);
    const int carrier = loops_rod(&s, "carrier", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0),
              sun = loops_rod(&s, "sun", carrier, 0.0, 0.0, 1.0, 0.1);
    for (int k = 0; k < 6; ++k)
        gear(&s, sun, loops_rod(&s, NULL, carrier, 0.1 * k, 0.1, 1.0, 0.1), 0.0);
    compare(&s, 19);
}

/* Rings of wheels, one ratio of which follows from the others. */
static void rings(void **state)
{
    (void)state;
    loops s;
    int wheel[10];
    loops_begin(&s, NULL);
    for (int k = 0; k < 10; ++k)
        wheel[k] = loops_rod(&s, NULL, MBSR_GROUND, 0.1 * k, 0.0, 1.0, 0.1);
    for (int k = 0; k < 10; ++k) {
        mbsr_closure_def def = mbsr_closure_coupling(2, (int[2]){wheel[k], wheel[(k + 1) % 10]},
                                                     (int[2]){0, 0}, (double[2]){1.0, 1.0}, 0.0);
        assert_ok(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m));
    }
    compare(&s, 12);
}

/* Long trains have fronts like short ones, and as much memory a wheel. */
static void long_trains(void **state)
{
    (void)state;
    size_t bytes[2];
    for (int k = 0; k < 2; ++k) {
        loops s;
        loops_begin(&s, NULL);
        train(&s, k == 0 ? 40 : MOST, 0, 1.0, 0.0);
        loops_build(&s);
        mbsr_newton *newton = solver(&s, 0);
        assert_in_range(widest(newton), 1, 8);
        bytes[k] = newton->carried.bytes;
        mbsr_newton_destroy(newton);
        loops_free(&s);
    }
    assert_in_range(bytes[1], 4 * bytes[0], 6 * bytes[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trains),  cmocka_unit_test(wheels_without_mass),
        cmocka_unit_test(ladders), cmocka_unit_test(one_front),
        cmocka_unit_test(rings),   cmocka_unit_test(long_trains)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
