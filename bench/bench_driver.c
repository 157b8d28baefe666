/* The IDA driver as it is, with IDA's own Newton's method and error test instead, and with stiff
 * springs written as stiff closures: steps, evaluations, factorisations, CPU time, error, energy.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_driver [cells|mechanisms|ordinary|all|grid [runs [name [k]]]]      CSV on standard output
 *
 * cells: the slider-crank of mechanisms.h at k = 1e6 .. 1e14 N/m, damping ratios 0.3, 1, 10 and
 * tolerances 1e-3 .. 1e-8, by the tree and dense. mechanisms: the others, some of these cells.
 * grid: all of them, in more cells, by the library alone. ordinary: problems without stiff loops,
 * and the stiff trees of runs/stiff.h; lines that begin with # compare what the driver costs with
 * what IDA's own Newton's method does at the same error.
 *
 * Each line is a mean over `runs` (default 4) at tolerances that differ by 2 %, because rounding
 * decides between steps; the error, largest of q at the end, is the root of their mean square, the
 * energy gained (J, at ends of steps, over the start's) the largest. A run of 30 000 steps is given
 * up. References: stiff closures at 1e-10 or 1e-9, another formulation, for what is closed by
 * springs; IDA's own at 1e-10 for the others. */
#include "bench.h"
#include "mechanisms.h"
#include "ordinary.h"
#include "runs/build.h"
#include "work.h"

#include <mbsrank/ida.h>

#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <ida/ida.h>
#include <stdbool.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_STEPS = 30000, RUNS_MOST = 64 };

/* ---- a problem ---- */

typedef struct problem {
    const char *name;
    double stiffness, ratio, T;
    mbsr_model *model, *closed; /* by force elements; by stiff closures, or NULL */
    mbsr_data *data, *closed_data, *energy_data;
    double *q, *u, *atol; /* start; tolerances at a tolerance of 1, or NULL */
    double *reference;    /* q at the end */
    double energy;
    int conserve;
    stiff_model stiff;
} problem;

/* ---- IDA's own Newton's method in the place of the driver's ---- */

typedef struct plain {
    SUNContext context;
    N_Vector vector;
    SUNNonlinearSolver newton;
} plain;

static void use_plain(plain *p, mbsr_ida *ida, int size)
{
    bench_check(SUNContext_Create(0, &p->context), "SUNContext_Create", NULL);
    p->vector = N_VNew_Serial(size, p->context);
    p->newton = SUNNonlinSol_Newton(p->vector, p->context);
    bench_check(IDASetNonlinearSolver(mbsr_ida_memory(ida), p->newton), "IDASetNonlinearSolver",
                NULL);
}

static void drop_plain(plain *p)
{
    if (!p->context) return;
    SUNNonlinSolFree(p->newton);
    N_VDestroy(p->vector);
    SUNContext_Free(&p->context);
}

/* ---- a run ---- */

typedef enum driver { LIBRARY, PLAIN, CLOSURES } driver;
static const char *const driver_name[] = {"library", "plain", "closures"};

typedef struct outcome {
    int status;
    mbsr_ida_stats stats;
    double seconds, error, gained;
} outcome;

static double energy(const problem *p, double t, const double *y)
{
    double q[3 * ORDINARY_MOST], u[3 * ORDINARY_MOST], kinetic, potential;
    const mbsr_model *m = p->model;
    mbsr_data *d = p->energy_data;
    bench_check(mbsr_dae_unpack(m, d, MBSR_DAE_MOMENTUM, t, y, q, u), "energy", NULL);
    bench_check(mbsr_stage_positions(m, d, t, q), "energy", NULL);
    bench_check(mbsr_stage_velocities(m, d, u), "energy", NULL);
    bench_check(mbsr_energy(m, d, &kinetic, &potential), "energy", NULL);
    return kinetic + potential;
}

typedef struct watch {
    const problem *problem;
    mbsr_ida *ida;
    double most;
} watch;

static int look(void *user, const mbsr_ida_progress *now)
{
    watch *w = user;
    double y[3 * ORDINARY_MOST];
    bench_check(mbsr_ida_dense(w->ida, now->t, 0, y), "energy", NULL);
    w->most = fmax(w->most, energy(w->problem, now->t, y) - w->problem->energy);
    return 0;
}

/* Integrates from p's start; y: mbsr_dae_size numbers, the state at the end. */
static outcome integrate(problem *p, driver how, mbsr_ida_solver solver, double tolerance,
                         long most, int watched, double *y)
{
    const mbsr_model *m = how == CLOSURES ? p->closed : p->model;
    mbsr_data *d = how == CLOSURES ? p->closed_data : p->data;
    const int n = mbsr_dae_size(m, MBSR_DAE_MOMENTUM), nq = mbsr_model_nq(m);
    outcome result = {.error = p->reference ? 0.0 : NAN};
    watch w = {.problem = p};
    plain own = {0};
    mbsr_error error;
    double *yp = bench_allocate((size_t)n, sizeof *yp),
           *atol = bench_allocate((size_t)n, sizeof *atol);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    opt.linear_solver = solver;
    opt.max_steps = most;
    if (watched) opt.progress = look, opt.progress_user = &w;
    for (int k = 0; p->atol && k < n; ++k) atol[k] = tolerance * p->atol[k];
    if (p->atol) opt.atol_each = atol;
    bench_check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, p->q, p->u, y), "pack", NULL);
    bench_check(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), p->name,
                mbsr_data_error(d)->text);
    if (watched) p->energy = energy(p, 0.0, y);
    bench_check(mbsr_ida_create(m, d, &opt, &w.ida, &error), "driver", error.text);
    if (how == PLAIN) use_plain(&own, w.ida, n);
    bench_check(mbsr_ida_start(w.ida, 0.0, y, yp), "start", mbsr_ida_error(w.ida)->text);
    const double begin = bench_now();
    result.status = mbsr_ida_advance(w.ida, p->T, NULL, y, NULL);
    result.seconds = bench_now() - begin;
    result.gained = w.most;
    for (int k = 0; p->reference && k < nq; ++k)
        result.error = fmax(result.error, fabs(y[k] - p->reference[k]));
    bench_check(mbsr_ida_get_stats(w.ida, &result.stats), "statistics", NULL);
    mbsr_ida_destroy(w.ida);
    drop_plain(&own);
    free(yp);
    free(atol);
    return result;
}

static double *room(const problem *p)
{
    const int n = mbsr_dae_size(p->model, MBSR_DAE_MOMENTUM),
              c = p->closed ? mbsr_dae_size(p->closed, MBSR_DAE_MOMENTUM) : 0;
    return bench_allocate((size_t)(n > c ? n : c), sizeof(double));
}

/* At 1e-10; where rounding lets that not come to its end, as with 1e12 N/m, at 1e-9. Of stiff
 * springs that cannot be closures, IDA's own with dense matrices: by the tree it ends a knee on its
 * stop 0.05 rad off. */
static void find_reference(problem *p)
{
    enum { TOO_MANY = 10000 };
    const driver how = p->closed ? CLOSURES : PLAIN;
    const mbsr_ida_solver solver = p->stiffness > 0.0 ? MBSR_IDA_DENSE : MBSR_IDA_AUTO;
    double *y = room(p);
    outcome o = integrate(p, how, solver, 1e-10, p->closed ? TOO_MANY : 1000000, 0, y);
    if (o.status && p->closed) {
        printf("# %s, %g N/m, %g: reference at 1e-9\n", p->name, p->stiffness, p->ratio);
        o = integrate(p, how, solver, 1e-9, 1000000, 0, y);
    }
    if (o.status) {
        printf("# %s, %g N/m, %g: no reference: %s\n", p->name, p->stiffness, p->ratio,
               mbsr_status_name(o.status));
        free(y);
        y = NULL;
    }
    p->reference = y;
}

/* ---- lines ---- */

static const char *solver_name(mbsr_ida_solver solver)
{
    return solver == MBSR_IDA_DENSE ? "dense" : solver == MBSR_IDA_TREE ? "tree" : "krylov";
}

static void head(void)
{
    printf("problem,k,ratio,solver,driver,tolerance,runs,ended,status,steps,residuals,"
           "jacobian_residuals,newton_iterations,factorisations,solves,newton_failures,"
           "error_test_failures,stiff_tests,careful_attempts,cpu_s,error,gained\n");
}

/* The mean of `runs`; false if one was given up. w: NULL, or gets it. */
static bool line(problem *p, driver how, mbsr_ida_solver solver, double tolerance, int runs,
                 work *w)
{
    double *y = room(p), sum[11] = {0.0}, square = 0.0, gained = 0.0;
    int ended = 0, status = MBSR_OK;
    mbsr_ida_solver used = solver;
    for (int r = 0; r < runs; ++r) {
        const double at = tolerance * (1.0 + 0.02 * r);
        outcome o = integrate(p, how, solver, at, MOST_STEPS, 0, y);
        const mbsr_ida_stats *s = &o.stats;
        const double count[11] = {(double)s->steps,
                                  (double)s->residuals,
                                  (double)s->jacobian_residuals,
                                  (double)s->newton_iterations,
                                  (double)s->factorisations,
                                  (double)s->solves,
                                  (double)s->newton_failures,
                                  (double)s->error_test_failures,
                                  (double)s->stiff_tests,
                                  (double)s->careful_attempts,
                                  o.seconds};
        for (int k = 0; k < 11; ++k) sum[k] += count[k] / runs;
        square += o.error * o.error / runs;
        ended += o.status == MBSR_OK;
        if (o.status) status = o.status;
        used = s->linear_solver;
        if (p->conserve && how != CLOSURES && !o.status)
            gained = fmax(gained, integrate(p, how, solver, at, MOST_STEPS, 1, y).gained);
    }
    printf("%s,%g,%g,%s,%s,%g,%d,%d,%s", p->name, p->stiffness, p->ratio, solver_name(used),
           driver_name[how], tolerance, runs, ended, mbsr_status_name(status));
    for (int k = 0; k < 10; ++k) printf(",%.1f", sum[k]);
    printf(",%.5f,%.3e,%.1e\n", sum[10], sqrt(square), gained);
    fflush(stdout);
    free(y);
    const double cost[WORK_COSTS] = {sum[10], sum[1], sum[4], sum[5], sum[0]};
    if (w && p->reference && status == MBSR_OK) work_add(w, sqrt(square), cost);
    return status == MBSR_OK;
}

/* ---- problems ---- */

static mbsr_data *data_of(const mbsr_model *m)
{
    mbsr_data *d = NULL;
    bench_check(mbsr_data_create(m, &d, NULL), "mbsr_data_create", NULL);
    return d;
}

static mbsr_model *build_mechanism(const mechanism *of, mechanism_ties ties, double *q, double *u)
{
    mbsr_model *m = NULL;
    bench_check(mbsr_model_create(NULL, &m, NULL), "mbsr_model_create", NULL);
    of->build(m, &ties, q, u);
    bench_check(mbsr_model_finish(m), of->name, mbsr_model_error(m)->text);
    return m;
}

/* Rigid closures close the loops of the start. */
static void close_start(const mechanism *of, double *q, double *u)
{
    double y[6 * MECHANISM_MOST], yp[6 * MECHANISM_MOST];
    const mechanism_ties rigid = {0.0, 0.0, 1};
    mbsr_model *m = build_mechanism(of, rigid, q, u);
    if (mbsr_model_rows(m) == 0) { /* the start is closed as it is */
        mbsr_model_destroy(m);
        return;
    }
    mbsr_data *d = data_of(m);
    bench_check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), "pack", NULL);
    bench_check(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), of->name,
                mbsr_data_error(d)->text);
    bench_check(mbsr_dae_unpack(m, d, MBSR_DAE_MOMENTUM, 0.0, y, q, u), "unpack", NULL);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Whether the start of p is one of the model m, too. */
static bool starts(const problem *p, const mbsr_model *m, mbsr_data *d)
{
    double y[6 * MECHANISM_MOST], yp[6 * MECHANISM_MOST];
    bench_check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, p->q, p->u, y), "pack", NULL);
    if (!mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL)) return true;
    printf("# %s: no stiff closures: %s\n", p->name, mbsr_data_error(d)->text);
    return false;
}

static problem open_mechanism(const mechanism *of, double stiffness, double ratio)
{
    problem p = {.name = of->name, .stiffness = stiffness, .ratio = ratio, .T = of->T};
    double unused[2 * MECHANISM_MOST];
    mechanism_ties ties = {stiffness, 2.0 * ratio * sqrt(of->mass * stiffness), 0};
    p.conserve = of->conserve;
    p.q = bench_allocate(2 * MECHANISM_MOST, sizeof(double));
    p.u = bench_allocate(2 * MECHANISM_MOST, sizeof(double));
    close_start(of, p.q, p.u);
    p.model = build_mechanism(of, ties, unused, unused + MECHANISM_MOST);
    ties.closures = 1;
    p.closed = build_mechanism(of, ties, unused, unused + MECHANISM_MOST);
    p.data = data_of(p.model);
    p.energy_data = data_of(p.model);
    p.closed_data = data_of(p.closed);
    if (mbsr_model_rows(p.closed) == 0 || !starts(&p, p.closed, p.closed_data)) {
        mbsr_data_destroy(p.closed_data);
        mbsr_model_destroy(p.closed);
        p.closed = NULL;
        p.closed_data = NULL;
    }
    find_reference(&p);
    return p;
}

static void destroy(problem *p)
{
    mbsr_data_destroy(p->data);
    mbsr_data_destroy(p->energy_data);
    mbsr_data_destroy(p->closed_data);
    mbsr_model_destroy(p->model);
    mbsr_model_destroy(p->closed);
    double *const owned[] = {p->q, p->u, p->atol, p->reference};
    for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) free(owned[k]);
    stiff_free(&p->stiff);
}

static problem open_ordinary(const ordinary *of)
{
    problem p = {.name = of->name, .T = of->T};
    p.q = bench_allocate(ORDINARY_MOST, sizeof(double));
    p.u = bench_allocate(ORDINARY_MOST, sizeof(double));
    bench_check(mbsr_model_create(NULL, &p.model, NULL), "mbsr_model_create", NULL);
    of->build(p.model, p.q, p.u);
    bench_check(mbsr_model_finish(p.model), of->name, mbsr_model_error(p.model)->text);
    p.data = data_of(p.model);
    find_reference(&p);
    return p;
}

typedef struct tree {
    const char *name;
    void (*make)(stiff_model *s, int n);
    int n;
} tree;

static void vehicle(stiff_model *s, int n)
{
    (void)n;
    stiff_vehicle(s);
}

/* The start of the description; in chains the tolerances of build_tolerances. */
static problem open_tree(const tree *of)
{
    problem p = {.name = of->name};
    of->make(&p.stiff, of->n);
    p.T = p.stiff.T;
    p.model = build_model(&p.stiff, 1, 0.0);
    p.data = data_of(p.model);
    const int n = mbsr_dae_size(p.model, MBSR_DAE_MOMENTUM), nq = mbsr_model_nq(p.model);
    double *y = bench_allocate((size_t)n, sizeof *y), *yp = bench_allocate((size_t)n, sizeof *yp);
    p.q = bench_allocate((size_t)nq, sizeof(double));
    p.u = bench_allocate((size_t)nq, sizeof(double));
    build_start(&p.stiff, p.model, p.data, y, yp);
    bench_check(mbsr_dae_unpack(p.model, p.data, MBSR_DAE_MOMENTUM, 0.0, y, p.q, p.u), "unpack",
                NULL);
    if (p.stiff.chain) {
        p.atol = bench_allocate((size_t)n, sizeof(double));
        build_tolerances(&p.stiff, p.model, 1.0, p.atol);
    }
    free(y);
    free(yp);
    find_reference(&p);
    return p;
}

/* ---- what is asked for ---- */

static bool wanted(const char *what, const char *group, const char *only, const char *name)
{
    if (strcmp(what, "all") != 0 && strcmp(what, group) != 0) return false;
    return !only || strcmp(only, name) == 0;
}

/* Plain IDA is stuck in most cells: one run tells as much as many. */
static void run_cells(const mechanism *of, int every, int runs, double only)
{
    static const double stiffness[] = {1e6, 1e8, 1e10, 1e12, 1e14}, ratio[] = {0.3, 1.0, 10.0};
    for (int k = 0; k < 5; ++k) {
        for (int z = 0; z < 3 && (only == 0.0 || only == stiffness[k]); z += every) {
            problem p = open_mechanism(of, stiffness[k], ratio[z]);
            bool stuck = false;
            for (int t = 3; t <= 8; t += every) {
                const double tolerance = pow(10.0, -t);
                line(&p, LIBRARY, MBSR_IDA_AUTO, tolerance, runs, NULL);
                if (every == 1) line(&p, LIBRARY, MBSR_IDA_DENSE, tolerance, runs, NULL);
                if (p.closed) line(&p, CLOSURES, MBSR_IDA_DENSE, tolerance, runs, NULL);
                if (!stuck) stuck = !line(&p, PLAIN, MBSR_IDA_AUTO, tolerance, 1, NULL);
            }
            destroy(&p);
        }
    }
}

/* All cells by the library alone. */
static void run_grid(const mechanism *of, int runs)
{
    static const double ratio[] = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0};
    for (int k = 6; k <= 14; ++k) {
        for (int z = 0; z < 6; ++z) {
            problem p = open_mechanism(of, pow(10.0, k), ratio[z]);
            for (int t = 3; t <= 8; ++t) {
                line(&p, LIBRARY, MBSR_IDA_AUTO, pow(10.0, -t), runs, NULL);
                line(&p, LIBRARY, MBSR_IDA_DENSE, pow(10.0, -t), runs, NULL);
            }
            destroy(&p);
        }
    }
}

/* What the library's way costs over plain IDA, in all problems so far: [AUTO, DENSE]. */
typedef struct total {
    int problems[WORK_COSTS];
    double log_sum[WORK_COSTS];
} total;

static void print_ratio(const char *name, int dense, const work *library, const work *own,
                        total *all)
{
    printf("# %s, %s, library over plain at equal tolerance (at equal error):", name,
           dense ? "dense" : "auto");
    for (int c = 0; c < WORK_COSTS; ++c) {
        const double ratio = work_ratio(library, own, c);
        printf(" %s %.2f (%.2f)", work_cost_name[c], work_ratio_of_sums(library, own, c), ratio);
        if (!(ratio > 0.0)) continue;
        ++all->problems[c];
        all->log_sum[c] += log(ratio);
    }
    printf("\n");
}

static void compare(problem p, int runs, total all[2])
{
    const bool small = mbsr_model_nu(p.model) < 50;
    for (int dense = 0; dense <= small; ++dense) {
        const mbsr_ida_solver solver = dense ? MBSR_IDA_DENSE : MBSR_IDA_AUTO;
        work library = {0}, own = {0};
        for (int t = 3; t <= 9; ++t) {
            line(&p, LIBRARY, solver, pow(10.0, -t), runs, &library);
            line(&p, PLAIN, solver, pow(10.0, -t), runs, &own);
        }
        print_ratio(p.name, dense, &library, &own, all + dense);
    }
    destroy(&p);
}

static void print_totals(const total all[2])
{
    for (int dense = 0; dense < 2; ++dense) {
        printf("# all, %s, at equal error, geometric mean:", dense ? "dense" : "auto");
        for (int c = 0; c < WORK_COSTS; ++c)
            printf(" %s %.2f", work_cost_name[c],
                   exp(all[dense].log_sum[c] / fmax(1.0, all[dense].problems[c])));
        printf("\n");
    }
}

static void run_mechanisms(const mechanism *table, const char *what, const char *only, int runs,
                           double stiffness)
{
    for (const mechanism *m = table; m->name; ++m) {
        const bool first = m == mechanisms;
        if (wanted(what, first ? "cells" : "mechanisms", only, m->name))
            run_cells(m, first ? 1 : 2, runs, stiffness);
        if (strcmp(what, "grid") == 0 && wanted(what, what, only, m->name)) run_grid(m, runs);
    }
}

int main(int argc, char **argv)
{
    static const tree trees[] = {{"beam", stiff_beam, 40},
                                 {"cable", stiff_cable, 40},
                                 {"tree", stiff_tree, 100},
                                 {"vehicle", vehicle, 55}};
    const char *what = argc > 1 ? argv[1] : "all", *only = argc > 3 ? argv[3] : NULL;
    const int runs = argc > 2 ? atoi(argv[2]) : 4;
    const double stiffness = argc > 4 ? atof(argv[4]) : 0.0; /* of cells and mechanisms; 0: all */
    total all[2] = {0};
    if (runs < 1 || runs > RUNS_MOST) {
        fprintf(stderr,
                "usage: bench_driver [cells|mechanisms|ordinary|all|grid [runs [name [k]]]]\n");
        return EXIT_FAILURE;
    }
    bench_header(stdout, "libmbsrank: the IDA driver, plain IDA, stiff closures; rtol = atol");
    head();
    run_mechanisms(mechanisms, what, only, runs, stiffness);
    run_mechanisms(mechanisms_more, what, only, runs, stiffness);
    for (const ordinary *o = ordinary_problems; o->name; ++o)
        if (wanted(what, "ordinary", only, o->name)) compare(open_ordinary(o), runs, all);
    for (size_t k = 0; k < sizeof trees / sizeof trees[0]; ++k)
        if (wanted(what, "ordinary", only, trees[k].name)) compare(open_tree(trees + k), runs, all);
    if (wanted(what, "ordinary", NULL, "")) print_totals(all);
    return EXIT_SUCCESS;
}
