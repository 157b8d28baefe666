/* Massless rods in a loop whose knees only springs hold (index 2): the start, and runs from it.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

/* Crank and rocker of 1 m, three massless rods of 1 m between them, springs at the knees. */
static void knees(loops *s)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(s, "rod 1", a, 1.0, 0.0, 0.0, 1.0);
    const int c = loops_rod(s, "rod 2", b, 1.0, 0.0, 0.0, 1.0);
    const int e = loops_rod(s, "rod 3", c, 1.0, 0.0, 0.0, 1.0);
    const int f = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 1.0);
    const double end[3] = {1.0, 0.0, 0.0}, one[3] = {1.0, 3.0, 0.0}, two[3] = {1.5, 3.0, 0.0};
    const mbsr_force_def spring[2] = {
        mbsr_force_point_spring(b, end, MBSR_GROUND, one, 60.0, 0.0, 0.2),
        mbsr_force_point_spring(c, end, MBSR_GROUND, two, 60.0, 0.0, 0.2)};
    for (int j = 0; j < 2; ++j) assert_ok(mbsr_model_add_force(s->m, spring + j, NULL), NULL);
    loops_pin(s, "rod-rocker", e, 1.0, 0.0, f, 1.0, 0.0);
    loops_finish(s);
    /* balanced, found by another program */
    const double q[5] = {3.93321262525072, -2.83803561485635, -0.0820704801975814,
                         -1.51996695250605, 2.57048771793107};
    memcpy(s->q, q, sizeof q);
}

/* y and y' of a start from q, u, which become those of the start. */
static mbsr_consistent_info start(loops *s, double *q, double *u, double *yp)
{
    double y[8 * LOOPS_MOST];
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
    assert_ok(mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info),
              mbsr_data_error(s->d));
    memcpy(q, y, 5 * sizeof *q);
    memcpy(u, y + 10, 5 * sizeof *u);
    return info;
}

/* Rods that are not balanced are moved, and they alone. */
static void positions(void **state)
{
    (void)state;
    static const double away[3][3] = {{0.0, 0.0, 0.0}, {0.02, -0.03, 0.01}, {-0.2, 0.1, 0.3}};
    loops s;
    knees(&s);
    for (int k = 0; k < 3; ++k) {
        double q[5], u[5] = {0.0}, yp[64], guess[5], weight[5] = {1e6, 1.0, 1.0, 1.0, 1e6};
        mbsr_assembly_opt opt = mbsr_default_assembly_opt();
        opt.weight = weight;
        memcpy(guess, s.q, sizeof guess);
        for (int j = 0; j < 3; ++j) guess[1 + j] += away[k][j];
        /* the loop closed by the rods */
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, &opt, q, NULL), mbsr_data_error(s.d));
        const double crank = q[0], rocker = q[4];
        const mbsr_consistent_info info = start(&s, q, u, yp);
        assert_int_equal(info.null_directions, 1);
        assert_int_equal(info.elastic, 1);
        assert_close(q[0], crank, 1e-11);
        assert_close(q[4], rocker, 1e-11);
        for (int j = 0; j < 5; ++j) assert_close(q[j], s.q[j], k == 0 ? 1e-10 : 1e-5);
        assert_less(test_largest(5, u), 1e-9);
        /* loop forces of the same program */
        assert_close(fabs(yp[15]), 0.638490546, k == 0 ? 1e-7 : 1e-3);
        assert_close(fabs(yp[16]), 0.354518066, k == 0 ? 1e-7 : 1e-3);
    }
    loops_free(&s);
}

/* Away from rest: rates of the rods against starts from where crank and rocker come from and go to.
 */
static void rates(void **state)
{
    (void)state;
    loops s;
    knees(&s);
    double q[5], u[5] = {1.5, 0.0, 0.0, 0.0, -0.8}, yp[64], there[2][5];
    memcpy(q, s.q, sizeof q);
    start(&s, q, u, yp);
    assert_close(u[0], 1.5, 1e-9);
    assert_close(u[4], -0.8, 1e-9);
    const double *udot = yp + 10, h = 1e-3;
    for (int side = 0; side < 2; ++side) {
        const double dt = side ? h : -h;
        double rest[5] = {0.0}, ignored[64];
        for (int k = 0; k < 5; ++k) there[side][k] = q[k] + dt * u[k] + 0.5 * dt * dt * udot[k];
        const double crank = there[side][0], rocker = there[side][4];
        start(&s, there[side], rest, ignored);
        /* the loop is closed by all joints: to second order they were where they should be */
        assert_close(there[side][0], crank, 1e-7);
        assert_close(there[side][4], rocker, 1e-7);
    }
    for (int k = 0; k < 5; ++k) {
        const double rate = (there[1][k] - there[0][k]) / (2.0 * h),
                     bend = (there[1][k] - 2.0 * q[k] + there[0][k]) / (h * h);
        assert_close(u[k], rate, 1e-4 * (1.0 + fabs(rate)));
        assert_close(udot[k], bend, 1e-3 * (1.0 + fabs(bend)));
    }
    loops_free(&s);
}

/* From rest, to shortly before the rods are stretched at t = 0.3533 s. */
static void runs(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    long steps = 0;
    for (int k = 0; k < 3; ++k) {
        loops s;
        knees(&s);
        const loops_result r = loops_run(&s, tolerance[k], 0.3);
        assert_int_equal(r.status, MBSR_OK);
        assert_close(s.q[0], -0.1064728, 300.0 * tolerance[k]);
        steps += r.steps;
        loops_free(&s);
    }
    assert_true(20 * steps <= 21 * (138 + 345 + 712)); /* of the other program, to 5 percent */
}

/* At t = 0.3533 s the rods are stretched: no motion goes on from there, and the text says why. */
static void an_impact(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};
    for (int k = 0; k < 6; ++k) {
        loops s;
        mbsr_error error;
        knees(&s);
        const loops_result r = loops_try(&s, tolerance[k], 0.5, &error);
        assert_int_equal(r.status, MBSR_LOOP_SINGULAR);
        assert_contains(error.text, "closure 0 'rod-rocker'|stretched|impact");
        loops_free(&s);
    }
}

/* No spring at all: refused by the name of a joint. */
static void nothing_holds_them(void **state)
{
    (void)state;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "rod 1", a, 1.0, 0.0, 0.0, 1.0);
    const int c = loops_rod(&s, "rod 2", b, 1.0, 0.0, 0.0, 1.0);
    const int e = loops_rod(&s, "rod 3", c, 1.0, 0.0, 0.0, 1.0);
    const int f = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 1.0);
    loops_pin(&s, "rod-rocker", e, 1.0, 0.0, f, 1.0, 0.0);
    loops_finish(&s);
    double y[64], yp[64];
    const double q[5] = {1.6, -0.8, -0.8, -1.2, 1.4};
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, s.u, y), NULL);
    const int status = mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    assert_int_equal(status, MBSR_UNDETERMINED);
    assert_contains(mbsr_data_error(s.d)->text, "rod|moves no mass|neither a damper nor a spring");
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(positions), cmocka_unit_test(rates),
                                       cmocka_unit_test(runs), cmocka_unit_test(an_impact),
                                       cmocka_unit_test(nothing_holds_them)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
