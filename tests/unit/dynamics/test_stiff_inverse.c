/* Inverse dynamics of mechanisms with stiff rows: springs count once, as the same springs do that
 * are force elements, whatever moves the joints and whichever way the equations are solved.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_equations.h"

#include <math.h>
#include <string.h>

enum { RODS = 3, RIGID = 2, PIN = 2, STIFF = 3 }; /* rows of the pin, of the stiff one, of both */

static const double k_pin = 700.0, k_gear = 90.0, d_gear = 4.0, ratio = -1.5, rest = 0.1;

/* Three rods whose end is pinned to the ground; two of them are tied by a spring without length and
 * by a gear, which are stiff rows or force elements. */
static void make(loops *s, bool rows)
{
    static const double a[3] = {0.3, 0.2, 0.0}, b[3] = {0.7, -0.1, 0.0};
    int rod[RODS], coordinate[2] = {0, 0};
    loops_begin(s, NULL);
    rod[0] = loops_rod(s, "a", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0);
    rod[1] = loops_rod(s, "b", rod[0], 1.0, 0.0, 3.0, 1.5);
    rod[2] = loops_rod(s, "c", rod[1], 1.5, 0.0, 1.0, 1.0);
    loops_pin(s, "end", rod[2], 1.0, 0.0, MBSR_GROUND, 1.2, 0.1);
    if (rows) {
        const int geared[2] = {rod[0], rod[2]};
        mbsr_closure_def pin = mbsr_closure_ball(rod[0], a, rod[2], b),
                         gear = mbsr_closure_coupling(2, geared, coordinate,
                                                      (double[2]){1.0, -ratio}, rest);
        pin.stiffness[0] = pin.stiffness[1] = k_pin;
        gear.stiffness[0] = k_gear;
        gear.damping[0] = d_gear;
        assert_ok(mbsr_model_add_closure(s->m, &pin, NULL), mbsr_model_error(s->m));
        assert_ok(mbsr_model_add_closure(s->m, &gear, NULL), mbsr_model_error(s->m));
    } else {
        const mbsr_gear teeth = {
            .ratio = ratio, .stiffness = k_gear, .damping = d_gear, .rest = rest};
        const mbsr_force_def pin = mbsr_force_point_spring(rod[0], a, rod[2], b, k_pin, 0.0, 0.0),
                             gear = mbsr_force_gear(rod[0], 0, rod[2], 0, &teeth);
        assert_ok(mbsr_model_add_force(s->m, &pin, NULL), mbsr_model_error(s->m));
        assert_ok(mbsr_model_add_force(s->m, &gear, NULL), mbsr_model_error(s->m));
    }
    loops_finish(s);
    assert_int_equal(s->rows, rows ? RIGID + STIFF : RIGID);
    memcpy(s->q, (double[RODS]){1.1, -1.3, -0.9}, sizeof(double[RODS]));
}

/* What a call leaves of tau, and of reactions; lambda where there are motors. */
typedef struct found {
    double tau[RODS], reaction[RODS][3], lambda[RIGID + STIFF];
} found;

static void drive(loops *s, const mbsr_motors *motors, const double *udot, found *x)
{
    const mbsr_error *error = mbsr_data_error(s->d);
    memset(x, 0, sizeof *x);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, s->q, s->u, udot, motors, x->tau), error);
    if (motors) assert_ok(mbsr_closures_lambda(s->m, s->d, x->lambda), error);
    for (int k = 0; k < RODS; ++k)
        assert_ok(mbsr_joint_reaction(s->m, s->d, k, x->reaction[k]), error);
}

static void assert_springs_once(loops *rows, loops *elements, const mbsr_motors *motors,
                                const double *udot)
{
    found of_rows, of_elements;
    double gap[STIFF + RIGID], rate[STIFF + RIGID];
    drive(elements, motors, udot, &of_elements);
    drive(rows, motors, udot, &of_rows);
    for (int k = 0; k < RODS; ++k) {
        assert_close(of_rows.tau[k], of_elements.tau[k], 1e-10);
        for (int l = 0; l < 3; ++l)
            assert_close(of_rows.reaction[k][l], of_elements.reaction[k][l], 1e-9);
    }
    if (!motors) return;
    loops_rows(rows, 0.0, rows->q, rows->u, NULL, gap, rate, NULL);
    for (int k = 0; k < RIGID; ++k) assert_close(of_rows.lambda[k], of_elements.lambda[k], 1e-9);
    for (int k = RIGID; k < RIGID + STIFF; ++k) {
        const bool pin = k < RIGID + PIN;
        const double law = -(pin ? k_pin : k_gear) * gap[k] - (pin ? 0.0 : d_gear * rate[k]);
        assert_true(law * law > 1.0);
        assert_close(of_rows.lambda[k], law, 1e-9);
    }
    double back[RODS]; /* forward dynamics under these torques */
    assert_ok(mbsr_forward_dynamics(rows->m, rows->d, 0.0, rows->q, rows->u, of_rows.tau, back),
              mbsr_data_error(rows->d));
    for (int k = 0; k < RODS; ++k) assert_close(back[k], udot[k], 1e-9);
}

static void springs_count_once(void **state)
{
    static const int every[RODS] = {0, 1, 2};
    const mbsr_motors one = {1, every + 1}, two = {2, every}, all = {RODS, every};
    const mbsr_motors *const motors[] = {NULL, &one, &two, &all};
    loops rows, elements;
    double udot[RODS];
    (void)state;
    make(&rows, true);
    make(&elements, false);
    loops_close(&elements, 0.0);
    memcpy(elements.u, (double[RODS]){0.7, -0.4, 0.9}, sizeof udot);
    loops_velocities(&elements, 0.0);
    memcpy(rows.q, elements.q, sizeof rows.q);
    memcpy(rows.u, elements.u, sizeof rows.u);
    assert_ok(mbsr_forward_dynamics(elements.m, elements.d, 0.0, elements.q, elements.u,
                                    (double[RODS]){3.0, -2.0, 5.0}, udot),
              mbsr_data_error(elements.d));
    for (int k = 0; k < 4; ++k) {
        assert_springs_once(&rows, &elements, motors[k], udot);
        mbsri_sweep_loops *plan = loops_hide_plan(rows.m);
        assert_springs_once(&rows, &elements, motors[k], udot);
        loops_show_plan(rows.m, plan);
    }
    loops_free(&rows);
    loops_free(&elements);
}

/* A rod held at an angle by a stiff row alone: weight and spring by hand. */
static void one_rod(void **state)
{
    const double q = 0.4, u = 0.3, m = 2.0, length = 1.0, zero = 0.0;
    const int first = 0;
    double tau, lambda, reaction[3];
    loops s;
    (void)state;
    loops_begin(&s, NULL);
    const int rod = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, m, length);
    mbsr_closure_def spring = mbsr_closure_coupling(1, &rod, &first, (double[1]){1.0}, rest);
    spring.stiffness[0] = k_gear;
    spring.damping[0] = d_gear;
    assert_ok(mbsr_model_add_closure(s.m, &spring, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    const double of_spring = -k_gear * (q - rest) - d_gear * u,
                 need = m * 9.81 * 0.5 * length * cos(q) - of_spring;
    const mbsr_motors motors = {1, &first}, *const given[2] = {NULL, &motors};
    for (int k = 0; k < 4; ++k) {
        mbsri_sweep_loops *plan = k < 2 ? NULL : loops_hide_plan(s.m);
        assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, &q, &u, &zero, given[k % 2], &tau),
                  mbsr_data_error(s.d));
        assert_close(tau, need, 1e-12);
        assert_ok(mbsr_closures_lambda(s.m, s.d, &lambda), mbsr_data_error(s.d));
        assert_close(lambda, of_spring, 1e-12);
        assert_ok(mbsr_joint_reaction(s.m, s.d, rod, reaction), mbsr_data_error(s.d));
        assert_close(reaction[2], need + of_spring, 1e-12); /* drives and springs included */
        if (plan) loops_show_plan(s.m, plan);
    }
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(springs_count_once),
        cmocka_unit_test(one_rod),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
