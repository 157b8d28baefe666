/* Orders of the stepper's methods: errors by halving the step, beside a reference of steps 32
 * times as short; a tree, a closed loop, and parts without mass that are damped (index 1) or on
 * springs alone (index 2).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "loops.h"

#include <string.h>

enum { MOST = 16 };

typedef struct scene {
    loops s; /* model, data, q and u at the start */
    double T;
} scene;

/* ---- scenes ---- */

/* Two rods of 1 m on hinges, a spring with damper in the second. */
static void open_tree(scene *x)
{
    loops_begin(&x->s, NULL);
    const int a = loops_rod(&x->s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&x->s, "b", a, 1.0, 0.0, 2.0, 1.0);
    const mbsr_force_def spring = mbsr_force_joint_spring(b, 0, 20.0, 0.5, 0.0);
    assert_ok(mbsr_model_add_force(x->s.m, &spring, NULL), mbsr_model_error(x->s.m));
    loops_finish(&x->s);
    x->s.q[0] = 0.3, x->s.q[1] = -0.5;
    x->s.u[0] = 1.0, x->s.u[1] = 2.0;
}

/* A four-bar linkage; the coupler has that mass, its pin that stiffness (N/m; 0: rigid). */
static void open_loop(scene *x, double coupler, double stiffness)
{
    loops_begin(&x->s, NULL);
    const int a = loops_rod(&x->s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&x->s, "coupler", a, 1.0, 0.0, coupler, 2.5);
    const int c = loops_rod(&x->s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    const double on_coupler[3] = {2.5, 0.0, 0.0}, on_rocker[3] = {2.0, 0.0, 0.0};
    mbsr_closure_def pin = mbsr_closure_ball(b, on_coupler, c, on_rocker);
    for (int k = 0; k < 2; ++k) pin.stiffness[k] = stiffness, pin.damping[k] = 1e-4 * stiffness;
    assert_ok(mbsr_model_add_closure(x->s.m, &pin, NULL), mbsr_model_error(x->s.m));
    loops_finish(&x->s);
    x->s.q[0] = 1.2, x->s.q[1] = -0.9, x->s.q[2] = 1.3;
    x->s.u[0] = 3.0;
}

/* A pendulum of 1 kg whose bead has no mass and is held by springs, 100 N/m, and dampers (N s/m)
 * in x and y. */
static void open_bead(scene *x, double damping)
{
    const mbsr_planar_frame none = {0};
    loops_begin(&x->s, NULL);
    const int bead =
        test_add_body(x->s.m, MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_zero());
    for (int axis = 0; axis < 2; ++axis) {
        const mbsr_force_def spring = mbsr_force_joint_spring(bead, axis, 100.0, damping, 0.0);
        assert_ok(mbsr_model_add_force(x->s.m, &spring, NULL), mbsr_model_error(x->s.m));
    }
    const double com[2] = {0.0, -1.0};
    test_add_body(x->s.m, bead, mbsr_joint_planar_revolute(none, none),
                  mbsr_inertia_planar(1.0, com, 0.0));
    loops_finish(&x->s);
    x->s.q[2] = 0.8;
    x->s.u[2] = 0.5;
}

static void open_coupled(scene *x)
{
    open_loop(x, 2.5, 0.0);
}

static void open_massless(scene *x)
{
    open_loop(x, 0.0, 0.0);
}

static void open_stiff(scene *x)
{
    open_loop(x, 2.5, 1e10);
}

static void open_damped(scene *x)
{
    open_bead(x, 5.0);
}

static void open_elastic(scene *x)
{
    open_bead(x, 0.0);
}

/* ---- runs ---- */

/* q and u after `steps` steps. */
static void run(const scene *x, int order, int steps, double *q, double *u)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_stepper *stepper;
    mbsr_error error;
    opt.h = x->T / steps;
    opt.order = order;
    opt.tolerance = 1e-13;
    opt.halvings = 0;
    assert_ok(mbsr_stepper_create(x->s.m, x->s.d, &opt, &stepper, &error), &error);
    assert_ok(mbsr_stepper_start(stepper, 0.0, x->s.q, x->s.u), mbsr_stepper_error(stepper));
    for (int k = 0; k < steps; ++k)
        assert_ok(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
    assert_int_equal(mbsr_stepper_motion(stepper, NULL, q, u), MBSR_OK);
    mbsr_stepper_destroy(stepper);
}

static double distance(int n, const double *a, const double *b)
{
    double largest = 0.0;
    for (int k = 0; k < n; ++k) largest = fmax(largest, fabs(a[k] - b[k]));
    return largest;
}

/* q and u at T = 1 s converge with these orders. */
static void check_order(void (*open)(scene *), int order, double order_q, double order_u)
{
    enum { COARSE = 256, FINE = 32 };
    scene x = {.T = 1.0};
    double q[MOST], u[MOST], exact_q[MOST], exact_u[MOST], last_q = 0.0, last_u = 0.0;
    open(&x);
    run(&x, 2, COARSE * FINE, exact_q, exact_u);
    for (int steps = COARSE; steps <= 2 * COARSE; steps *= 2) {
        run(&x, order, steps, q, u);
        const double error_q = distance(x.s.nq, q, exact_q);
        const double error_u = distance(x.s.nu, u, exact_u);
        if (steps > COARSE) {
            assert_close(log2(last_q / error_q), order_q, 0.2);
            assert_close(log2(last_u / error_u), order_u, 0.2);
        }
        last_q = error_q;
        last_u = error_u;
    }
    loops_free(&x.s);
}

static void a_tree_has_orders_1_and_2(void **state)
{
    (void)state;
    check_order(open_tree, 1, 1.0, 1.0);
    check_order(open_tree, 2, 2.0, 2.0);
}

static void a_loop_has_orders_1_and_2(void **state)
{
    (void)state;
    check_order(open_coupled, 1, 1.0, 1.0);
    check_order(open_coupled, 2, 2.0, 2.0);
}

static void a_loop_with_a_massless_link_has_orders_1_and_2(void **state)
{
    (void)state;
    check_order(open_massless, 1, 1.0, 1.0);
    check_order(open_massless, 2, 2.0, 2.0);
}

static void a_stiff_pin_has_orders_1_and_2(void **state)
{
    (void)state;
    check_order(open_stiff, 1, 1.0, 1.0);
    check_order(open_stiff, 2, 2.0, 2.0);
}

static void a_damped_massless_bead_has_orders_1_and_2(void **state)
{
    (void)state;
    check_order(open_damped, 1, 1.0, 1.0);
    check_order(open_damped, 2, 2.0, 2.0);
}

/* Index 2: what has no mass is a difference of positions over the step. */
static void a_massless_bead_on_springs_alone_has_order_2_in_positions_1_in_velocities(void **state)
{
    (void)state;
    check_order(open_elastic, 1, 1.0, 1.0);
    check_order(open_elastic, 2, 2.0, 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tree_has_orders_1_and_2),
        cmocka_unit_test(a_loop_has_orders_1_and_2),
        cmocka_unit_test(a_loop_with_a_massless_link_has_orders_1_and_2),
        cmocka_unit_test(a_stiff_pin_has_orders_1_and_2),
        cmocka_unit_test(a_damped_massless_bead_has_orders_1_and_2),
        cmocka_unit_test(a_massless_bead_on_springs_alone_has_order_2_in_positions_1_in_velocities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
