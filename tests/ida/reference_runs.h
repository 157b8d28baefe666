/* Building models and integrating them from the library's own start, for the reference problems.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_REFERENCE_RUNS_H
#define TEST_REFERENCE_RUNS_H

#include "duration.h"
#include "expect.h"

#include <mbsrank/ida.h>

enum { RUN_MOST = 40 }; /* coordinates of the largest model */

static const mbsr_planar_frame run_origin = {0.0, 0.0, 0.0};

static const mbsr_dae_form run_forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                          MBSR_DAE_INVERSE_DYNAMICS, MBSR_DAE_INDEX1};
enum { RUN_FORMS = 4 };

static inline const char *run_form_name(mbsr_dae_form form)
{
    static const char *const name[] = {"momentum", "recursive", "inverse dynamics", "index 1"};
    return name[form];
}

/* ---- models ---- */

static inline mbsr_model *run_model(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static inline int run_body(mbsr_model *m, const char *name, int parent, mbsr_joint joint,
                           mbsr_inertia inertia)
{
    int id = MBSR_NONE;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static inline void run_force(mbsr_model *m, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

static inline mbsr_model *run_finish(mbsr_model *m)
{
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_in_range(mbsr_model_nq(m), 1, RUN_MOST);
    assert_in_range(mbsr_model_nu(m), 1, RUN_MOST);
    return m;
}

/* A body that moves on the x axis relative to its predecessor; without mass for mass = 0. */
static inline int run_cart(mbsr_model *m, const char *name, int parent, double mass)
{
    return run_body(m, name, parent, mbsr_joint_point(run_origin, MBSR_X, 0, NULL, NULL),
                    mass > 0.0 ? mbsr_inertia_particle(mass) : mbsr_inertia_zero());
}

/* ---- integration ---- */

typedef struct run_state {
    double t;
    double q[RUN_MOST], u[RUN_MOST];
} run_state;

typedef struct run {
    const char *name;
    const mbsr_model *model;
    mbsr_dae_form form;
    double tolerance; /* rtol and atol */
    double max_step;  /* 0: none */
    double T;
    int points;                /* outputs at T / points, 2 T / points, ..., T */
    const double *q, *u;       /* the start, made consistent by the library; NULL: zero, which is
                                  no state of a joint with a quaternion */
    mbsr_consistent_info info; /* result */
    mbsr_ida_stats stats;      /* result */
} run;

/* The library's consistent start from r->q, r->u at t = 0; state[0]. */
static inline void run_consistent(run *r, mbsr_data *d, double *y, double *yp, run_state *state)
{
    static const double zero[RUN_MOST] = {0.0};
    assert_ok(mbsr_dae_pack(r->model, d, r->form, 0.0, r->q ? r->q : zero, r->u ? r->u : zero, y),
              mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(r->model, d, r->form, 0.0, y, yp, NULL, &r->info),
              mbsr_data_error(d));
    state[0].t = 0.0;
    assert_ok(mbsr_dae_unpack(r->model, d, r->form, 0.0, y, state[0].q, state[0].u),
              mbsr_data_error(d));
}

/* Integrates; state gets points + 1 entries, the consistent start first; it may be NULL. */
static inline void run_with(run *r, mbsr_ida_solver solver, bool renew, run_state *state)
{
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    run_state unwanted;
    double y[3 * RUN_MOST], yp[3 * RUN_MOST];
    assert_ok(mbsr_data_create(r->model, &d, NULL), NULL);
    run_consistent(r, d, y, yp, state ? state : &unwanted);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = r->form;
    opt.rtol = opt.atol = r->tolerance;
    opt.max_step = r->max_step;
    opt.linear_solver = solver;
    opt.renew_matrices = renew;
    opt.raw_outputs = !state; /* nobody looks at them */
    assert_ok(mbsr_ida_create(r->model, d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    for (int k = 1; k <= r->points; ++k) {
        run_state *s = state ? state + k : &unwanted;
        assert_ok(mbsr_ida_advance(ida, r->T * k / r->points, &s->t, y, NULL), mbsr_ida_error(ida));
        assert_ok(mbsr_dae_unpack(r->model, d, r->form, s->t, y, s->q, s->u), mbsr_data_error(d));
    }
    assert_int_equal(mbsr_ida_get_stats(ida, &r->stats), MBSR_OK);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
}

static inline void run_integrate(run *r, run_state *state)
{
    run_with(r, MBSR_IDA_AUTO, true, state);
}

/* ---- the tree solver against a dense matrix ---- */

/* Steps and iterations of runs with a dense matrix, with the tree solver whose matrices live as
 * long, and with one that renews them, added up: rounding decides between steps, so that those of
 * one run scatter, mostly by 1 to 3 %, at times by 20 %. */
enum { RUN_DENSE, RUN_TREE, RUN_RENEWED, RUN_KINDS };
typedef struct run_counts {
    long steps[RUN_KINDS], iterations[RUN_KINDS], factorisations[RUN_KINDS];
} run_counts;

enum { RUN_MOST_REPEATS = 16 };
#define RUN_REPEATS test_seeds(4, RUN_MOST_REPEATS)
static const mbsr_ida_solver run_solvers[RUN_KINDS] = {MBSR_IDA_DENSE, MBSR_IDA_AUTO,
                                                       MBSR_IDA_AUTO};

/* The tolerance of repetition k. */
static inline double run_tolerance(double tolerance, int k)
{
    return tolerance * (1.0 + 0.02 * k);
}

static inline void run_count(run_counts *counts, int kind, const mbsr_ida_stats *stats)
{
    assert_int_equal(stats->linear_solver, kind == RUN_DENSE ? MBSR_IDA_DENSE : MBSR_IDA_TREE);
    assert_true(kind == RUN_RENEWED || stats->renewals == 0);
    counts->steps[kind] += stats->steps;
    counts->iterations[kind] += stats->newton_iterations;
    counts->factorisations[kind] += stats->factorisations;
}

/* Fails unless the first two agree within 5 %, or by as much more as the mean of fewer repetitions
 * scatters, and renewed matrices take no more than a fifth more: errors that are not hidden in what
 * an old matrix leaves are tested as larger ones, and results are more accurate. */
static inline void run_assert_like_dense(const char *name, const run_counts *counts)
{
    const double steps = (double)counts->steps[1] / (double)counts->steps[0],
                 iterations = (double)counts->iterations[1] / (double)counts->iterations[0];
    print_message(
        "%s: dense %ld steps %ld iterations %ld factorisations, tree %ld %ld %ld, renewed "
        "%ld %ld %ld\n",
        name, counts->steps[0], counts->iterations[0], counts->factorisations[0], counts->steps[1],
        counts->iterations[1], counts->factorisations[1], counts->steps[2], counts->iterations[2],
        counts->factorisations[2]);
    const double most = 0.05 * sqrt((double)RUN_MOST_REPEATS / RUN_REPEATS);
    assert_close(steps, 1.0, most);
    assert_close(iterations, 1.0, most);
    assert_less((double)counts->steps[RUN_RENEWED], 1.2 * (double)counts->steps[RUN_DENSE]);
    assert_less((double)counts->iterations[RUN_RENEWED],
                1.2 * (double)counts->iterations[RUN_DENSE]);
}

/* In the momentum form, from r->tolerance up. */
static inline void run_compare(const run *r, int repeats)
{
    run_counts counts = {{0}, {0}, {0}};
    for (int k = 0; k < repeats; ++k) {
        for (int kind = 0; kind < RUN_KINDS; ++kind) {
            run one = *r;
            one.form = MBSR_DAE_MOMENTUM;
            one.tolerance = run_tolerance(r->tolerance, k);
            run_with(&one, run_solvers[kind], kind == RUN_RENEWED, NULL);
            run_count(&counts, kind, &one.stats);
        }
    }
    run_assert_like_dense(r->name, &counts);
}

/* The larger of two; NaN stays. */
static inline double run_larger(double a, double b)
{
    return b > a || b != b ? b : a;
}

static inline void run_report(const run *r, double error)
{
    print_message("%s, %s, tolerance %.0e: error %.1e, %ld steps\n", r->name,
                  run_form_name(r->form), r->tolerance, error, r->stats.steps);
}

#endif
