/* Reports and starts of mechanisms that are over-constrained, singular, contradictory, or given in
 * other units; reactions and inverse dynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Four-bar linkage in units of `unit` metres, with a distance that makes it rigid where asked for.
 */
static void four_bar(loops *s, double unit, int rigid)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0 * unit);
    const int b = loops_rod(s, "coupler", a, 1.0 * unit, 0.0, 2.5, 2.5 * unit);
    const int c = loops_rod(s, "rocker", MBSR_GROUND, 2.0 * unit, 0.0, 2.0, 2.0 * unit);
    loops_pin(s, "pin", b, 2.5 * unit, 0.0, c, 2.0 * unit, 0.0);
    const double end[3] = {1.0 * unit, 0.0, 0.0}, there[3] = {3.0 * unit, 0.0, 0.0};
    const mbsr_closure_def strut = mbsr_closure_distance(a, end, MBSR_GROUND, there, 2.86 * unit);
    for (int k = 0; k < rigid; ++k)
        assert_ok(mbsr_model_add_closure(s->m, &strut, NULL), mbsr_model_error(s->m));
    loops_finish(s);
    s->q[0] = 1.256084040027, s->q[1] = -0.8663220350055, s->q[2] = 1.254529363248;
}

static void units(void **state)
{
    (void)state;
    static const double unit[] = {1.0, 1e3, 1e-4};
    for (int k = 0; k < 3; ++k) {
        loops s;
        mbsr_closure_report report;
        int redundant[2], unique[2];
        four_bar(&s, unit[k], 0);
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, unique),
                  mbsr_data_error(s.d));
        assert_int_equal(report.independent, 2);
        assert_int_equal(report.nearby, 2);
        assert_int_equal(report.mobility, 1);
        assert_int_equal(redundant[0] + redundant[1], 0);
        assert_int_equal(unique[0] + unique[1], 2);
        assert_true(report.smallest_kept > 0.1);
        loops_free(&s);
    }
}

/* Rigid once, and twice over: nothing moves, and what is redundant is the strut added last. */
static void more_rows_than_freedoms(void **state)
{
    (void)state;
    for (int struts = 1; struts <= 2; ++struts) {
        loops s;
        double y[64], yp[64], F[64];
        mbsr_closure_report report;
        int redundant[4], unique[4], own, closure;
        const char *name;
        four_bar(&s, 1.0, struts);
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, s.q, NULL), mbsr_data_error(s.d));
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, unique),
                  mbsr_data_error(s.d));
        assert_int_equal(report.mobility, 0);
        assert_int_equal(report.independent, 3);
        for (int k = 0; k < s.rows; ++k) {
            assert_int_equal(redundant[k], k == 3);
            assert_int_equal(unique[k], k < 2 || struts == 1);
        }
        assert_ok(mbsr_closure_of_row(s.m, s.rows - 1, &closure, &own, &name), NULL);
        assert_int_equal(closure, struts);
        assert_int_equal(own, 0);
        assert_string_equal(name, "length");
        s.u[0] = 3.0;
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(s.d));
        assert_less(test_largest(s.nu, y + s.nq + s.nu), 1e-12);
        assert_less(test_largest(s.nu, yp + s.nq + s.nu), 1e-10);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), NULL);
        assert_less(test_largest(s.size, F), 1e-9);
        loops_free(&s);
    }
}

static int forwards(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double *speed = user;
    *s = *speed * t;
    *sdot = *speed;
    *sddot = 0.0;
    return 0;
}

/* Two motions of one crank that agree at t = 0, but not in speed. */
/* A weld of more rows than there are freedoms: what may be left out of it is its spring, not what
 * is rigid, and nothing moves. */
static void a_spring_beside_rigid_rows(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0};
    for (int stiff = 0; stiff < 3; ++stiff) {
        loops s;
        double y[64], yp[64];
        mbsr_closure_report report;
        int redundant[3];
        loops_begin(&s, NULL);
        const int a = loops_rod(&s, "upper", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
        const int b = loops_rod(&s, "lower", a, 1.0, 0.0, 1.0, 1.0);
        const double there[3] = {cos(1.0) + cos(0.5), sin(1.0) - sin(0.5), 0.0};
        const mbsr_frame tip = mbsr_frame_at(1.0, 0.0, 0.0),
                         wall = mbsr_frame_rotated(there, z, -0.5);
        mbsr_closure_def rows = mbsr_closure_weld(b, &tip, MBSR_GROUND, &wall);
        rows.stiffness[stiff] = 1e6, rows.damping[stiff] = 10.0;
        assert_ok(mbsr_model_add_closure(s.m, &rows, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        s.q[0] = 1.0, s.q[1] = -1.5;
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, s.q, NULL), mbsr_data_error(s.d));
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
                  mbsr_data_error(s.d));
        assert_int_equal(report.independent, 2);
        assert_int_equal(report.mobility, 0);
        for (int k = 0; k < 3; ++k) assert_int_equal(redundant[k], 0);
        s.u[0] = 1.0;
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(s.d));
        assert_less(test_largest(s.nu, y + s.nq + s.nu), 1e-12);
        loops_free(&s);
    }
}

static void contradictory_motions(void **state)
{
    (void)state;
    double speed[2] = {1.0, 2.0}, y[64], yp[64];
    loops s;
    loops_begin(&s, NULL);
    loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    for (int k = 0; k < 2; ++k) {
        mbsr_closure_def drive =
            mbsr_closure_coupling(1, (int[1]){0}, (int[1]){0}, (double[1]){1.0}, 0.0);
        drive.name = k ? "second drive" : "first drive";
        drive.motion = forwards;
        drive.user = speed + k;
        assert_ok(mbsr_model_add_closure(s.m, &drive, NULL), mbsr_model_error(s.m));
    }
    loops_finish(&s);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    assert_refused(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                   mbsr_data_error(s.d), MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE,
                   "mbsr_dae_consistent|second drive|velocity row|contradict");
    assert_refused(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 1.0, y, yp, NULL, NULL),
                   mbsr_data_error(s.d), MBSR_LOOP_OPEN, 0, MBSR_NONE, "drive|stays open");
    speed[1] = 1.0;
    assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 1.0, y, yp, NULL, NULL),
              mbsr_data_error(s.d));
    assert_close(y[0], 1.0, 1e-12);
    assert_close(y[2], 1.0, 1e-12);
    loops_free(&s);
}

/* A parallelogram with all links in one line: fewer rows are independent than nearby. */
static void a_singular_position(void **state)
{
    (void)state;
    loops s;
    mbsr_closure_report report;
    int redundant[2];
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "b", a, 1.0, 0.0, 1.0, 1.0);
    const int c = loops_rod(&s, "c", MBSR_GROUND, 1.0, 0.0, 1.0, 1.0);
    loops_pin(&s, "pin", b, 1.0, 0.0, c, 1.0, 0.0);
    loops_finish(&s);
    assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
              mbsr_data_error(s.d));
    assert_int_equal(report.independent, 1);
    assert_int_equal(report.nearby, 2);
    assert_int_equal(redundant[0] + redundant[1], 0);
    assert_int_equal(report.mobility, 2);
    loops_free(&s);
}

/* Cranks in a row, each driven by the one before through a rod, all in one line: every loop is
 * singular, and turns its own way near there, so that few positions show all rows independent. */
static void singular_in_every_loop(void **state)
{
    (void)state;
    for (int loops_in_row = 1; loops_in_row <= 8; ++loops_in_row) {
        loops s;
        mbsr_closure_report report;
        int redundant[16];
        loops_begin(&s, NULL);
        int crank = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
        for (int k = 1; k <= loops_in_row; ++k) {
            const int rod = loops_rod(&s, NULL, crank, 1.0, 0.0, 1.0, 1.0);
            crank = loops_rod(&s, NULL, MBSR_GROUND, k, 0.0, 1.0, 1.0);
            loops_pin(&s, NULL, rod, 1.0, 0.0, crank, 1.0, 0.0);
        }
        loops_finish(&s);
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
                  mbsr_data_error(s.d));
        assert_int_equal(report.independent, loops_in_row);
        assert_int_equal(report.nearby, 2 * loops_in_row);
        for (int k = 0; k < report.rows; ++k) assert_int_equal(redundant[k], 0);
        loops_free(&s);
    }
}

/* A coupler on three legs, all in one line: one of four rows is redundant for good, and one more
 * here. */
static void singular_and_redundant(void **state)
{
    (void)state;
    loops s;
    mbsr_closure_report report;
    int redundant[4];
    loops_begin(&s, NULL);
    const int leg = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              coupler = loops_rod(&s, NULL, leg, 1.0, 0.0, 1.0, 4.0);
    for (int k = 1; k <= 2; ++k) {
        const int other = loops_rod(&s, NULL, MBSR_GROUND, 2.0 * k, 0.0, 1.0, 1.0);
        loops_pin(&s, NULL, coupler, 2.0 * k, 0.0, other, 1.0, 0.0);
    }
    loops_finish(&s);
    assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
              mbsr_data_error(s.d));
    assert_int_equal(report.independent, 2);
    assert_int_equal(report.nearby, 3);
    assert_int_equal(redundant[0] + redundant[1] + redundant[2] + redundant[3], 1);
    loops_free(&s);
}

/* At rest, a weight on a beam between a hinge and a pin: reactions share it, the torque at one
 * joint or another holds the linkage, and too few actuators are refused by name. */
static void reactions_and_torques(void **state)
{
    (void)state;
    loops s;
    four_bar(&s, 1.0, 0);
    const mbsr_error *error = mbsr_data_error(s.d);
    double udot[3], lambda[2], tau[3], both[3], zero[3] = {0.0}, wrench[3], sum[2] = {0.0};
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, s.q, NULL), error);
    /* the crank holds; all forces at the ground carry the weight */
    assert_ok(loops_inverse_dynamics(s.m, s.d, 0.0, s.q, zero, zero, 1, (int[1]){0}, tau, lambda),
              error);
    assert_true(fabs(tau[1]) <= 0.0 && fabs(tau[2]) <= 0.0);
    /* what is asked for next is that of the motion with these loop forces */
    double carried = 0.0;
    for (int body = 0; body < 3; body += 2) {
        assert_ok(mbsr_joint_reaction(s.m, s.d, body, wrench), error);
        carried += wrench[1];
    }
    assert_close(carried, 9.81 * 5.5, 1e-10);
    assert_ok(mbsr_closures_lambda(s.m, s.d, both), error);
    for (int k = 0; k < 2; ++k) assert_close(both[k], lambda[k], 1e-15);
    /* without motors named every rate has one, and the pin that closes the loop carries nothing */
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, zero, zero, NULL, both), error);
    assert_true(fabs(both[1]) > 1.0);
    assert_ok(mbsr_closures_lambda(s.m, s.d, both), error);
    for (int k = 0; k < 2; ++k) assert_true(fabs(both[k]) <= 0.0);
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, zero, tau, udot), error);
    assert_less(test_largest(3, udot), 1e-10);
    assert_ok(mbsr_closures_lambda(s.m, s.d, both), error);
    for (int k = 0; k < 2; ++k) assert_close(both[k], lambda[k], 1e-10);
    for (int body = 0; body < 3; body += 2) {
        assert_ok(mbsr_joint_reaction(s.m, s.d, body, wrench), error);
        for (int k = 0; k < 2; ++k) sum[k] += wrench[k];
    }
    assert_close(sum[0], 0.0, 1e-10);
    assert_close(sum[1], 9.81 * 5.5, 1e-10);
    /* the same with the loop forces given */
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), error);
    assert_ok(mbsr_stage_velocities(s.m, s.d, zero), error);
    assert_ok(mbsr_closures_set_lambda(s.m, s.d, lambda), error);
    assert_ok(mbsr_stage_forces(s.m, s.d, tau), error);
    assert_ok(mbsr_stage_accelerations(s.m, s.d, zero), error);
    assert_ok(mbsr_joint_reaction(s.m, s.d, 0, wrench), error);
    assert_ok(mbsr_joint_reaction(s.m, s.d, 2, both), error);
    assert_close(wrench[1] + both[1], 9.81 * 5.5, 1e-10);
    /* crank and rocker: less torque than either alone */
    double two[3];
    assert_ok(
        loops_inverse_dynamics(s.m, s.d, 0.0, s.q, zero, zero, 2, (int[2]){0, 2}, two, lambda),
        error);
    assert_true(hypot(two[0], two[2]) < fabs(tau[0]));
    assert_int_equal(loops_inverse_dynamics(s.m, s.d, 0.0, s.q, zero, zero, 0, NULL, tau, lambda),
                     MBSR_UNDETERMINED);
    assert_contains(error->text, "driven by none");
    assert_int_equal(
        loops_inverse_dynamics(s.m, s.d, 0.0, s.q, zero, zero, 1, (int[1]){7}, tau, lambda),
        MBSR_ERR_VALUE);
    loops_free(&s);
}

static double size_of(const double x[3])
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* Two links without mass that reach from the ground to a rocker: their joints see det J = l m sin q
 * and |J|^2 = r^2 + m^2, r the distance bridged. Many such, of which one is nearly straight. */
static void links_that_are_stretched(void **state)
{
    (void)state;
    enum { COUNT = 50, STRAIGHT = 33 };
    static const double l = 0.5, m = 0.4, rocker = 0.3;
    mbsr_closure_report report;
    loops s;
    loops_begin(&s, NULL);
    for (int k = 0; k < COUNT; ++k) {
        const int a = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.0, 0.0, l),
                  b = loops_rod(&s, NULL, a, l, 0.0, 0.0, m),
                  c = loops_rod(&s, NULL, MBSR_GROUND, 0.6, 0.0, 1.0, rocker);
        loops_pin(&s, NULL, b, m, 0.0, c, rocker, 0.0);
    }
    loops_build(&s);
    double *q = calloc(3 * COUNT, sizeof *q), least = 1.0, most = 0.0;
    for (int k = 0; k < COUNT; ++k) {
        const double bend = k == STRAIGHT ? 1e-3 : 0.5 + 0.01 * k,
                     reach = sqrt(l * l + m * m + 2.0 * l * m * cos(bend)),
                     sum = reach * reach + m * m, product = l * m * sin(bend),
                     larger = sqrt(0.5 * (sum + sqrt(sum * sum - 4.0 * product * product))),
                     x = (0.36 + reach * reach - rocker * rocker) / 1.2,
                     y = sqrt(reach * reach - x * x);
        q[3 * k] = atan2(y, x) - atan2(m * sin(bend), l + m * cos(bend));
        q[3 * k + 1] = bend;
        q[3 * k + 2] = atan2(y, x - 0.6);
        const double one = q[3 * k], both = one + bend, other = q[3 * k + 2],
                     across[3] = {l * sin(one) + m * sin(both), m * sin(both), rocker * sin(other)},
                     along[3] = {l * cos(one) + m * cos(both), m * cos(both), rocker * cos(other)},
                     longest = fmax(size_of(across), size_of(along));
        most = fmax(most, larger / longest);
        least = fmin(least, product / larger / longest);
    }
    assert_ok(mbsr_closures_report(s.m, s.d, 0.0, q, &report, NULL, NULL), mbsr_data_error(s.d));
    assert_less(report.gap, 1e-12);
    assert_int_equal(report.massless, 2 * COUNT);
    assert_int_equal(report.undetermined, 0);
    assert_int_equal(report.mobility, COUNT);
    assert_close(report.stretch, least / most, 1e-9 * least / most);
    assert_int_equal(report.stretched / 2, STRAIGHT);
    free(q);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(units),
                                       cmocka_unit_test(links_that_are_stretched),
                                       cmocka_unit_test(more_rows_than_freedoms),
                                       cmocka_unit_test(a_spring_beside_rigid_rows),
                                       cmocka_unit_test(contradictory_motions),
                                       cmocka_unit_test(a_singular_position),
                                       cmocka_unit_test(singular_in_every_loop),
                                       cmocka_unit_test(singular_and_redundant),
                                       cmocka_unit_test(reactions_and_torques)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
