/* The driver on problems with known solutions: accuracy, steps, events, restart, statistics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "problems.h"

#include <mbsrank/driver.h>

#include <ida/ida.h>
#include <ida/ida_ls.h>

#include <stdbool.h>

static mbsr_ida_opt with_tolerance(double tolerance)
{
    mbsr_ida_opt opt = problem_opt();
    opt.rtol = opt.atol = tolerance;
    return opt;
}

static double largest_difference(int n, const double *a, const double *b)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(a[k] - b[k]));
    return value;
}

/* ---- accuracy ---- */

/* Largest error of q at t_end, and in the (q, u) forms of u too. */
static double oscillator_error(mbsr_dae_form form, bool renew, double tolerance, double t_end,
                               long *steps)
{
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida_opt opt = with_tolerance(tolerance);
    opt.form = form;
    opt.renew_matrices = renew;
    const int known =
        form == MBSR_DAE_MOMENTUM ? 2 : 4; /* entries of y that are entries of (q, u) */
    double t = NAN, y[6], yp[6], exact[4];
    problem_in_form(&p, form, y, yp);
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, t_end, &t, y, yp), mbsr_ida_error(ida));
    assert_true(t == t_end);
    oscillator_solution(t, exact);
    const double rate[4] = {exact[2], exact[3], -4.0 * exact[0], -9.0 * exact[1]};
    assert_close(largest_difference(known, yp, rate), 0.0, 10000.0 * tolerance);
    *steps = problem_stats(ida).steps;
    mbsr_ida_destroy(ida);
    problem_free(&p);
    return largest_difference(known, y, exact);
}

static void the_error_falls_with_the_tolerance(void **state)
{
    (void)state;
    const struct {
        mbsr_dae_form form;
        bool renew;
        double loosest, most;
    } runs[] = {{MBSR_DAE_MOMENTUM, false, 1e-4, 500.0},
                {MBSR_DAE_MOMENTUM, true, 1e-3, 500.0},
                {MBSR_DAE_RECURSIVE, false, 1e-4, 1000.0}};
    for (int r = 0; r < 3; ++r) {
        double last = INFINITY;
        long last_steps = 0;
        for (double tolerance = runs[r].loosest; tolerance > 1e-11; tolerance *= 1e-3) {
            long steps = 0;
            const double error =
                oscillator_error(runs[r].form, runs[r].renew, tolerance, 5.0, &steps);
            assert_less(error, runs[r].most * tolerance);
            assert_less(error, 0.05 * last);
            assert_true(steps > last_steps);
            last = error;
            last_steps = steps;
        }
    }
}

static void time_may_run_backwards(void **state)
{
    (void)state;
    long steps = 0;
    assert_less(oscillator_error(MBSR_DAE_RECURSIVE, true, 1e-8, -5.0, &steps), 1e-5);
    assert_less(oscillator_error(MBSR_DAE_MOMENTUM, true, 1e-8, -5.0, &steps), 1e-6);
    /* there and back again */
    problem p;
    problem_pendulum(&p);
    const mbsr_ida_opt opt = with_tolerance(1e-9);
    mbsr_ida *ida = problem_start(&p, &opt);
    double t = NAN, y[2], yp[2];
    assert_ok(mbsr_ida_advance(ida, 1.0, &t, y, yp), mbsr_ida_error(ida));
    assert_true(fabs(y[0] - p.y[0]) > 0.5);
    assert_ok(mbsr_ida_start(ida, t, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.5, NULL, NULL, NULL), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.0, &t, y, yp), mbsr_ida_error(ida));
    assert_true(t == 0.0);
    assert_close(largest_difference(2, y, p.y), 0.0, 1e-6);
    assert_true(problem_stats(ida).last_step < 0.0);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void a_point_without_mass_follows_spring_and_damper(void **state)
{
    (void)state;
    problem p;
    problem_massless(&p, NULL);
    assert_close(p.y[1], -3.0, 1e-10);
    const mbsr_dae_form forms[] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS};
    for (int f = 0; f < 2; ++f) {
        mbsr_ida_opt opt = with_tolerance(1e-8);
        opt.form = forms[f];
        opt.raw_outputs = 1; /* nothing but the form's own residual is evaluated */
        mbsr_ida *ida = problem_start(&p, &opt);
        double y[2];
        assert_ok(mbsr_ida_advance(ida, 1.5, NULL, y, NULL), mbsr_ida_error(ida));
        assert_close(y[0], exp(-4.5), 1e-6);
        assert_close(y[1], -3.0 * exp(-4.5), 1e-6);
        /* only the recursion decides on ranks */
        assert_int_equal(mbsr_total_rank(p.model, p.data), f == 0 ? 0 : -1);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

static void the_pendulum_keeps_its_energy(void **state)
{
    (void)state;
    problem p;
    problem_pendulum(&p);
    const mbsr_ida_opt opt = with_tolerance(1e-9);
    mbsr_ida *ida = problem_start(&p, &opt);
    for (int k = 1; k <= 20; ++k) {
        double t = NAN, y[2], kinetic = NAN, potential = NAN;
        assert_ok(mbsr_ida_advance(ida, 0.1 * k, &t, y, NULL), mbsr_ida_error(ida));
        assert_ok(mbsr_stage_positions(p.model, p.data, t, y), mbsr_data_error(p.data));
        assert_ok(mbsr_stage_velocities(p.model, p.data, y + 1), mbsr_data_error(p.data));
        assert_ok(mbsr_energy(p.model, p.data, &kinetic, &potential), mbsr_data_error(p.data));
        assert_close(kinetic, 0.5 * y[1] * y[1], 1e-12);
        assert_close(kinetic + potential, 0.0, 1e-6);
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- events ---- */

/* A quarter of the period 4 K(1/sqrt 2) sqrt(l/g); K by the arithmetic-geometric mean. */
static double quarter_period(void)
{
    double a = 1.0, b = sqrt(0.5);
    for (int k = 0; k < 6; ++k) {
        const double mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
    }
    return acos(-1.0) / (2.0 * a) * sqrt(1.0 / 9.81);
}

/* 0: the lowest point; 1: never; 2: the turning points. */
static int pendulum_events(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)t;
    (void)yp;
    ++*(long *)user;
    value[0] = y[0] + 0.5 * acos(-1.0);
    value[1] = 100.0;
    value[2] = y[1];
    return 0;
}

static void the_pendulum_passes_its_lowest_point_in_time(void **state)
{
    (void)state;
    assert_close(4.0 * quarter_period(), 2.3678, 5e-5);
    problem p;
    problem_pendulum(&p);
    long calls = 0;
    mbsr_ida_opt opt = with_tolerance(1e-10);
    opt.events = 3;
    opt.event = pendulum_events;
    opt.event_user = &calls;
    mbsr_ida *ida = problem_start(&p, &opt);
    double t = NAN, y[2], yp[2];
    int direction[3] = {9, 9, 9};
    const int expected[4][3] = {{-1, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, -1}};
    assert_int_equal(mbsr_ida_event_info(ida, direction), MBSR_ERR_SEQUENCE);
    for (int k = 0; k < 4; ++k) {
        assert_int_equal(mbsr_ida_advance(ida, 10.0, &t, y, yp), MBSR_EVENT);
        assert_close(t, (k + 1) * quarter_period(), 1e-7);
        assert_int_equal(mbsr_ida_event_info(ida, direction), MBSR_OK);
        assert_memory_equal(direction, expected[k], sizeof direction);
        assert_close(yp[0], y[1], 1e-7);
        /* where the integration already is, the event is over but the state stays */
        double again[2];
        assert_ok(mbsr_ida_advance(ida, t, NULL, again, NULL), mbsr_ida_error(ida));
        assert_memory_equal(again, y, sizeof y);
        assert_int_equal(mbsr_ida_event_info(ida, direction), MBSR_ERR_SEQUENCE);
        double same = NAN;
        assert_ok(mbsr_ida_advance(ida, nextafter(t, 0.0), &same, again, NULL),
                  mbsr_ida_error(ida));
        assert_true(same == t);
        assert_memory_equal(again, y, sizeof y);
    }
    assert_ok(mbsr_ida_advance(ida, 4.1 * quarter_period(), &t, y, NULL), mbsr_ida_error(ida));
    assert_int_equal(problem_stats(ida).events, calls);
    assert_true(calls > problem_stats(ida).steps);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- steps ---- */

static void output_does_not_change_the_steps(void **state)
{
    (void)state;
    const double first[] = {2.0, 1e-9, 1e-3, 0.5};
    const double start[] = {
        1.0, 1e-12}; /* amplitude: the second one moves slowly against its tolerance */
    for (int s = 0; s < 2; ++s) {
        double reference[4], y[4];
        mbsr_ida_stats expected = {0};
        for (int f = 0; f < 4; ++f) {
            problem p;
            problem_oscillator(&p, NULL);
            for (int k = 0; k < 4; ++k) {
                p.y[k] *= start[s];
                p.yp[k] *= start[s];
            }
            mbsr_ida *ida = problem_start(&p, NULL);
            assert_ok(mbsr_ida_advance(ida, first[f], NULL, y, NULL), mbsr_ida_error(ida));
            for (int k = 1; k < 100 * f; ++k) {
                const double t = first[f] + (2.0 - first[f]) * k / (100 * f);
                assert_ok(mbsr_ida_advance(ida, t, NULL, y, NULL), mbsr_ida_error(ida));
            }
            assert_ok(mbsr_ida_advance(ida, 2.0, NULL, y, NULL), mbsr_ida_error(ida));
            if (f == 0) {
                memcpy(reference, y, sizeof y);
                expected = problem_stats(ida);
            }
            assert_memory_equal(y, reference, sizeof y);
            assert_same_stats(problem_stats(ida), expected);
            mbsr_ida_destroy(ida);
            problem_free(&p);
        }
    }
}

static void check_restart(mbsr_ida_solver solver, mbsr_dae_form form)
{
    problem p;
    double start[3], rate[3];
    problem_pendulum(&p);
    problem_in_form(&p, form, start, rate);
    memcpy(p.y, start, sizeof start);
    memcpy(p.yp, rate, sizeof rate);
    long calls = 0;
    mbsr_ida_opt opt = with_tolerance(1e-7);
    opt.form = form;
    opt.linear_solver = solver;
    opt.events = 3;
    opt.event = pendulum_events;
    opt.event_user = &calls;
    mbsr_ida *ida = problem_start(&p, &opt);
    double t[2], y[2][3] = {{0.0}}, yp[2][3] = {{0.0}};
    mbsr_ida_stats stats[2];
    for (int run = 0; run < 2; ++run) {
        assert_int_equal(mbsr_ida_advance(ida, 5.0, NULL, NULL, NULL), MBSR_EVENT);
        assert_int_equal(mbsr_ida_advance(ida, 5.0, &t[run], y[run], yp[run]), MBSR_EVENT);
        stats[run] = problem_stats(ida);
        /* whatever happened before */
        assert_int_equal(mbsr_ida_advance(ida, 3.0, NULL, NULL, NULL), MBSR_EVENT);
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
        assert_same_stats(problem_stats(ida), (mbsr_ida_stats){0});
    }
    assert_memory_equal(&t[0], &t[1], sizeof t[0]);
    assert_memory_equal(y[0], y[1], sizeof y[0]);
    assert_memory_equal(yp[0], yp[1], sizeof yp[0]);
    assert_same_stats(stats[0], stats[1]);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void a_restart_gives_the_same_numbers(void **state)
{
    (void)state;
    check_restart(MBSR_IDA_DENSE, MBSR_DAE_RECURSIVE);
    check_restart(MBSR_IDA_TREE, MBSR_DAE_MOMENTUM);
}

static void too_few_steps_may_be_continued(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    double whole[4], y[4] = {7.0, 7.0, 7.0, 7.0}, t = 7.0;
    mbsr_ida *ida = problem_start(&p, NULL);
    assert_ok(mbsr_ida_advance(ida, 1.0, NULL, whole, NULL), mbsr_ida_error(ida));
    const long steps = problem_stats(ida).steps;
    mbsr_ida_destroy(ida);

    mbsr_ida_opt opt = problem_opt();
    opt.max_steps = 10;
    ida = problem_start(&p, &opt);
    long calls = 1;
    int status = mbsr_ida_advance(ida, 1.0, &t, y, NULL);
    assert_refused(status, mbsr_ida_error(ida), MBSR_ERR_SOLVER, MBSR_NONE, MBSR_NONE,
                   "mbsr_ida_advance|IDA_TOO_MUCH_WORK|call again|mxstep steps taken");
    assert_true(t == 7.0 && y[0] == 7.0);
    for (; status == MBSR_ERR_SOLVER && calls < 1000; ++calls) {
        status = mbsr_ida_advance(ida, 1.0, &t, y, NULL);
    }
    assert_ok(status, mbsr_ida_error(ida));
    assert_true(t == 1.0);
    assert_int_equal(calls, (steps + 9) / 10);
    assert_int_equal(problem_stats(ida).steps, steps);
    assert_memory_equal(y, whole, sizeof y);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- options ---- */

static void options_reach_ida(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    for (int order = 1; order <= 5; ++order) {
        mbsr_ida_opt opt = with_tolerance(1e-6);
        opt.max_order = order;
        opt.max_step = 0.004;
        opt.initial_step = 1e-5;
        mbsr_ida *ida = problem_start(&p, &opt);
        for (int k = 1; k <= 20; ++k) {
            assert_ok(mbsr_ida_advance(ida, -0.1 * k, NULL, NULL, NULL), mbsr_ida_error(ida));
            const mbsr_ida_stats stats = problem_stats(ida);
            assert_in_range(stats.last_order, 1, order);
            assert_less(fabs(stats.last_step), 0.004 * (1.0 + 1e-12));
        }
        assert_true(problem_stats(ida).steps >= 500);
        double first = NAN;
        assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &first), IDA_SUCCESS);
        assert_true(first == -1e-5);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* An error of half the tolerance, h^2 y''/2 of the differential entries that have a y'', at most
 * 1e-3 of the least tolerance of q over the largest of u. Of the oscillator q'' = (-4 q_x, -9 q_y),
 * and of p = 2 u it is p'' = (-8 u_x, -18 u_y). */
static void the_first_step_follows_from_the_start(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    const double q[2] = {1.0, 2.0}, u[2] = {3.0, -4.0}, curve[4] = {-4.0, -18.0, -24.0, 72.0};
    const double size[6] = {1.0, 2.0, 6.0, 8.0, 3.0, 4.0}, rest[6] = {0.0};
    const double each[6] = {1e-8, 2e-8, 3e-8, 4e-8, 5e-8, 6e-8},
                 longest[3] = {1e-3 * 1e-8 / 4e-8, 1e-3 * 1e-8 / 6e-8, 1e-3};
    for (int run = 0; run < 3; ++run) {
        /* (q, u); momenta with a tolerance each; momenta with tolerances from their mass, 2 kg */
        const int n = run ? 6 : 4, counted = run ? 4 : 2;
        mbsr_ida_opt opt = problem_opt();
        opt.form = run ? MBSR_DAE_MOMENTUM : MBSR_DAE_RECURSIVE;
        opt.rtol = 1e-7;
        opt.atol = 1e-8;
        if (run < 2) opt.atol_each = each;
        double y[6], yp[6], sum = 0.0, first = NAN;
        for (int k = 0; k < counted; ++k) {
            const double atol = run < 2 ? each[k] : k < 2 ? 1e-8 : 2e-8;
            sum += pow(curve[k] / (1e-7 * size[k] + atol), 2.0);
        }
        mbsr_ida *ida = NULL;
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        assert_ok(mbsr_dae_pack(p.model, p.data, opt.form, 2.0, q, u, y), NULL);
        assert_ok(mbsr_dae_consistent(p.model, p.data, opt.form, 2.0, y, yp, NULL, NULL), NULL);
        assert_ok(mbsr_ida_start(ida, 2.0, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 2.1, NULL, NULL, NULL), mbsr_ida_error(ida));
        assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &first), IDA_SUCCESS);
        /* y'' is a difference over 5e-8 to 1e-3 s */
        assert_close(first, 1.0 / sqrt(sqrt(sum / n)), 1e-4 * first);
        assert_less(first, 0.9e-3);
        assert_ok(mbsr_ida_start(ida, 2.0, rest, rest), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 100.0, NULL, NULL, NULL), mbsr_ida_error(ida));
        assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &first), IDA_SUCCESS);
        assert_close(first, longest[run], 1e-15);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

static void absolute_tolerances_may_differ_entry_by_entry(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    double y[3][4], each[4] = {1e-7, 1e-7, 1e-7, 1e-7};
    mbsr_ida_stats stats[3];
    for (int run = 0; run < 3; ++run) {
        mbsr_ida_opt opt = problem_opt();
        opt.atol = run == 0 ? 1e-7 : NAN; /* not read when atol_each is given */
        opt.atol_each = run == 0 ? NULL : each;
        if (run == 2) each[3] = 1e-13;
        opt.rtol = 1e-9;
        mbsr_ida *ida = problem_start(&p, &opt);
        const double kept = each[0];
        if (run > 0) each[0] = NAN; /* read at creation only */
        assert_ok(mbsr_ida_advance(ida, 1.0, NULL, y[run], NULL), mbsr_ida_error(ida));
        each[0] = kept;
        stats[run] = problem_stats(ida);
        mbsr_ida_destroy(ida);
    }
    assert_memory_equal(y[0], y[1], sizeof y[0]);
    assert_same_stats(stats[0], stats[1]);
    assert_true(stats[2].steps > stats[1].steps);
    problem_free(&p);
}

/* ---- statistics and dense output ---- */

static void statistics_agree_with_ida_and_with_the_model(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida_opt opt = problem_opt();
    opt.initial_step = 0.5; /* far too long */
    mbsr_ida *ida = problem_start(&p, &opt);
    for (int run = 0; run < 2; ++run) {
        observer.calls = 0;
        observer.fail_first = 1;
        observer.code = 1;
        assert_ok(mbsr_ida_advance(ida, 3.0, NULL, NULL, NULL), mbsr_ida_error(ida));
        const mbsr_ida_stats stats = problem_stats(ida);
        void *const memory = mbsr_ida_memory(ida);
        long newton = 0, quotients = 0, steps = 0, rejected = 0, diverged = 0;
        double present = 0.0;
        assert_int_equal(IDAGetNumResEvals(memory, &newton), IDA_SUCCESS);
        assert_int_equal(IDAGetNumLinResEvals(memory, &quotients), IDA_SUCCESS);
        assert_int_equal(IDAGetNumSteps(memory, &steps), IDA_SUCCESS);
        assert_int_equal(IDAGetCurrentTime(memory, &present), IDA_SUCCESS);
        assert_int_equal(stats.residuals, observer.calls);
        assert_int_equal(stats.residuals, newton + stats.jacobian_residuals);
        /* IDA's own quotients, 4 for a matrix, and those of careful steps: 6, and 2 for a filtered
         * error */
        assert_in_range(stats.jacobian_residuals, quotients, stats.residuals);
        assert_in_range(stats.jacobian_residuals, 4 * stats.jacobians,
                        6 * stats.jacobians + 2 * stats.filter_solves);
        assert_int_equal(stats.steps, steps);
        assert_int_equal(IDAGetNumErrTestFails(memory, &rejected), IDA_SUCCESS);
        assert_int_equal(IDAGetNumNonlinSolvConvFails(memory, &diverged), IDA_SUCCESS);
        assert_int_equal(stats.error_test_failures, rejected);
        assert_int_equal(stats.newton_failures, diverged);
        assert_true(rejected > 0 && diverged > 0);
        assert_true(stats.jacobians > 0 && stats.jacobians < stats.steps);
        assert_true(stats.newton_iterations >= stats.steps + stats.error_test_failures);
        assert_int_equal(stats.events, 0);
        assert_in_range(stats.last_order, 1, 5);
        assert_true(present >= 3.0 && present - stats.last_step < 3.0);
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* The residual that serves to choose the first step counts as well. */
static void statistics_count_the_choice_of_the_first_step(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida *ida = problem_start(&p, NULL);
    observer.calls = 0;
    assert_ok(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida));
    long newton = 0;
    assert_int_equal(IDAGetNumResEvals(mbsr_ida_memory(ida), &newton), IDA_SUCCESS);
    const mbsr_ida_stats stats = problem_stats(ida);
    assert_int_equal(stats.residuals, observer.calls);
    assert_int_equal(stats.residuals, newton + stats.jacobian_residuals + 1);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void derivatives_are_those_of_the_solution(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida_opt opt = with_tolerance(1e-9);
    opt.raw_outputs = 1;
    mbsr_ida *ida = problem_start(&p, &opt);
    double y[4], yp[4], dky[4], exact[4], present = 0.0;
    assert_ok(mbsr_ida_advance(ida, 2.0, NULL, y, yp), mbsr_ida_error(ida));
    assert_int_equal(IDAGetCurrentTime(mbsr_ida_memory(ida), &present), IDA_SUCCESS);
    const double step = problem_stats(ida).last_step;
    assert_ok(mbsr_ida_dense(ida, 2.0, 0, dky), mbsr_ida_error(ida));
    assert_close(largest_difference(4, dky, y), 0.0, 1e-14);
    assert_ok(mbsr_ida_dense(ida, 2.0, 1, dky), mbsr_ida_error(ida));
    assert_close(largest_difference(4, dky, yp), 0.0, 1e-12);
    for (int k = 0; k <= 4; ++k) {
        const double t = present - 0.25 * k * step;
        oscillator_solution(t, exact);
        assert_ok(mbsr_ida_dense(ida, t, 0, dky), mbsr_ida_error(ida));
        assert_close(largest_difference(4, dky, exact), 0.0, 1e-7);
        assert_ok(mbsr_ida_dense(ida, t, 1, dky), mbsr_ida_error(ida));
        assert_close(dky[0], exact[2], 1e-6);
        assert_close(dky[3], -9.0 * exact[1], 1e-5);
        assert_ok(mbsr_ida_dense(ida, t, 2, dky), mbsr_ida_error(ida));
        assert_close(dky[0], -4.0 * exact[0], 1e-3);
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_error_falls_with_the_tolerance),
        cmocka_unit_test(time_may_run_backwards),
        cmocka_unit_test(a_point_without_mass_follows_spring_and_damper),
        cmocka_unit_test(the_pendulum_keeps_its_energy),
        cmocka_unit_test(the_pendulum_passes_its_lowest_point_in_time),
        cmocka_unit_test(output_does_not_change_the_steps),
        cmocka_unit_test(a_restart_gives_the_same_numbers),
        cmocka_unit_test(too_few_steps_may_be_continued),
        cmocka_unit_test(options_reach_ida),
        cmocka_unit_test(the_first_step_follows_from_the_start),
        cmocka_unit_test(absolute_tolerances_may_differ_entry_by_entry),
        cmocka_unit_test(statistics_agree_with_ida_and_with_the_model),
        cmocka_unit_test(statistics_count_the_choice_of_the_first_step),
        cmocka_unit_test(derivatives_are_those_of_the_solution),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
