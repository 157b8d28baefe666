/* The paper's problems integrated by IDA: trajectories against the matrix exponential, and step
 * counts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "paper.h"
#include "reference_runs.h"

enum { POINTS = 20 };

/* A problem with its exact solution. */
typedef struct problem {
    const char *name;
    mbsr_model *model;
    expm_system system;
    void (*state)(const double *q, const double *u, double *x);
    void (*positions)(const double *x, double *q);
} problem;

/* Largest error of the positions on 0 .. T. */
static double trajectory_error(const problem *p, mbsr_dae_form form, mbsr_ida_solver solver,
                               bool renew, double tolerance, const double *start, double T,
                               mbsr_ida_stats *stats)
{
    mbsr_data *d;
    mbsr_ida *ida;
    double y[12], yp[12], x[EXPM_MOST], q[4], u[4], worst = 0.0;
    const int nq = mbsr_model_nq(p->model);
    assert_int_equal(mbsr_data_create(p->model, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_dae_pack(p->model, d, form, 0.0, start, start + nq, y), MBSR_OK);
    assert_int_equal(mbsr_dae_consistent(p->model, d, form, 0.0, y, yp, NULL, NULL), MBSR_OK);
    assert_int_equal(mbsr_dae_unpack(p->model, d, form, 0.0, y, q, u), MBSR_OK);
    p->state(q, u, x);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    opt.linear_solver = solver;
    opt.renew_matrices = renew;
    opt.rtol = opt.atol = tolerance;
    assert_int_equal(mbsr_ida_create(p->model, d, &opt, &ida, NULL), MBSR_OK);
    assert_int_equal(mbsr_ida_start(ida, 0.0, y, yp), MBSR_OK);
    for (int k = 1; k <= POINTS; ++k) {
        assert_int_equal(mbsr_ida_advance(ida, T * k / POINTS, NULL, y, NULL), MBSR_OK);
        expm_solve(&p->system, T / POINTS, x, x);
        p->positions(x, q);
        for (int c = 0; c < nq; ++c) worst = fmax(worst, fabs(y[c] - q[c]));
    }
    assert_int_equal(mbsr_ida_get_stats(ida, stats), MBSR_OK);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    return worst;
}

/* Error below 100 times the tolerance at each of three tolerances, and falling with them. */
static void converges(const problem *p, mbsr_dae_form form, const double *start)
{
    double error[3];
    const double tolerance[3] = {1e-4, 1e-6, 1e-8};
    mbsr_ida_stats stats;
    for (int k = 0; k < 3; ++k) {
        error[k] = trajectory_error(p, form, MBSR_IDA_AUTO, true, tolerance[k], start, 1.0, &stats);
        print_message("%s, form %d, tolerance %.0e: error %.1e, %ld steps\n", p->name, (int)form,
                      tolerance[k], error[k], stats.steps);
        assert_less(error[k], 100.0 * tolerance[k]);
    }
    assert_less(error[1], 0.1 * error[0]);
    assert_less(error[2], 0.01 * error[0]);
}

/* Steps and iterations of the momentum form, with the tree solver and with a dense matrix. */
static void compare_solvers(const problem *p, double tolerance, const double *start, double T)
{
    run_counts counts = {{0}, {0}, {0}};
    for (int k = 0; k < RUN_KINDS * RUN_REPEATS; ++k) {
        const int kind = k % RUN_KINDS;
        mbsr_ida_stats stats;
        trajectory_error(p, MBSR_DAE_MOMENTUM, run_solvers[kind], kind == RUN_RENEWED,
                         run_tolerance(tolerance, k / RUN_KINDS), start, T, &stats);
        run_count(&counts, kind, &stats);
    }
    run_assert_like_dense(p->name, &counts);
}

enum { FORMS = 4, DIRECT = 2 };

/* Those in (q, u) first. */
static const mbsr_dae_form forms[FORMS] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS,
                                           MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1};

static void upper_configuration_converges_to_the_exact_motion(void **unused)
{
    (void)unused;
    const double start[8] = {0.1, 0.1, 0.05, 0.0, 0.3, 0.2, -0.1, 0.2};
    for (int with_mass = 0; with_mass < 2; ++with_mass) {
        paper_parameters parameters = paper_standard;
        parameters.mi = with_mass ? 0.2 : 0.0;
        const problem p = {with_mass ? "upper, mi = 0.2" : "upper, mi = 0",
                           paper_upper(&parameters), paper_upper_system(&parameters),
                           paper_upper_state, paper_upper_positions};
        for (int f = 0; f < FORMS; ++f) converges(&p, forms[f], start);
        compare_solvers(&p, 1e-6, start, 1.0);
        mbsr_model_destroy(p.model);
    }
}

static void lower_configuration_converges_to_the_exact_motion(void **unused)
{
    (void)unused;
    const double start[6] = {0.1, 0.1, 0.05, 0.3, 0.2, -0.1};
    for (int with_mass = 0; with_mass < 2; ++with_mass) {
        paper_parameters parameters = paper_standard;
        parameters.mi = with_mass ? 0.2 : 0.0;
        const problem p = {with_mass ? "lower, mi = 0.2" : "lower, mi = 0",
                           paper_lower(&parameters), paper_lower_system(&parameters),
                           paper_lower_state, paper_lower_positions};
        for (int f = 0; f < FORMS; ++f) converges(&p, forms[f], start);
        compare_solvers(&p, 1e-6, start, 1.0);
        mbsr_model_destroy(p.model);
    }
}

/* Relative: x = p1 p2 v2 v1 from q1 = p1, q2 = p2 - p1. */
static void relative_state(const double *q, const double *u, double *x)
{
    x[0] = q[0], x[1] = q[0] + q[1], x[2] = u[0] + u[1], x[3] = u[0];
}

static void relative_positions(const double *x, double *q)
{
    q[0] = x[0], q[1] = x[1] - x[0];
}

static void absolute_state(const double *q, const double *u, double *x)
{
    x[0] = q[0], x[1] = q[1], x[2] = u[1], x[3] = u[0];
}

static void absolute_positions(const double *x, double *q)
{
    q[0] = x[0], q[1] = x[1];
}

/* Steps at rtol = atol = 1e-4 on 0 .. 2, started at rest at p = 0, or for m1 = 0 on the smooth
 * solution. */
static long oscillator_steps(double m1, int relative, mbsr_dae_form form, double *error)
{
    oscillator_parameters parameters = oscillator_standard;
    parameters.m1 = m1;
    const double smooth = m1 > 0.0 ? 0.0 : parameters.F / (parameters.c1 + parameters.c2);
    const double start[4] = {smooth, relative ? -smooth : 0.0, 0.0, 0.0};
    const problem p = {"oscillators", paper_oscillators(&parameters, relative),
                       paper_oscillator_system(&parameters),
                       relative ? relative_state : absolute_state,
                       relative ? relative_positions : absolute_positions};
    mbsr_ida_stats stats;
    *error = trajectory_error(&p, form, MBSR_IDA_AUTO, true, 1e-4, start, 2.0, &stats);
    print_message("oscillators, m1 = %g, %s, form %d: %ld steps, error %.1e\n", m1,
                  relative ? "relative" : "absolute", (int)form, stats.steps, *error);
    if (form == MBSR_DAE_RECURSIVE) compare_solvers(&p, 1e-4, start, 2.0);
    mbsr_model_destroy(p.model);
    return stats.steps;
}

static void a_small_mass_costs_steps_and_zero_gives_them_back(void **unused)
{
    (void)unused;
    for (int relative = 0; relative < 2; ++relative) {
        for (int f = 0; f < DIRECT; ++f) {
            double error;
            const long s3 = oscillator_steps(1e-3, relative, forms[f], &error);
            assert_less(error, 0.05);
            const long s4 = oscillator_steps(1e-4, relative, forms[f], &error),
                       s5 = oscillator_steps(1e-5, relative, forms[f], &error);
            const long s0 = oscillator_steps(0.0, relative, forms[f], &error);
            assert_less(error, 1e-3);
            assert_less(2.5, (double)s4 / (double)s3);
            assert_less((double)s4 / (double)s3, 3.8);
            assert_less(2.5, (double)s5 / (double)s4);
            assert_less((double)s5 / (double)s4, 3.8);
            assert_true(50 * s0 <= s4);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(upper_configuration_converges_to_the_exact_motion),
        cmocka_unit_test(lower_configuration_converges_to_the_exact_motion),
        cmocka_unit_test(a_small_mass_costs_steps_and_zero_gives_them_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
