/* Starts of models with many loops, on the tree, against those of one loop and against the dense
 * equations of forward dynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "loops.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

enum { COUNT = 40 };

/* A pin that is a spring, as a closure. */
static void bushing(loops *s, int a, double xa, int b, double xb, double stiffness)
{
    const double k = stiffness, d = 1e-4 * stiffness, K[9] = {k, 0, 0, 0, k, 0, 0, 0, 0},
                 D[9] = {d, 0, 0, 0, d, 0, 0, 0, 0};
    mbsr_force_def pin = mbsr_force_planar_bushing(a, (mbsr_planar_frame){xa, 0.0, 0.0}, b,
                                                   (mbsr_planar_frame){xb, 0.0, 0.0}, K, D);
    pin.as_closure = MBSR_SPRING_SETTLED;
    assert_ok(mbsr_model_add_force(s->m, &pin, NULL), mbsr_model_error(s->m));
}

/* Four-bars on the ground, or each on a spine that hangs on the one before. With a tail, massless
 * and on a damper, the coupler has no mass either. stiffness: of the pins, N/m; 0: rigid. */
static void make(loops *s, int count, int hub, int tail, double stiffness)
{
    int last = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 0; k < count; ++k) {
        const int spine = hub ? MBSR_GROUND : loops_rod(s, NULL, last, 0.5, 0.0, 1.5, 0.5);
        const int a = loops_rod(s, NULL, spine, 0.0, 0.1, 0.4, 0.3),
                  b = loops_rod(s, NULL, a, 0.3, 0.0, tail ? 0.0 : 0.6, 0.5),
                  c = loops_rod(s, NULL, spine, 0.45, 0.1, 0.3, 0.35);
        if (stiffness > 0.0)
            bushing(s, b, 0.5, c, 0.35, stiffness);
        else
            loops_pin(s, NULL, b, 0.5, 0.0, c, 0.35, 0.0);
        if (tail) {
            const int d = loops_rod(s, NULL, c, 0.35, 0.0, 0.0, 0.2);
            const mbsr_force_def damper = mbsr_force_joint_spring(d, 0, 3.0, 0.2, 0.4);
            assert_ok(mbsr_model_add_force(s->m, &damper, NULL), mbsr_model_error(s->m));
        }
        last = spine;
    }
    loops_build(s);
}

/* A consistent state from joint angles that repeat after `period` bodies. */
static void start(loops *s, int period, const double *q, const double *u, double *y, double *yp)
{
    double *all = calloc(2 * (size_t)s->nq, sizeof *all), *rates = all + s->nq;
    for (int k = 0; k < s->nq; ++k) all[k] = q[k % period], rates[k] = u[k % period];
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, all, rates, y), NULL);
    assert_ok(mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(s->d));
    free(all);
}

/* Number k of part `part` (q, p, u, Lambda, Eta). */
static double entry(const loops *s, const double *y, int part, int k)
{
    const int first[] = {0, s->nq, s->nq + s->nu, s->nq + 2 * s->nu, s->nq + 2 * s->nu + s->rows};
    return y[first[part] + k];
}

/* Closed angles of one four-bar. */
static void closed_angles(double q[4])
{
    static const double guess[] = {1.3, -1.1, 1.4};
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.1, 0.4, 0.3),
              b = loops_rod(&s, NULL, a, 0.3, 0.0, 0.6, 0.5),
              c = loops_rod(&s, NULL, MBSR_GROUND, 0.45, 0.1, 0.3, 0.35);
    loops_pin(&s, NULL, b, 0.5, 0.0, c, 0.35, 0.0);
    loops_finish(&s);
    memcpy(s.q, guess, sizeof guess);
    loops_close(&s, 0.0);
    memcpy(q, s.q, 3 * sizeof *q);
    q[3] = 0.7;
    loops_free(&s);
}

/* Loops that have nothing to do with each other start as one of them does. */
static void as_one_loop(void **state)
{
    (void)state;
    static const double u[] = {1.0, -0.5, 0.3, 0.2};
    double q[4];
    closed_angles(q);
    for (int tail = 0; tail < 2; ++tail) {
        loops many, one;
        make(&many, COUNT, 1, tail, 0.0);
        make(&one, 1, 1, tail, 0.0);
        const int period = one.nu;
        double *y = calloc(2 * (size_t)(many.size + one.size), sizeof *y), *yp = y + many.size,
               *x = yp + many.size, *xp = x + one.size;
        start(&many, period, q, u, y, yp);
        start(&one, period, q, u, x, xp);
        for (int part = 0; part < 5; ++part) {
            const int length = part < 3 ? one.nu : one.rows;
            for (int k = 0; k < length * COUNT; ++k) {
                assert_close(entry(&many, y, part, k), entry(&one, x, part, k % length), 1e-9);
                const double size = 1.0 + fabs(entry(&one, xp, part, k % length));
                assert_close(entry(&many, yp, part, k), entry(&one, xp, part, k % length),
                             1e-9 * size);
            }
        }
        free(y);
        loops_free(&many);
        loops_free(&one);
    }
}

/* Accelerations and loop forces are those of the dense equations, loops are closed from a guess
 * that is not. */
static void as_dense(void **state)
{
    (void)state;
    static const double u[] = {0.3, 1.0, -0.5, 0.3}, off[] = {0.0, 0.03, -0.02, 0.05};
    double q[5], guess[4];
    closed_angles(q);
    for (int k = 0; k < 4; ++k) guess[k] = (k > 0 ? q[k - 1] : 0.1) + off[k];
    loops s;
    make(&s, COUNT, 0, 0, 0.0);
    double *y = calloc(4 * (size_t)s.size, sizeof *y), *yp = y + s.size, *F = yp + s.size,
           *udot = F + s.size;
    start(&s, 4, guess, u, y, yp);
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), NULL);
    assert_less(test_largest(s.size, F), 1e-9);
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, y, y + s.nq + s.nu, NULL, udot),
              mbsr_data_error(s.d));
    const double size = test_largest(s.nu, udot);
    for (int k = 0; k < s.nu; ++k) assert_close(yp[s.nq + s.nu + k], udot[k], 1e-9 * size);
    assert_ok(mbsr_closures_lambda(s.m, s.d, F), NULL);
    for (int k = 0; k < s.rows; ++k)
        assert_close(yp[s.nq + 2 * s.nu + k], F[k], 1e-9 * (1.0 + test_largest(s.rows, F)));
    free(y);
    loops_free(&s);
}

/* The springs of a start bear what the motion asks of them: their forces s are lambda with
 * velocities that stretch none, and the gaps are s / k. */
static void springs_bear(loops *s, const double *y, const double *yp)
{
    double *g = calloc((size_t)(s->position_rows + s->rows), sizeof *g),
           *rate = g + s->position_rows;
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, y), NULL);
    assert_ok(mbsr_closures_gap(s->m, s->d, g), NULL);
    assert_ok(mbsr_stage_velocities(s->m, s->d, y + s->nq + s->nu), NULL);
    assert_ok(mbsr_closures_rate(s->m, s->d, rate), NULL);
    double largest = 0.0;
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, held_row, held;
        assert_ok(mbsr_closure_indices(s->m, c, &row, NULL, &held_row, &held), NULL);
        for (int k = 0; k < held; ++k) {
            const double stiffness = mbsr_closure_stiffness(s->m, c, k),
                         force = entry(s, y, 3, row + k);
            largest = fmax(largest, fabs(force));
            assert_true(stiffness > 0.0);
            assert_close(force, stiffness * g[held_row + k], 1e-12 * stiffness);
            assert_close(entry(s, yp, 3, row + k), 0.0, 1e-9);
            assert_close(rate[row + k], 0.0, 1e-8); /* of bodies as fast as 100 m/s */
        }
    }
    assert_true(largest > 0.1);
    free(g);
}

/* Springs in place of pins: accelerations are those of the dense equations with the springs as
 * forces. */
static void springs_as_dense(void **state)
{
    (void)state;
    static const double u[] = {0.3, 1.0, -0.5, 0.3}, stiffness[] = {1e4, 1e6, 1e8};
    double q[5];
    closed_angles(q + 1);
    q[0] = 0.1;
    for (int turn = 0; turn < 3; ++turn) {
        loops s;
        make(&s, COUNT, 0, 0, stiffness[turn]);
        double *y = calloc(4 * (size_t)s.size, sizeof *y), *yp = y + s.size, *F = yp + s.size,
               *udot = F + s.size;
        start(&s, 4, q, u, y, yp);
        springs_bear(&s, y, yp);
        assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, y, y + s.nq + s.nu, NULL, udot),
                  mbsr_data_error(s.d));
        /* gaps are known to 1e-15 m or so */
        const double lost = 1e-8 + 1e-15 * stiffness[turn], size = test_largest(s.nu, udot);
        for (int k = 0; k < s.nu; ++k)
            assert_close(yp[s.nq + s.nu + k], udot[k], 100.0 * lost * size);
        free(y);
        loops_free(&s);
    }
}

/* Bodies by the thousand, for which a dense start would take hours. */
static void many_bodies(void **state)
{
    (void)state;
    static const double u[] = {0.0, 1.0, -0.5, 0.3, 0.2};
    double q[5];
    closed_angles(q + 1);
    q[0] = 0.0;
    for (int tail = 0; tail < 4; ++tail) { /* with massless couplers, and stiff pins, too */
        loops s;
        make(&s, test_long() ? 500 : test_seeds_short(100, 250), 0, tail % 2, tail > 1 ? 1e8 : 0.0);
        double *y = calloc(3 * (size_t)s.size, sizeof *y), *yp = y + s.size, *F = yp + s.size;
        start(&s, 4 + tail % 2, q, u, y, yp);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), NULL);
        assert_less(test_largest(s.size, F), 1e-7 * (1.0 + test_largest(s.size, yp)));
        if (tail > 1) springs_bear(&s, y, yp);
        free(y);
        loops_free(&s);
    }
}

/* Parallelograms with three legs each, on a spine: one row of four is redundant. */
static void make_legs(loops *s, int count)
{
    int last = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 0; k < count; ++k) {
        const int spine = loops_rod(s, NULL, last, 0.5, 0.0, 1.5, 0.5),
                  a = loops_rod(s, NULL, spine, 0.0, 0.1, 0.4, 0.3),
                  b = loops_rod(s, NULL, a, 0.3, 0.0, 0.6, 0.4),
                  c = loops_rod(s, NULL, spine, 0.2, 0.1, 0.3, 0.3),
                  d = loops_rod(s, NULL, spine, 0.4, 0.1, 0.3, 0.3);
        loops_pin(s, NULL, b, 0.2, 0.0, c, 0.3, 0.0);
        loops_pin(s, NULL, b, 0.4, 0.0, d, 0.3, 0.0);
        last = spine;
    }
    loops_build(s);
}

/* From guesses that are open by some centimetres: rows that are redundant are found, one a
 * mechanism, the rates are those of the dense equations, and thousands of bodies start. */
static void redundant_rows(void **state)
{
    (void)state;
    static const double legs[5] = {0.1, 1.2, -1.2, 1.2, 1.2};
    static const int counts[] = {COUNT, COUNT, 400};
    for (int turn = 0; turn < 3; ++turn) {
        const int count = counts[turn];
        const double off = turn == 0 ? 0.0 : 0.03;
        loops s;
        make_legs(&s, count);
        double *y = calloc(4 * (size_t)s.size, sizeof *y), *yp = y + s.size, *F = yp + s.size,
               *q = F + s.size, *u = q + s.nq;
        int *dropped = calloc((size_t)s.rows, sizeof *dropped);
        for (int k = 0; k < s.nq; ++k) q[k] = legs[k % 5] + off * sin(7.0 * k), u[k] = 0.3 * cos(k);
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(s.d));
        assert_ok(mbsr_closures_redundant(s.m, s.d, dropped), NULL);
        for (int k = 0; k < count; ++k) {
            int left_out = 0;
            for (int l = 0; l < 4; ++l) left_out += dropped[4 * k + l];
            assert_int_equal(left_out, 1);
        }
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), NULL);
        assert_less(test_largest(s.size, F), 1e-11 * (1.0 + test_largest(s.size, yp)));
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, y), NULL);
        assert_ok(mbsr_closures_gap(s.m, s.d, F), NULL);
        assert_less(test_largest(s.position_rows, F), 1e-9);
        if (count == COUNT) {
            assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, y, y + s.nq + s.nu, NULL, F),
                      mbsr_data_error(s.d));
            const double size = test_largest(s.nu, F);
            for (int k = 0; k < s.nu; ++k) assert_close(yp[s.nq + s.nu + k], F[k], 1e-7 * size);
        }
        free(dropped);
        free(y);
        loops_free(&s);
    }
}

/* In 2000 bodies a leg at each end of the row stands where it is told to, and turns so. */
static void rates_that_are_kept(void **state)
{
    (void)state;
    static const double legs[5] = {0.1, 1.2, -1.2, 1.2, 1.2};
    enum { MANY = 400, FIRST = 1, LAST = 5 * MANY - 1 };
    loops s;
    make_legs(&s, MANY);
    double *y = calloc(3 * (size_t)s.size, sizeof *y), *yp = y + s.size, *q = yp + s.size,
           *u = q + s.nq;
    int *keep = calloc((size_t)s.nu, sizeof *keep);
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    mbsr_consistent_info info;
    opt.keep_position = opt.keep_rate = keep;
    keep[FIRST] = keep[LAST] = 1;
    for (int k = 0; k < s.nq; ++k) q[k] = legs[k % 5] + 0.01 * sin(7.0 * k), u[k] = 0.3 * cos(k);
    u[LAST] = 5.0;
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
    assert_ok(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, &info),
              mbsr_data_error(s.d));
    for (int k = FIRST; k <= LAST; k += LAST - FIRST)
        assert_true(y[k] == q[k] && y[s.nq + s.nu + k] == u[k]);
    /* the legs of one parallelogram turn alike */
    assert_close(y[s.nq + s.nu + LAST - 1], 5.0, 1e-9);
    assert_close(y[s.nq + s.nu + LAST - 3], 5.0, 1e-9);
    keep[LAST - 1] = 1; /* and cannot be told otherwise */
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
    opt.keep_position = NULL;
    assert_int_equal(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, NULL),
                     MBSR_LOOP_OPEN);
    assert_contains(mbsr_data_error(s.d)->text, "cannot keep|closure");
    free(keep);
    free(y);
    loops_free(&s);
}

/* Gears between a rod and the next one, which hangs on it, listed twice: what reads the joint of
 * the body where it meets is found redundant, loop by loop as densely. */
static void gears(void **state)
{
    (void)state;
    static const int counts[] = {10, 80};
    for (int n = 0; n < 2; ++n) {
        const int count = counts[n], coordinate[2] = {0, 0};
        loops s;
        loops_begin(&s, NULL);
        for (int k = 0; k < count; ++k) {
            const int a = loops_rod(&s, NULL, MBSR_GROUND, 0.1 * k, 0.0, 1.0, 1.0),
                      b = loops_rod(&s, NULL, a, 1.0, 0.0, 0.5, 0.5), pair[2] = {a, b};
            const mbsr_closure_def gear =
                mbsr_closure_coupling(2, pair, coordinate, (double[2]){1.0, -0.4 - 0.01 * k}, 0.0);
            for (int l = 0; l < 2; ++l)
                assert_ok(mbsr_model_add_closure(s.m, &gear, NULL), mbsr_model_error(s.m));
        }
        loops_build(&s);
        int *redundant = calloc((size_t)s.rows, sizeof *redundant);
        double *y = calloc(2 * (size_t)s.size, sizeof *y);
        const double q[2] = {0.3, 0.2}, u[2] = {1.0, 0.0};
        start(&s, 2, q, u, y, y + s.size);
        assert_ok(mbsr_closures_redundant(s.m, s.d, redundant), NULL);
        for (int k = 0; k < count; ++k) {
            const double ratio = 0.4 + 0.01 * k;
            assert_int_equal(redundant[2 * k], 0);
            assert_int_equal(redundant[2 * k + 1], 1);
            assert_close(entry(&s, y, 0, 2 * k), ratio * entry(&s, y, 0, 2 * k + 1), 1e-11);
            assert_close(entry(&s, y, 2, 2 * k), ratio * entry(&s, y, 2, 2 * k + 1), 1e-9);
        }
        free(redundant);
        free(y);
        loops_free(&s);
    }
}

/* Springs that are taken as they are, off their lengths, in a row of so many that no dense start
 * has the memory: the state stays, F is zero, and accelerations are those of forward dynamics. */
static void loose_springs(void **state)
{
    (void)state;
    enum { SPRINGS = 3000 };
    loops s;
    int last = MBSR_GROUND;
    loops_begin(&s, NULL);
    for (int k = 0; k < SPRINGS; ++k) {
        const int a = loops_rod(&s, NULL, last, k > 0 ? 0.5 : 0.0, 0.0, 1.0, 0.5),
                  b = loops_rod(&s, NULL, a, 0.5, 0.0, 0.5, 0.5);
        const double *K = (double[9]){2e4, 0, 0, 0, 1e4, 0, 0, 0, 0},
                     *D = (double[9]){30, 0, 0, 0, 10, 0, 0, 0, 0};
        mbsr_force_def band = mbsr_force_planar_bushing(last, (mbsr_planar_frame){0.6, 0.4, 0.0}, b,
                                                        (mbsr_planar_frame){0.4, 0.3, 0.0}, K, D);
        band.as_closure = MBSR_SPRING_LOOSE;
        assert_ok(mbsr_model_add_force(s.m, &band, NULL), mbsr_model_error(s.m));
        last = k % 10 == 9 ? MBSR_GROUND : a;
    }
    loops_build(&s);
    double *y = calloc(3 * (size_t)s.size + (size_t)s.nu, sizeof *y), *yp = y + s.size,
           *F = yp + s.size, *udot = F + s.size;
    const double q[2] = {0.3, 0.2}, u[2] = {0.1, -0.2};
    start(&s, 2, q, u, y, yp);
    for (int k = 0; k < s.nu; ++k) {
        assert_close(entry(&s, y, 0, k), q[k % 2], 0.0);
        assert_close(entry(&s, y, 2, k), u[k % 2], 0.0);
    }
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(s.d));
    assert_less(test_largest(s.size, F), 1e-9 * test_largest(s.size, yp));
    assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, y, y + s.nq + s.nu, NULL, udot),
              mbsr_data_error(s.d));
    const double size = test_largest(s.nu, udot);
    for (int k = 0; k < s.nu; ++k) assert_close(entry(&s, yp, 2, k), udot[k], 1e-10 * size);
    free(y);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_one_loop),    cmocka_unit_test(as_dense),
        cmocka_unit_test(many_bodies),    cmocka_unit_test(springs_as_dense),
        cmocka_unit_test(redundant_rows), cmocka_unit_test(gears),
        cmocka_unit_test(loose_springs),  cmocka_unit_test(rates_that_are_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
