/* Mechanisms with closed loops, integrated by the driver, against digits that two formulations
 * agree on.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"
#include "squeezer.h"

#include <mbsrank/driver.h>

#include <stdio.h>

static const double tolerance[] = {1e-4, 1e-6, 1e-8};

static int slider(loops *s, int parent, double x, double mass, double dir)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "slider";
    body.parent = parent;
    body.joint = mbsr_joint_planar_prismatic((mbsr_planar_frame){x, 0.0, dir},
                                             (mbsr_planar_frame){0.0, 0.0, 0.0});
    if (mass > 0.0) body.inertia = mbsr_inertia_planar(mass, (double[2]){0.0, 0.0}, 0.0);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

static void slider_crank(loops *s, double rod)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 0.5);
    const int b = loops_rod(s, "rod", a, 0.5, 0.0, rod, 1.5);
    const int c = slider(s, MBSR_GROUND, 0.0, 1.0, 0.0);
    loops_pin(s, "rod-slider", b, 1.5, 0.0, c, 0.0, 0.0);
    loops_finish(s);
    s->q[0] = 1.0088884035180354, s->q[1] = -1.2948499033205734, s->q[2] = 1.7054871783473489;
    s->u[0] = 8.0;
}

static void a_slider_crank(void **state)
{
    (void)state;
    static const double q[3] = {7.8016817714, -8.1410352995, 1.4405930997};
    long steps = 0;
    for (int k = 0; k < 3; ++k) {
        loops s;
        slider_crank(&s, 0.0);
        const loops_result r = loops_run(&s, tolerance[k], 2.0);
        assert_int_equal(r.status, MBSR_OK);
        steps += r.steps;
        for (int j = 0; j < 3; ++j) assert_close(s.q[j], q[j], 300.0 * tolerance[k]);
        loops_free(&s);
    }
    assert_true(steps <= 139 + 272 + 626); /* of the same form, written by hand */
}

static void andrews(loops *s)
{
    mbsr_model_def def = mbsr_default_model_def();
    memset(s, 0, sizeof *s);
    assert_ok(mbsr_model_create(&def, &s->m, NULL), NULL);
    squeezer_add(s->m);
    loops_finish(s);
    memcpy(s->q, squeezer_start, sizeof squeezer_start);
}

/* Against the digits of the Test Set for IVP Solvers at 0.03 s. */
static void andrews_squeezer(void **state)
{
    (void)state;
    static const double tight[] = {1e-6, 1e-8, 1e-10},
                        lambda[] = {-199.175, 29.755, -23.0665, -31.4527};
    for (int k = 0; k < 3; ++k) {
        loops s;
        andrews(&s);
        const loops_result r = loops_run(&s, tight[k], 0.03);
        assert_int_equal(r.status, MBSR_OK);
        assert_less(r.gap, tight[k]);
        for (int j = 0; j < 7; ++j)
            assert_close(s.q[j], squeezer_end[j], k == 2 ? 1e-7 : 1e3 * tight[k]);
        for (int j = 0; j < 4 && k == 2; ++j) assert_close(s.lambda[j], lambda[j], 1e-3);
        loops_free(&s);
    }
}

/* N windows, all links 1 m and 1 kg, upright; singular when they lie. */
static void n_four_bar(loops *s, int N)
{
    int up[17], coupler[16];
    loops_begin(s, NULL);
    for (int i = 0; i <= N; ++i) {
        up[i] = loops_rod(s, "upright", MBSR_GROUND, i, 0.0, 1.0, 1.0);
        if (i < N) coupler[i] = loops_rod(s, "coupler", up[i], 1.0, 0.0, 1.0, 1.0);
    }
    for (int i = 0; i < N; ++i) {
        char name[32];
        snprintf(name, sizeof name, "pin %d", i);
        loops_pin(s, name, coupler[i], 1.0, 0.0, up[i + 1], 1.0, 0.0);
    }
    loops_finish(s);
    for (int i = 0; i <= N; ++i) {
        s->q[up[i]] = acos(-1.0) / 2.0;
        s->u[up[i]] = -1.0;
        if (i == N) break;
        s->q[coupler[i]] = -acos(-1.0) / 2.0;
        s->u[coupler[i]] = 1.0;
    }
}

/* theta'' of N windows, or of a ladder with a beam of N kg on N + 1 legs: one freedom. */
static double fall(int N, double theta, double omega, double t_end)
{
    const double factor = -9.81 * (0.5 * (N + 1) + N) / ((N + 1) / 3.0 + N), h = 1e-4;
    const int steps = (int)lround(t_end / h);
    for (int k = 0; k < steps; ++k) {
        const double a = factor * cos(theta), b = factor * cos(theta + 0.5 * h * omega),
                     c = factor * cos(theta + 0.5 * h * omega + 0.25 * h * h * a),
                     d = factor * cos(theta + h * omega + 0.5 * h * h * b);
        theta += h * omega + h * h / 6.0 * (a + b + c);
        omega += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    return theta;
}

/* Through ten singular positions each: right, or ended with a name; and mostly right. */
static void windows(void **state)
{
    (void)state;
    static const int N[] = {1, 2, 4, 8};
    int finished = 0;
    assert_close(fall(2, acos(-1.0) / 2.0, -1.0, 10.0), -30.1798008602, 1e-8);
    for (int n = 0; n < 4; ++n) {
        const double theta = fall(N[n], acos(-1.0) / 2.0, -1.0, 10.0);
        for (int k = 0; k < (n == 3 ? 2 : 3); ++k) {
            loops s;
            n_four_bar(&s, N[n]);
            const loops_result r = loops_run(&s, tolerance[k], 10.0);
            if (r.status) assert_int_equal(r.status, MBSR_LOOP_SINGULAR);
            if (!r.status) assert_close(s.q[0], theta, 1e4 * tolerance[k]);
            finished += !r.status;
            loops_free(&s);
        }
    }
    assert_true(finished >= 8);
}

static void ladder(loops *s, int N)
{
    loops_begin(s, NULL);
    const int first = loops_rod(s, "leg 0", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int beam = loops_rod(s, "beam", first, 1.0, 0.0, N, N);
    for (int i = 1; i <= N; ++i) {
        char name[32];
        snprintf(name, sizeof name, "leg %d", i);
        const int leg = loops_rod(s, name, MBSR_GROUND, i, 0.0, 1.0, 1.0);
        loops_pin(s, name, beam, i, 0.0, leg, 1.0, 0.0);
    }
    loops_finish(s);
    for (int k = 0; k < s->nq; ++k) {
        s->q[k] = k == beam ? -2.0 : 2.0;
        s->u[k] = k == beam ? -1.0 : 1.0;
    }
}

/* All redundant rows are named, those of legs 2 and further: one each. */
static void ladders(void **state)
{
    (void)state;
    assert_close(fall(2, 2.0, 1.0, 5.0), 6.8651128809, 1e-8);
    for (int N = 2; N <= 8; N *= 2) {
        const double theta = fall(N, 2.0, 1.0, 5.0);
        for (int k = 0; k < (N == 8 ? 2 : 3); ++k) {
            loops s;
            ladder(&s, N);
            mbsr_closure_report report;
            int redundant[LOOPS_MOST], dropped[LOOPS_MOST];
            assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
                      mbsr_data_error(s.d));
            assert_int_equal(report.rows, 2 * N);
            assert_int_equal(report.independent, N + 1);
            assert_int_equal(report.nearby, N + 1);
            assert_int_equal(report.mobility, 1);
            for (int j = 0; j < N; ++j)
                assert_int_equal(redundant[2 * j] + redundant[2 * j + 1], j > 0);
            const loops_result r = loops_run(&s, tolerance[k], 5.0);
            assert_int_equal(r.status, MBSR_OK);
            assert_close(s.q[0], theta, 5e3 * tolerance[k]);
            assert_ok(mbsr_closures_redundant(s.m, s.d, dropped), NULL);
            assert_memory_equal(dropped, redundant, (size_t)s.rows * sizeof *dropped);
            loops_free(&s);
        }
    }
}

/* A slider-crank with its pin as a closure of that stiffness, 0: rigid. */
static void pinned(loops *s, double stiffness)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 2.0, 0.2);
    const int b = loops_rod(s, "rod", a, 0.2, 0.0, 1.0, 0.6);
    const int c = slider(s, MBSR_GROUND, 0.0, 1.5, 0.0);
    mbsr_closure_def pin = mbsr_closure_ball(b, (double[3]){0.6, 0.0, 0.0}, c, NULL);
    for (int j = 0; j < 2; ++j) {
        pin.stiffness[j] = stiffness;
        pin.damping[j] = 1e-4 * stiffness;
    }
    assert_ok(mbsr_model_add_closure(s->m, &pin, NULL), NULL);
    loops_finish(s);
    s->q[0] = 1.0;
    s->q[1] = -1.0 - asin(0.2 * sin(1.0) / 0.6);
    s->q[2] = 0.2 * cos(1.0) + 0.6 * cos(asin(0.2 * sin(1.0) / 0.6));
}

/* A spring of any stiffness costs what the rigid pin costs. */
static void stiff_pins(void **state)
{
    (void)state;
    static const double stiffness[] = {0.0, 1e14, 1e12, 1e10, 1e8};
    long rigid = 0;
    for (int i = 0; i < 5; ++i) {
        long steps = 0;
        for (int k = 0; k < 3; ++k) {
            loops s;
            pinned(&s, stiffness[i]);
            const loops_result r = loops_run(&s, tolerance[k], 3.0);
            assert_int_equal(r.status, MBSR_OK);
            assert_close(s.q[0], -1.590417, k > 0 ? 1e4 * tolerance[k] : 0.5);
            steps += r.steps;
            loops_free(&s);
        }
        if (i == 0) rigid = steps;
        assert_true(4 * steps <= 5 * rigid);
    }
}

/* The same with soft springs: right against a tight run, and no gain of energy. */
static void soft_pins(void **state)
{
    (void)state;
    static const double stiffness[] = {1e4, 1e6};
    for (int i = 0; i < 2; ++i) {
        double truth = 0.0;
        for (int k = 2; k >= 1; --k) {
            double before[2], after[2];
            loops s;
            pinned(&s, stiffness[i]);
            assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), NULL);
            assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
            assert_ok(mbsr_energy(s.m, s.d, before, before + 1), mbsr_data_error(s.d));
            const loops_result r = loops_run(&s, tolerance[k], 1.0);
            assert_int_equal(r.status, MBSR_OK);
            assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
            assert_ok(mbsr_energy(s.m, s.d, after, after + 1), mbsr_data_error(s.d));
            assert_less(after[0] + after[1], before[0] + before[1] + 1e-2);
            if (k == 2) truth = s.q[0];
            assert_close(s.q[0], truth, 1e-3);
            loops_free(&s);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slider_crank), cmocka_unit_test(andrews_squeezer),
        cmocka_unit_test(windows),        cmocka_unit_test(ladders),
        cmocka_unit_test(stiff_pins),     cmocka_unit_test(soft_pins)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
