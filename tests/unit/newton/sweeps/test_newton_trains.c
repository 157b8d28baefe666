/* Newton systems where many loops close on one body, each beside few others: trains of wheels,
 * ladders. As by blocks and as the dense matrix, and in fronts that do not grow with the number of
 * loops.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"

#include <stdlib.h>

enum { MOST = 200 };

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

static void look(const mbsr_newton *newton, int most)
{
    assert_in_range(widest(newton), 1, most);
}

/* most: unknowns of any front. */
static void compare_by(loops *s, newton_sweeps sweeps, int most)
{
    test_rng rng = test_seed(11);
    loops_finish(s);
    for (int k = 0; k < s->nq; ++k) s->q[k] = 0.3 * test_uniform(&rng);
    test_fill(&rng, s->nu, s->u);
    newton_both_ways(s->m, s->d, s->q, s->u, sweeps, look, most);
    loops_free(s);
}

static void compare(loops *s, int most)
{
    compare_by(s, ONE_SWEEP, most);
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

/* Their rates wait beside loops that go on: all by the front. */
static void wheels_without_mass(void **state)
{
    (void)state;
    for (int k = 0; k < 2; ++k) {
        loops s;
        loops_begin(&s, NULL);
        train(&s, 7, k, 0.0, 0.0);
        compare_by(&s, BY_FRONT, 0);
    }
}

/* Legs of two rods on a carrier, each pinned to the next; the first also to the ground, past the
 * carrier. */
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

/* A wheel geared to all others leaves nothing to divide: 12 multipliers, and 7 rates that might be
 * delayed. */
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
        mbsr_newton *newton = newton_solver(s.m, 0);
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
