/* Newton systems of stiff closures along the axes of a body, whose forces turn with it: without
 * unknowns beside the multipliers, as by the front and as the dense matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"

#include <stdlib.h>

static int count_turned(const mbsr_newton *newton)
{
    int count = 0;
    for (int k = 0; k < (int)newton->model->closures.count; ++k) {
        const mbsri_loop *loop = newton->carried.loop + k;
        assert_true(!loop->follower || loop->rank == 0);
        count += loop->follower;
    }
    return count;
}

static void look(const mbsr_newton *newton, int turned)
{
    assert_int_equal(count_turned(newton), turned);
}

/* turned: how many closures are of this kind. */
static void compare(loops *s, int turned)
{
    test_rng rng = test_seed(11);
    loops_finish(s);
    for (int k = 0; k < s->nq; ++k) s->q[k] = 0.5 + 0.4 * test_uniform(&rng);
    test_fill(&rng, s->nu, s->u);
    newton_both_ways(s->m, s->d, s->q, s->u, ONE_SWEEP, look, turned);
    loops_free(s);
}

/* A closure with other springs and dampers in each of the rows from `first` on; wide gaps of soft
 * ones stay as they are. */
static void add_stiff(loops *s, mbsr_closure_def def, int first, int rows, double stiffness)
{
    for (int k = first; k < rows; ++k) {
        def.stiffness[k] = (1.0 + 0.3 * k) * stiffness;
        def.damping[k] = (0.02 - 0.003 * k) * stiffness;
    }
    def.settled = first > 0 || stiffness > 1e3;
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* ---- in the plane ---- */

/* Which body the rows turn with. */
enum { ON_ROCKER, ON_BASE, ON_GROUND, ON_COUPLER };

static void fourbar(int on, double coupler, int first, double stiffness, int turned)
{
    static const double end[3] = {0.6, 0.1, 0.0}, far[3] = {0.9, -0.2, 0.0};
    loops s;
    loops_begin(&s, NULL);
    const int base = loops_rod(&s, "base", MBSR_GROUND, 0.1, 0.0, 1.0, 1.0),
              crank = loops_rod(&s, "crank", base, 0.2, 0.0, 1.0, 0.5),
              link = loops_rod(&s, "coupler", crank, 0.5, 0.0, coupler, 0.6),
              rocker = loops_rod(&s, "rocker", base, 0.9, 0.0, 2.0, 0.7);
    const int other = on == ON_BASE ? base : on == ON_GROUND ? MBSR_GROUND : rocker;
    add_stiff(&s,
              on == ON_COUPLER ? mbsr_closure_ball(rocker, far, link, end)
                               : mbsr_closure_ball(link, end, other, far),
              first, 2, stiffness);
    compare(&s, turned);
}

static void pins_in_the_plane(void **state)
{
    (void)state;
    for (double k = 1e2; k < 1e9; k *= 1e3) {
        fourbar(ON_ROCKER, 1.0, 0, k, 1);
        fourbar(ON_BASE, 1.0, 0, k, 1);
        fourbar(ON_GROUND, 1.0, 0, k, 0);
    }
}

static void one_row_is_rigid(void **state)
{
    (void)state;
    fourbar(ON_ROCKER, 1.0, 1, 1e3, 1);
    fourbar(ON_BASE, 1.0, 1, 1e6, 1);
}

static void held_without_mass(void **state)
{
    (void)state;
    fourbar(ON_ROCKER, 0.0, 0, 1e3, 1);
    fourbar(ON_ROCKER, 0.0, 0, 1e8, 1);
    fourbar(ON_COUPLER, 0.0, 0, 1e3, 1);
    fourbar(ON_COUPLER, 0.0, 0, 1e8, 1);
}

/* ---- in space ---- */

static int add(loops *s, int parent, mbsr_joint joint)
{
    static const double com[3] = {0.2, 0.05, 0.1}, tensor[6] = {0.2, 0.3, 0.4, 0.0, 0.01, 0.0};
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = joint;
    body.inertia = mbsr_inertia_rigid(1.2, com, tensor);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

/* Two arms on a body: one of hinges, the other on a universal joint; tied at their ends. */
static void arms(mbsr_closure_def (*make)(int a, int b), int first, int rows, double stiffness)
{
    static const double axis[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.3, 1.0, -0.4}};
    const mbsr_frame at = mbsr_frame_at(0.4, 0.1, 0.2), back = mbsr_frame_at(-0.3, 0.2, 0.0);
    loops s;
    loops_begin(&s, NULL);
    const int base = add(&s, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, axis[2]));
    int a = base;
    for (int k = 0; k < 3; ++k) a = add(&s, a, mbsr_joint_revolute(&at, NULL, axis[k]));
    int b = add(&s, base, mbsr_joint_universal(&back, NULL, axis[0], axis[1]));
    b = add(&s, b, mbsr_joint_revolute(&at, NULL, axis[1]));
    add_stiff(&s, make(a, b), first, rows, stiffness);
    compare(&s, 1);
}

static mbsr_closure_def ball(int a, int b)
{
    return mbsr_closure_ball(a, (double[3]){0.3, 0.0, 0.1}, b, (double[3]){0.0, 0.4, 0.2});
}

static mbsr_closure_def weld(int a, int b)
{
    const mbsr_frame at = mbsr_frame_at(0.3, -0.2, 0.1);
    return mbsr_closure_weld(a, &at, b, NULL);
}

static void pins_in_space(void **state)
{
    (void)state;
    for (double k = 1e2; k < 1e9; k *= 1e3) arms(ball, 0, 3, k);
    arms(ball, 1, 3, 1e4);
}

static void welds(void **state)
{
    (void)state;
    for (double k = 1e2; k < 1e9; k *= 1e3) arms(weld, 0, 6, k);
}

/* A stiff rod between two bodies resists a turn of its line, which no row knows. */
static void rods_are_not_of_this_kind(void **state)
{
    (void)state;
    static const double end[3] = {0.6, 0.1, 0.0};
    loops s;
    loops_begin(&s, NULL);
    const int base = loops_rod(&s, "base", MBSR_GROUND, 0.1, 0.0, 1.0, 1.0),
              crank = loops_rod(&s, "crank", base, 0.2, 0.0, 1.0, 0.5),
              rocker = loops_rod(&s, "rocker", base, 0.9, 0.0, 2.0, 0.7);
    add_stiff(&s, mbsr_closure_distance(crank, end, rocker, end, 0.4), 0, 1, 1e3);
    compare(&s, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pins_in_the_plane),
                                       cmocka_unit_test(one_row_is_rigid),
                                       cmocka_unit_test(held_without_mass),
                                       cmocka_unit_test(pins_in_space),
                                       cmocka_unit_test(welds),
                                       cmocka_unit_test(rods_are_not_of_this_kind)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
