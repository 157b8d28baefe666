/* Closures as they should not be: what contradicts itself is refused by the name of a closure, what
 * is redundant runs.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "loops.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>

enum { CRANK, COUPLER, ARM, ROCKER };

static const double one[3] = {1.0, 0.0, 0.0}, end[3] = {2.0, 0.0, 0.0};

/* Crank, coupler and arm one behind the other, the rocker 2 m away; `massless`: the coupler. */
static void begin(loops *s, bool massless)
{
    loops_begin(s, NULL);
    loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    loops_rod(s, "coupler", CRANK, 1.0, 0.0, massless ? 0.0 : 1.0, 1.0);
    loops_rod(s, "arm", COUPLER, 1.0, 0.0, 1.0, 1.0);
    loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 1.0, 1.0);
}

static void add(loops *s, mbsr_closure_def def, const char *name)
{
    def.name = name;
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* The start from a state that is not closed: its status, with `words` in the text. */
static void start(loops *s, int status, const char *words)
{
    double y[64], yp[64];
    mbsr_index_report *report;
    loops_finish(s);
    for (int k = 0; k < 4; ++k) s->q[k] = 0.3 + 0.1 * k;
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), NULL);
    const int found = mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    assert_int_equal(found, status);
    if (words) assert_contains(mbsr_data_error(s->d)->text, words);
    if (!found) {
        for (int k = 0; k < s->size; ++k) assert_true(isfinite(y[k]) && isfinite(yp[k]));
        assert_ok(mbsr_dae_unpack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, s->q, s->u), NULL);
        assert_ok(mbsr_index_report_create(s->m, s->d, 0.0, s->q, s->u, &report),
                  mbsr_data_error(s->d));
        assert_int_equal(report->undetermined, 0);
        mbsr_index_report_destroy(s->m, report);
    }
    loops_free(s);
}

/* A number of closures between the bodies, and what comes of them. */
static void contradictions(void **state)
{
    (void)state;
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        begin(&s, massless);
        for (int k = 0; k < 3; ++k)
            add(&s, mbsr_closure_weld(ARM - k, NULL, ROCKER, NULL), k < 2 ? "one" : "last");
        start(&s, MBSR_LOOP_OPEN, "closure 2 'last' (weld of body 0 and body 3) stays open by 2");
        begin(&s, massless);
        add(&s, mbsr_closure_ball(CRANK, one, COUPLER, one), "never");
        start(&s, MBSR_LOOP_OPEN, "closure 0 'never' (ball of body 0 and body 1) stays open");
        begin(&s, massless);
        add(&s, mbsr_closure_weld(ROCKER, NULL, MBSR_GROUND, NULL), "elsewhere");
        start(&s, MBSR_LOOP_OPEN, "'elsewhere' (weld of body 3 and the ground) stays open by 2");
        begin(&s, massless);
        add(&s, mbsr_closure_distance(CRANK, NULL, ROCKER, NULL, 2.5), "strut");
        start(&s, MBSR_LOOP_OPEN, "'strut' (distance of body 0 and body 3) stays open by 0.45");
        begin(&s, massless);
        add(&s, mbsr_closure_distance(CRANK, one, COUPLER, NULL, 1.0), "point");
        start(&s, MBSR_LOOP_OPEN, "'point' (distance of body 0 and body 1) stays open by 0.5");
        begin(&s, massless);
        add(&s, mbsr_closure_ball(ARM, one, ROCKER, one), "pin");
        add(&s, mbsr_closure_distance(ARM, one, ROCKER, one, 1.0), "apart");
        start(&s, MBSR_LOOP_OPEN, "stays open by 0.5");
        begin(&s, massless);
        add(&s, mbsr_closure_ball(ARM, end, ROCKER, one), "far");
        add(&s, mbsr_closure_coupling(1, (int[1]){CRANK}, (int[1]){0}, one, 3.0), "stop");
        add(&s, mbsr_closure_coupling(1, (int[1]){CRANK}, (int[1]){0}, one, 2.0), "other stop");
        start(&s, MBSR_LOOP_OPEN, "stop|stays open by 0.5");
    }
}

static void redundancies(void **state)
{
    (void)state;
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        begin(&s, massless);
        for (int k = 0; k < 3; ++k) add(&s, mbsr_closure_ball(ARM, one, ROCKER, one), "pin");
        start(&s, MBSR_OK, NULL);
        begin(&s, massless);
        add(&s, mbsr_closure_ball(CRANK, one, COUPLER, NULL), "as the joint");
        start(&s, MBSR_OK, NULL);
        begin(&s, massless);
        add(&s, mbsr_closure_distance(CRANK, NULL, ROCKER, NULL, 2.0), "ground");
        start(&s, MBSR_OK, NULL);
        begin(&s, massless);
        for (int k = 0; k < 4; ++k)
            add(&s, mbsr_closure_coupling(1, (int[1]){k}, (int[1]){0}, one, 0.2), "held");
        add(&s,
            mbsr_closure_coupling(2, (int[2]){0, 3}, (int[2]){0, 0}, (double[2]){1.0, -1.0}, 0.0),
            "same");
        start(&s, MBSR_OK, NULL);
    }
}

/* What is asked of closures of a tree that has none: motors take all, or a joint is named. */
static void no_closures(void **state)
{
    (void)state;
    loops s;
    double q[4] = {0.3, 0.4, 0.5, 0.6}, u[4] = {0.1, 0.2, 0.3, 0.4}, need[4], tau[4],
           none[1] = {0.0};
    const int all[4] = {CRANK, COUPLER, ARM, ROCKER};
    int idle[1] = {0};
    mbsr_closure_report report;
    begin(&s, false);
    loops_finish(&s);
    const mbsr_error *error = mbsr_data_error(s.d);
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, q, u, u, NULL, need), error);
    assert_ok(loops_inverse_dynamics(s.m, s.d, 0.0, q, u, u, 4, all, tau, none), error);
    for (int k = 0; k < 4; ++k) assert_close(tau[k], need[k], 1e-12 * test_largest(4, need));
    assert_int_equal(loops_inverse_dynamics(s.m, s.d, 0.0, q, u, u, 3, all, tau, none),
                     MBSR_UNDETERMINED);
    assert_contains(error->text, "u0 of body 3 'rocker'|driven by none");
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, q), error);
    assert_ok(mbsr_stage_velocities(s.m, s.d, u), error);
    assert_ok(mbsr_closures_transpose(s.m, s.d, none, tau), error);
    for (int k = 0; k < 4; ++k) assert_true(fabs(tau[k]) <= 0.0);
    assert_ok(mbsr_closures_apply(s.m, s.d, u, none), error);
    assert_ok(mbsr_closures_rate(s.m, s.d, none), error);
    assert_ok(mbsr_closures_gap(s.m, s.d, none), error);
    assert_ok(mbsr_closures_bias(s.m, s.d, none), error);
    assert_ok(mbsr_closures_set_lambda(s.m, s.d, none), error);
    assert_ok(mbsr_stage_forces(s.m, s.d, NULL), error);
    assert_ok(mbsr_closures_lambda(s.m, s.d, none), error);
    assert_ok(mbsr_closures_mobility(s.m, s.d, tau), error);
    assert_ok(mbsr_closures_set_redundant(s.m, s.d, idle), error);
    assert_ok(mbsr_closures_redundant(s.m, s.d, idle), error);
    assert_ok(mbsr_closures_weight(s.m, tau), error);
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, q, NULL, q, NULL), error);
    for (int lists = 0; lists < 2; ++lists) {
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, q, &report, lists ? idle : NULL,
                                       lists ? idle : NULL),
                  error);
        assert_int_equal(report.rows, 0);
        assert_int_equal(report.mobility, 4);
        assert_int_equal(report.weakest, MBSR_NONE);
        assert_int_equal(report.stretched, MBSR_NONE);
    }
    loops_free(&s);
}

/* A slide that is to accelerate 1 kg by 1 m/s^2, and a hinge 1e-3 kg m^2 by 1 rad/s^2, alone or
 * coupled to a second one: the motor of the one does not stand in for that of the other, in
 * whatever units. */
static void a_motor_too_few(void **state)
{
    (void)state;
    static const double length[] = {1.0, 1e3, 1.0 / 1048576.0, 1048576.0}, twice[2] = {1.0, -1.0};
    for (int k = 0; k < 16; ++k) {
        const double L = length[k % 4], com[2] = {0.0, 0.0}, udot[3] = {L, 1.0, 1.0};
        const mbsr_planar_frame none = {0.0, 0.0, 0.0}, aside = {L, 0.0, 0.0};
        const int coupled = k / 8, hinge = k / 4 % 2, rate[1] = {hinge};
        const mbsr_motors motors = {1, rate};
        double q[3] = {0.0, 0.0, 0.0}, tau[3];
        loops s;
        loops_begin(&s, NULL);
        test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none),
                      mbsr_inertia_planar(1.0, com, 0.0));
        for (int l = 0; l <= coupled; ++l)
            test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_revolute(aside, none),
                          mbsr_inertia_planar(1.0, com, 1e-3 * L * L));
        if (coupled)
            add(&s, mbsr_closure_coupling(2, (int[2]){1, 2}, (int[2]){0, 0}, twice, 0.0), "same");
        loops_finish(&s);
        assert_int_equal(mbsr_inverse_dynamics(s.m, s.d, 0.0, q, q, udot, &motors, tau),
                         MBSR_UNDETERMINED);
        assert_contains(mbsr_data_error(s.d)->text, hinge ? "u0 of body 0" : "u0 of body 1");
        loops_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contradictions),
        cmocka_unit_test(redundancies),
        cmocka_unit_test(no_closures),
        cmocka_unit_test(a_motor_too_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
