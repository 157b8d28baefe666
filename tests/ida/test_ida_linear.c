/* The linear systems of the driver: which solver runs, what it counts, and that they agree.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "problems.h"
#include "reference_runs.h"

#include <ida/ida.h>
#include <ida/ida_ls.h>

#include <stdbool.h>

/* ---- a chain with springs across ---- */

/* Rods of 0.3 m in the plane, one on the other, each with a mass at its end but every third, which
 * has none. Springs and dampers in the joints, to the ground and, stiff, from each rod to the third
 * before it. */
enum { RODS = 9 };

static mbsr_model *tied_chain(void)
{
    const double end[3] = {0.3, 0.0, 0.0};
    mbsr_model *m = run_model();
    int body[RODS];
    for (int k = 0; k < RODS; ++k) {
        const mbsr_planar_frame A = {k > 0 ? 0.3 : 0.0, 0.0, 0.0};
        body[k] = run_body(m, NULL, k > 0 ? body[k - 1] : MBSR_GROUND,
                           mbsr_joint_planar_revolute(A, run_origin),
                           k % 3 == 2 ? mbsr_inertia_zero() : mbsr_inertia_planar(0.4, end, 0.002));
        run_force(m, mbsr_force_joint_spring(body[k], 0, 3.0, 0.2, 0.0));
        const double anchor[3] = {0.3 * k, -0.5, 0.0};
        run_force(m, mbsr_force_point_spring(body[k], end, MBSR_GROUND, anchor, 20.0, 0.5, 0.4));
        if (k >= 3) {
            run_force(m,
                      mbsr_force_point_spring(body[k], end, body[k - 3], end, 3000.0, 20.0, 0.7));
        }
    }
    run_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return run_finish(m);
}

typedef struct outcome {
    double y[3 * RODS];
    mbsr_ida_stats stats;
    mbsr_newton_info info;
} outcome;

static outcome run_chain(const mbsr_model *m, mbsr_ida_opt opt)
{
    outcome found = {{0.0}, {0}, {0}};
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    double y[3 * RODS], yp[3 * RODS];
    const double q[RODS] = {0.3, -0.2, 0.1}, u[RODS] = {0.0, 1.0, -0.5};
    assert_int_equal(mbsr_dae_size(m, opt.form), 3 * RODS);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, opt.form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, opt.form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 2.0, NULL, found.y, NULL), mbsr_ida_error(ida));
    assert_int_equal(mbsr_ida_get_stats(ida, &found.stats), MBSR_OK);
    if (mbsr_ida_newton(ida)) {
        assert_int_equal(mbsr_newton_get_info(mbsr_ida_newton(ida), &found.info), MBSR_OK);
    }
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    return found;
}

static mbsr_ida_opt solved_by(mbsr_ida_solver solver, double tolerance)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.linear_solver = solver;
    opt.rtol = opt.atol = tolerance;
    return opt;
}

static double distance(const outcome *a, const outcome *b)
{
    double largest = 0.0;
    for (int k = 0; k < RODS; ++k) largest = run_larger(largest, fabs(a->y[k] - b->y[k]));
    return largest;
}

/* Correction of low rank, exact; the tree alone as preconditioner; with and without max_norm. */
static void springs_across_are_corrected_or_iterated(void **state)
{
    (void)state;
    mbsr_model *m = tied_chain();
    const outcome best = run_chain(m, solved_by(MBSR_IDA_DENSE, 1e-10));
    for (double tolerance = 1e-4; tolerance > 1e-9; tolerance *= 1e-2) {
        for (int max_norm = 0; max_norm < 2; ++max_norm) {
            mbsr_ida_opt opt = solved_by(MBSR_IDA_DENSE, tolerance);
            opt.max_norm = max_norm;
            const outcome dense = run_chain(m, opt);
            opt.linear_solver = MBSR_IDA_AUTO;
            opt.newton.method = MBSR_NEWTON_CORRECTED;
            const outcome corrected = run_chain(m, opt);
            opt.newton.method = MBSR_NEWTON_TREE;
            const outcome iterated = run_chain(m, opt);
            print_message("tolerance %.0e%s: dense %ld steps %ld iterations, corrected %ld %ld, "
                          "Krylov %ld %ld with %ld inside; errors %.1e %.1e %.1e\n",
                          tolerance, max_norm ? ", largest entry" : "", dense.stats.steps,
                          dense.stats.newton_iterations, corrected.stats.steps,
                          corrected.stats.newton_iterations, iterated.stats.steps,
                          iterated.stats.newton_iterations, iterated.stats.krylov_iterations,
                          distance(&dense, &best), distance(&corrected, &best),
                          distance(&iterated, &best));
            assert_int_equal(dense.stats.linear_solver, MBSR_IDA_DENSE);
            assert_int_equal(corrected.stats.linear_solver, MBSR_IDA_TREE);
            assert_int_equal(corrected.info.exact, 1);
            assert_int_equal(corrected.info.method, MBSR_NEWTON_CORRECTED);
            assert_int_equal(iterated.stats.linear_solver, MBSR_IDA_KRYLOV);
            assert_int_equal(iterated.info.exact, 0);
            /* GMRES goes with the matrix of the present step, not of an earlier one: it needs fewer
             * iterations of Newton's */
            const double steps = (double)dense.stats.steps;
            assert_close((double)corrected.stats.steps / steps, 1.0, 0.1);
            assert_close((double)iterated.stats.steps / steps, 1.0, 0.2);
            assert_true(iterated.stats.newton_iterations < corrected.stats.newton_iterations);
            /* each spring across adds a rank of 4: GMRES ends after one vector more */
            assert_int_equal(corrected.info.across, RODS - 3);
            assert_int_equal(corrected.info.rank, 4 * (RODS - 3));
            assert_true(iterated.stats.krylov_iterations <=
                        (4 * (RODS - 3) + 1) * iterated.stats.newton_iterations);
            assert_true(iterated.stats.krylov_iterations > iterated.stats.newton_iterations);
            assert_less(distance(&dense, &best), 200.0 * tolerance);
            assert_less(distance(&corrected, &best), 200.0 * tolerance);
            assert_less(distance(&iterated, &best), 200.0 * tolerance);
            /* GMRES measures as the error test does */
            if (max_norm) assert_less(distance(&iterated, &best), 4.0 * distance(&dense, &best));
        }
    }
    mbsr_model_destroy(m);
}

/* With too few vectors for the directions across it still converges, slowly. */
static void few_vectors_cost_steps(void **state)
{
    (void)state;
    mbsr_model *m = tied_chain();
    mbsr_ida_opt opt = solved_by(MBSR_IDA_KRYLOV, 1e-6);
    opt.newton.method = MBSR_NEWTON_TREE;
    const outcome many = run_chain(m, opt);
    opt.krylov_size = 2;
    const outcome few = run_chain(m, opt);
    assert_true(2 * few.stats.krylov_iterations <= 4 * few.stats.newton_iterations);
    assert_true(few.stats.newton_iterations > 2 * many.stats.newton_iterations);
    assert_less(distance(&few, &many), 200.0 * 1e-6);
    mbsr_model_destroy(m);
}

/* TREE runs without the correction too, if asked to: with more iterations and factorisations. */
static void the_tree_alone_is_not_enough_across(void **state)
{
    (void)state;
    mbsr_model *m = tied_chain();
    mbsr_ida_opt opt = solved_by(MBSR_IDA_TREE, 1e-6);
    const outcome exact = run_chain(m, opt);
    opt.newton.method = MBSR_NEWTON_TREE;
    const outcome left_out = run_chain(m, opt);
    assert_int_equal(left_out.stats.linear_solver, MBSR_IDA_TREE);
    assert_int_equal(left_out.info.exact, 0);
    assert_true(10 * left_out.stats.newton_iterations > 12 * exact.stats.newton_iterations);
    assert_true(10 * left_out.stats.factorisations > 15 * exact.stats.factorisations);
    assert_less(distance(&left_out, &exact), 200.0 * 1e-6);
    mbsr_model_destroy(m);
}

/* ---- choice and statistics ---- */

static void the_solver_follows_from_the_form(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        for (int s = MBSR_IDA_AUTO; s <= MBSR_IDA_KRYLOV; ++s) {
            const bool momentum = run_forms[f] == MBSR_DAE_MOMENTUM;
            mbsr_ida_opt opt = solved_by((mbsr_ida_solver)s, 1e-6);
            mbsr_ida *ida = NULL;
            mbsr_error error = {.status = 5}; /* written where something fails only */
            opt.form = run_forms[f];
            const int status = mbsr_ida_create(p.model, p.data, &opt, &ida, &error);
            if (!momentum && s > MBSR_IDA_DENSE) {
                assert_refused(status, &error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                               s == MBSR_IDA_TREE ? "linear_solver is TREE|momentum form only"
                                                  : "linear_solver is KRYLOV|form is");
                continue;
            }
            assert_ok(status, &error);
            assert_int_equal(error.status, 5);
            const mbsr_ida_solver expected = s != MBSR_IDA_AUTO ? (mbsr_ida_solver)s
                                             : momentum         ? MBSR_IDA_TREE
                                                                : MBSR_IDA_DENSE;
            assert_int_equal(problem_stats(ida).linear_solver, expected);
            assert_int_equal(mbsr_ida_newton(ida) != NULL, expected != MBSR_IDA_DENSE);
            mbsr_ida_destroy(ida);
        }
    }
    assert_null(mbsr_ida_newton(NULL));
    problem_free(&p);
}

static void wrong_options_are_refused(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    assert_int_equal(opt.linear_solver, MBSR_IDA_AUTO);
    const int wrong[] = {-1, 4};
    for (int k = 0; k < 2; ++k) {
        opt.linear_solver = (mbsr_ida_solver)wrong[k];
        assert_refused(mbsr_ida_create(p.model, p.data, &opt, &ida, &error), &error, MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE,
                       k ? "linear_solver is 4, must be AUTO, DENSE" : "linear_solver is -1");
    }
    opt = solved_by(MBSR_IDA_KRYLOV, 1e-6);
    opt.krylov_size = 0;
    assert_refused(mbsr_ida_create(p.model, p.data, &opt, &ida, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "krylov_size is 0, must be positive");
    /* those of the Newton solver say so themselves; a dense matrix does not read them */
    for (int s = MBSR_IDA_AUTO; s <= MBSR_IDA_KRYLOV; ++s) {
        opt = solved_by((mbsr_ida_solver)s, 1e-6);
        opt.newton.cookie = 0;
        const int status = mbsr_ida_create(p.model, p.data, &opt, &ida, &error);
        if (s == MBSR_IDA_DENSE) {
            assert_ok(status, &error);
            mbsr_ida_destroy(ida);
        } else {
            assert_refused(status, &error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "_create");
            assert_null(ida);
        }
    }
    problem_free(&p);
}

/* Two runs of one driver: the counters begin anew, those of the Newton solver go on. */
static void statistics_agree_with_ida_and_the_newton_solver(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    double y[6], yp[6];
    problem_in_form(&p, MBSR_DAE_MOMENTUM, y, yp);
    for (int s = MBSR_IDA_DENSE; s <= MBSR_IDA_KRYLOV; ++s) {
        const mbsr_ida_opt opt = solved_by((mbsr_ida_solver)s, 1e-6);
        mbsr_ida *ida = NULL;
        mbsr_newton_info info = {0};
        long jacobians, factorisations, solves, inside, quotients, before[2] = {0, 0};
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        void *const memory = mbsr_ida_memory(ida);
        for (int again = 0; again < 2; ++again) {
            assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
            assert_ok(mbsr_ida_advance(ida, 3.0, NULL, NULL, NULL), mbsr_ida_error(ida));
            const mbsr_ida_stats stats = problem_stats(ida);
            if (mbsr_ida_newton(ida)) mbsr_newton_get_info(mbsr_ida_newton(ida), &info);
            assert_int_equal(IDAGetNumJacEvals(memory, &jacobians), IDA_SUCCESS);
            assert_int_equal(IDAGetNumPrecEvals(memory, &factorisations), IDA_SUCCESS);
            assert_int_equal(IDAGetNumPrecSolves(memory, &solves), IDA_SUCCESS);
            assert_int_equal(IDAGetNumLinIters(memory, &inside), IDA_SUCCESS);
            assert_int_equal(IDAGetNumLinResEvals(memory, &quotients), IDA_SUCCESS);
            const bool krylov = s == MBSR_IDA_KRYLOV;
            assert_true(stats.factorisations > 0 && stats.factorisations < stats.steps);
            assert_int_equal(stats.jacobians, jacobians);
            assert_int_equal(stats.factorisations, krylov ? factorisations : jacobians);
            assert_int_equal(stats.solves, krylov ? solves
                                                  : stats.newton_iterations + stats.filter_solves +
                                                        stats.renewals);
            assert_int_equal(stats.renewals > 0, s == MBSR_IDA_TREE);
            assert_int_equal(stats.krylov_iterations, krylov ? inside : 0);
            assert_int_equal(stats.jacobian_residuals, quotients);
            assert_int_equal(quotients > 0, s != MBSR_IDA_TREE);
            if (s == MBSR_IDA_DENSE) continue;
            assert_int_equal(info.factorisations - before[0], stats.factorisations);
            assert_int_equal(info.solves - before[1], stats.solves);
            before[0] = info.factorisations;
            before[1] = info.solves;
        }
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* ---- models that newton.h does not serve ---- */

/* Slides along a line; the pose of the first has its place twice. */
static int own_position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0] + (args->pred_d > 0 ? args->p_pred[0] : 0.0);
    if (args->np > 1) p[1] = p[0];
    return 0;
}

static int own_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K;
    (void)kI;
    if (args->pred_d > 0) H[0] = -1.0;
    J[0] = -1.0;
    return 0;
}

static int own_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args;
    (void)kII;
    return 0;
}

static int own_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)args;
    (void)Kdot;
    (void)Hdot;
    (void)Jdot;
    return 0;
}

static void rates_by_differences_behind_a_general_pose_need_a_matrix(void **state)
{
    (void)state;
    const mbsr_joint_table with_rates = {.version = MBSR_JOINT_TABLE_VERSION,
                                         .flags = MBSR_JOINT_UNIT_K,
                                         .name = "own",
                                         .position = own_position,
                                         .jacobians = own_jacobians,
                                         .bias = own_bias,
                                         .rates = own_rates};
    mbsr_joint_table without = with_rates;
    without.rates = NULL;
    const double mass = 1.0, q[2] = {0.0, 0.0}, u[2] = {0.5, 0.25};
    mbsr_joint first = mbsr_joint_custom(&with_rates, 1, 1, NULL);
    first.np = 2;
    mbsr_model *m = run_model();
    const int body = run_body(m, "first", MBSR_GROUND, first, mbsr_inertia_matrix(1, &mass));
    run_body(m, "slide", body, mbsr_joint_custom(&without, 1, 1, NULL),
             mbsr_inertia_matrix(1, &mass));
    run_finish(m);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    double y[6], yp[6];
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int s = MBSR_IDA_TREE; s <= MBSR_IDA_KRYLOV; ++s) {
        const mbsr_ida_opt opt = solved_by((mbsr_ida_solver)s, 1e-6);
        assert_refused(mbsr_ida_create(m, d, &opt, &ida, &error), &error, MBSR_ERR_SPACE, 1,
                       MBSR_NONE, "mbsr_newton_create|'slide'");
        assert_null(ida);
    }
    error = (mbsr_error){0};
    assert_ok(mbsr_ida_create(m, d, NULL, &ida, &error), &error);
    assert_int_equal(error.status, MBSR_OK);
    assert_int_equal(problem_stats(ida).linear_solver, MBSR_IDA_DENSE);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 0.4, NULL, y, NULL), mbsr_ida_error(ida));
    assert_close(y[0], 0.2, 1e-6);
    assert_close(y[1], 0.1, 1e-6);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- failures ---- */

typedef struct refusing {
    double from; /* s: until then no force, and derivatives of no force */
    int code;
    long calls; /* refused */
} refusing;

static int no_force(const mbsr_force_args *args)
{
    (void)args;
    return 0;
}

static int no_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    refusing *r = args->force->user;
    (void)out;
    if (args->t < r->from) return 0;
    ++r->calls;
    return r->code;
}

/* What the element returned comes out, and creeping up to where it fails has an end. */
static void a_failed_factorisation_comes_out_unchanged(void **state)
{
    (void)state;
    static const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                           .name = "refusing",
                                           .evaluate = no_force,
                                           .derivatives = no_derivatives};
    problem p;
    refusing r = {INFINITY, 0, 0};
    const int zero = 0;
    problem_point(&p, MBSR_X, 2.0);
    problem_spring(&p, 0, 8.0, 0.0);
    const mbsr_force_def force = mbsr_force_custom(&table, 1, &zero, &r);
    assert_ok(mbsr_model_add_force(p.model, &force, NULL), mbsr_model_error(p.model));
    p.y[0] = 1.0;
    problem_finish(&p, NULL);
    double y[6], yp[6];
    problem_in_form(&p, MBSR_DAE_MOMENTUM, y, yp);
    const int codes[] = {7, -7, MBSR_NOT_FINITE, MBSR_ERR_SOLVER};
    for (int k = 0; k < 8; ++k) {
        mbsr_ida_opt opt = solved_by(k % 2 ? MBSR_IDA_TREE : MBSR_IDA_KRYLOV, 1e-8);
        opt.initial_step = 1e-6; /* grows, and with it comes one factorisation after the other */
        mbsr_ida *ida = NULL;
        double t = 5.0;
        r = (refusing){1e-4, codes[k / 2], 0};
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        assert_refused(mbsr_ida_advance(ida, 10.0, &t, NULL, NULL), mbsr_ida_error(ida), r.code,
                       MBSR_NONE, 1, "mbsr_ida_advance: Newton equations at t = |force 1|refusing");
        assert_contains(mbsr_ida_error(ida)->text, mbsr_newton_error(mbsr_ida_newton(ida))->text);
        assert_in_range(r.calls, 1, 3000);
        assert_true(t == 5.0);
        assert_int_equal(mbsr_ida_advance(ida, 10.0, &t, NULL, NULL), MBSR_ERR_SEQUENCE);
        r.from = INFINITY;
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 1.0, &t, NULL, NULL), mbsr_ida_error(ida));
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* A point that nothing holds has no start, whatever the solver. */
static void a_start_that_nothing_determines_is_refused(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_undetermined(&p, &observer);
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_MOMENTUM, MBSR_DAE_MOMENTUM,
                                   MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS};
    const double y[3] = {1.0, 0.0, 0.0}, yp[3] = {0.0};
    for (int s = 0; s < 5; ++s) {
        mbsr_ida_opt opt =
            solved_by(s < 3 ? (mbsr_ida_solver)(MBSR_IDA_DENSE + s) : MBSR_IDA_AUTO, 1e-6);
        opt.form = forms[s];
        mbsr_ida *ida = NULL;
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        assert_refused(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida), MBSR_UNDETERMINED, 0,
                       MBSR_NONE,
                       "mbsr_ida_start: u0 of body 0 'point'|moves no mass|inertia, a spring or a "
                       "damper, or lock it|mbsr_index_report_create");
        assert_int_equal(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
        assert_int_equal(mbsr_ida_state(ida, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* A spring and damper while they hold, then a force that nothing resists: no step that goes on from
 * there converges, however short, so that IDA factors its matrix anew. */
static int fade(const mbsr_force_args *args)
{
    const bool *holds = args->force->user;
    const mbsr_force_body *body = args->body;
    body->tau[0] += *holds ? -6.0 * body->q[0] - 2.0 * body->u[0] : 1.0;
    return 0;
}

static const mbsr_force_table fading = {.version = MBSR_FORCE_TABLE_VERSION,
                                        .flags = MBSR_FORCE_JOINT_ONLY,
                                        .name = "fading",
                                        .evaluate = fade};

/* A point that nothing holds any more. What was reached before stays to be had. */
static void a_singular_system_names_its_body(void **state)
{
    (void)state;
    problem p;
    bool holds = true;
    const int body = 0;
    problem_point(&p, MBSR_X, 0.0);
    const mbsr_force_def force = mbsr_force_custom(&fading, 1, &body, &holds);
    assert_ok(mbsr_model_add_force(p.model, &force, NULL), mbsr_model_error(p.model));
    p.y[0] = 1.0;
    problem_finish(&p, NULL);
    double y[3], yp[3], reached[3], t;
    problem_in_form(&p, MBSR_DAE_MOMENTUM, y, yp);
    for (int s = MBSR_IDA_TREE; s <= MBSR_IDA_KRYLOV; ++s) {
        const mbsr_ida_opt opt = solved_by((mbsr_ida_solver)s, 1e-6);
        mbsr_ida *ida = NULL;
        holds = true;
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 0.5, NULL, NULL, NULL), mbsr_ida_error(ida));
        holds = false;
        assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                       MBSR_SINGULAR_BLOCK, 0, MBSR_NONE,
                       "mbsr_ida_advance: Newton equations at t = 0.|'point': joint "
                       "'planar'|inertia, a spring or a damper, or lock it");
        assert_ok(mbsr_ida_state(ida, &t, reached, NULL), mbsr_ida_error(ida));
        assert_close(t, 0.5, 0.05);
        assert_close(reached[0], exp(-3.0 * t), 1e-4);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* The Newton solver takes its memory from the model's allocator. */
static void without_memory_there_is_no_driver(void **state)
{
    (void)state;
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = test_counting_allocator(&counting);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    run_cart(m, "cart", MBSR_GROUND, 1.0);
    run_finish(m);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const long live = counting.live, calls = counting.calls;
    int refused = 0;
    do {
        mbsr_ida *ida = NULL;
        mbsr_error error = {0};
        counting.calls = calls;
        counting.failed = 0;
        counting.fail_at = calls + 1 + refused;
        const int status = mbsr_ida_create(m, d, NULL, &ida, &error);
        if (counting.failed) {
            assert_refused(status, &error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "_create");
            assert_null(ida);
            ++refused;
        } else {
            assert_ok(status, &error);
            assert_true(counting.live > live);
            mbsr_ida_destroy(ida);
        }
        assert_int_equal(counting.live, live);
    } while (counting.failed);
    assert_in_range(refused, 1, 40);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- a large system ---- */

/* 3000 carts on springs, 9000 unknowns: no difference quotients, and no matrix of 650 MB. Their
 * energy stays. */
static void a_long_chain_needs_no_matrix(void **state)
{
    (void)state;
    enum { N = 3000 };
    static double q[N], u[N], y[3 * N], yp[3 * N];
    mbsr_model *m = run_model();
    for (int k = 0; k < N; ++k) {
        const int cart = run_cart(m, NULL, k > 0 ? k - 1 : MBSR_GROUND, 1.0 + k % 3);
        run_force(m, mbsr_force_joint_spring(cart, 0, 100.0, 0.0, 0.0));
        q[k] = sin(0.01 * k);
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    double kinetic, potential, energy[2];
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, NULL, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    double t = 0.0;
    for (int k = 0; k < 2; ++k) {
        if (k > 0) assert_ok(mbsr_ida_advance(ida, 0.5, &t, y, NULL), mbsr_ida_error(ida));
        assert_ok(mbsr_dae_unpack(m, d, MBSR_DAE_MOMENTUM, t, y, q, u), mbsr_data_error(d));
        assert_ok(mbsr_stage_positions(m, d, t, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
        assert_ok(mbsr_energy(m, d, &kinetic, &potential), mbsr_data_error(d));
        energy[k] = kinetic + potential;
    }
    assert_less(1e-3 * energy[0], kinetic);
    assert_close(energy[1] / energy[0], 1.0, 1e-4);
    const mbsr_ida_stats stats = problem_stats(ida);
    print_message("%d unknowns: %ld steps, %ld residuals, %ld factorisations\n", 3 * N, stats.steps,
                  stats.residuals, stats.factorisations);
    assert_int_equal(stats.linear_solver, MBSR_IDA_TREE);
    assert_int_equal(stats.jacobian_residuals, 0);
    assert_true(stats.residuals < 3 * N);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(springs_across_are_corrected_or_iterated),
        cmocka_unit_test(few_vectors_cost_steps),
        cmocka_unit_test(the_tree_alone_is_not_enough_across),
        cmocka_unit_test(the_solver_follows_from_the_form),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(statistics_agree_with_ida_and_the_newton_solver),
        cmocka_unit_test(rates_by_differences_behind_a_general_pose_need_a_matrix),
        cmocka_unit_test(a_failed_factorisation_comes_out_unchanged),
        cmocka_unit_test(a_start_that_nothing_determines_is_refused),
        cmocka_unit_test(a_singular_system_names_its_body),
        cmocka_unit_test(without_memory_there_is_no_driver),
        cmocka_unit_test(a_long_chain_needs_no_matrix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
