/* Whole runs of stiff trees with parts without mass (runs/stiff.h) in the IDA driver: the linear
 * systems of Newton's method solved on the tree, by GMRES, by a dense matrix of SUNDIALS and of
 * LAPACK, by KLU.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_newton folder [largest number of bodies]      CSV on standard output
 *
 * The error is the largest distance, in m, of a body's origin at the end from where it is in a run
 * with a far smaller tolerance. These places go to a file of the folder for each model, with the
 * error to be reached by programs of other libraries: about that of the tree solver at the first
 * tolerance, as a number that no processor changes. */
#include "bench.h"
#include "runs/build.h"
#include "runs/lapack.h"
#include "runs/sparse.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 100, MOST_STEPS = 200000 };

enum { TREE = 1, KRYLOV = 2, DENSE = 4, LAPACK = 8, SPARSE = 16, SOLVERS = 5 };
static const char *const solver_name[SOLVERS] = {"tree", "krylov", "dense", "lapack", "klu"};

static const double tolerances[] = {1e-4, 1e-6}; /* the second with the tree solver only */

static void beam_in_space(stiff_model *s, int n)
{
    stiff_beam(s, n);
    s->in_plane = 0;
    snprintf(s->name, sizeof s->name, "beam_in_space");
}

static void vehicle(stiff_model *s, int n)
{
    (void)n;
    stiff_vehicle(s);
}

/* Dense up to about 1200 unknowns: one of its Jacobians costs as many residuals. */
static const struct plan {
    void (*make)(stiff_model *s, int n);
    int n, solvers;
    double reference; /* tolerance */
    double target;    /* m, error to be compared at; 0: by nobody */
} plans[] = {
    {stiff_beam, 40, TREE | DENSE | LAPACK | SPARSE, 1e-8, 3e-4},
    {stiff_beam, 400, TREE | DENSE | LAPACK | SPARSE, 1e-8, 3e-4},
    {stiff_beam, 4000, TREE | SPARSE, 1e-8, 0.0},
    {beam_in_space, 40, TREE | SPARSE, 1e-8, 0.0},
    {beam_in_space, 400, TREE | SPARSE, 1e-8, 0.0},
    {beam_in_space, 4000, TREE | SPARSE, 1e-8, 0.0},
    {stiff_cable, 40, TREE | DENSE | LAPACK | SPARSE, 1e-8, 2.5e-4},
    {stiff_cable, 200, TREE | DENSE | LAPACK | SPARSE, 1e-8, 2.5e-4},
    {stiff_cable, 1000, TREE | SPARSE, 1e-8, 0.0},
    {stiff_cable, 10000, TREE | SPARSE, 1e-7, 0.0},
    {vehicle, 55, TREE | KRYLOV | DENSE | LAPACK, 1e-8, 1.5e-4},
    {stiff_tree, 100, TREE | DENSE | LAPACK | SPARSE, 1e-8, 1.5e-5},
    {stiff_tree, 400, TREE | DENSE | LAPACK | SPARSE, 1e-8, 5e-5},
    {stiff_tree, 1000, TREE | SPARSE, 1e-8, 5e-5},
    {stiff_tree, 10000, TREE | SPARSE, 1e-7, 0.0},
};
enum { PLANS = sizeof plans / sizeof plans[0] };

/* One model with its data, its start, and where the reference ends. */
typedef struct setup {
    stiff_model stiff;
    mbsr_model *model;
    mbsr_data *data;
    int size;
    double *y, *yp, *atol, *places, *reference;
    double start_time; /* s */
} setup;

static void open_setup(setup *s, const struct plan *plan)
{
    plan->make(&s->stiff, plan->n);
    s->model = build_model(&s->stiff, 1, 0.0);
    bench_check(mbsr_data_create(s->model, &s->data, NULL), "mbsr_data_create", NULL);
    s->size = mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
    s->y = bench_allocate((size_t)s->size, sizeof(double));
    s->yp = bench_allocate((size_t)s->size, sizeof(double));
    s->atol = bench_allocate((size_t)s->size, sizeof(double));
    s->places = bench_allocate(3 * (size_t)s->stiff.bodies, sizeof(double));
    s->reference = bench_allocate(3 * (size_t)s->stiff.bodies, sizeof(double));
    const double begin = bench_now();
    build_start(&s->stiff, s->model, s->data, s->y, s->yp);
    s->start_time = bench_now() - begin;
}

static void close_setup(setup *s)
{
    double *const owned[] = {s->y, s->yp, s->atol, s->places, s->reference};
    for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) free(owned[k]);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    stiff_free(&s->stiff);
}

/* ---- a run ------------------------------------------------------------------------------------
 * */

typedef struct run {
    int status;
    mbsr_ida_stats stats;
    long rank;          /* of the tree solver's correction */
    sparse_info sparse; /* of KLU */
    double setup, time; /* s */
    double error;       /* m */
} run;

static mbsr_ida_opt options(setup *s, int solver, double tolerance)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    opt.max_steps = MOST_STEPS;
    if (s->stiff.chain) {
        build_tolerances(&s->stiff, s->model, tolerance, s->atol);
        opt.atol_each = s->atol;
    }
    opt.linear_solver = solver == DENSE || solver == LAPACK ? MBSR_IDA_DENSE
                        : solver == KRYLOV                  ? MBSR_IDA_KRYLOV
                                                            : MBSR_IDA_TREE;
    opt.newton.method = solver == KRYLOV ? MBSR_NEWTON_TREE : MBSR_NEWTON_AUTO;
    return opt;
}

/* Output: the places of all bodies, as one who draws them would ask for. */
static int draw(void *user, int index, double t, const double *y, const double *yp)
{
    setup *s = user;
    (void)index, (void)yp;
    build_places(s->model, s->data, t, y, s->places);
    return MBSR_OK;
}

static double distance(const setup *s)
{
    double most = 0.0;
    for (int k = 0; k < s->stiff.bodies; ++k) {
        const double *a = s->places + 3 * k, *b = s->reference + 3 * k;
        most = fmax(most, sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                               (a[2] - b[2]) * (a[2] - b[2])));
    }
    return most;
}

/* Integrates; the places at the end are in s->places. Without KLU sparse.entries is 0, and nothing
 * is done. */
static run integrate(setup *s, int solver, double tolerance)
{
    run r = {.status = MBSR_OK};
    mbsr_ida *ida = NULL;
    sparse *matrix = NULL;
    lapack *dense = NULL;
    mbsr_error error;
    double times[POINTS];
    int next = 0;
    const mbsr_ida_opt opt = options(s, solver, tolerance);
    for (int k = 0; k < POINTS; ++k) times[k] = s->stiff.T * (k + 1) / POINTS;
    const double begin = bench_now();
    bench_check(mbsr_ida_create(s->model, s->data, &opt, &ida, &error), "driver", error.text);
    if (solver == LAPACK) dense = lapack_attach(ida, s->size);
    if (solver == SPARSE) {
        matrix = sparse_open(&s->stiff, s->model, s->data);
        if (!matrix) {
            mbsr_ida_destroy(ida);
            return r;
        }
        sparse_attach(matrix, ida);
    }
    bench_check(mbsr_ida_start(ida, 0.0, s->y, s->yp), "start", mbsr_ida_error(ida)->text);
    r.setup = bench_now() - begin;
    r.status = mbsr_ida_run(ida, POINTS, times, &next, draw, s);
    r.time = bench_now() - begin - r.setup;
    r.error = distance(s);
    bench_check(mbsr_ida_get_stats(ida, &r.stats), "statistics", NULL);
    if (mbsr_ida_newton(ida)) {
        mbsr_newton_info info;
        bench_check(mbsr_newton_get_info(mbsr_ida_newton(ida), &info), "statistics", NULL);
        r.rank = info.rank;
    }
    mbsr_ida_destroy(ida);
    if (matrix) {
        r.sparse = sparse_get_info(matrix);
        r.stats.factorisations = r.sparse.factorisations;
    }
    sparse_destroy(matrix);
    lapack_destroy(dense);
    return r;
}

/* ---- tables -----------------------------------------------------------------------------------
 * */

static void report(const setup *s, int which, double tolerance, const run *r)
{
    const mbsr_ida_stats *c = &r->stats;
    const int n = s->stiff.bodies;
    if (1 << which == SPARSE && r->sparse.entries == 0) {
        printf("# %s %d: no KLU\n", s->stiff.name, n);
        return;
    }
    const double step = c->steps > 0 ? 1e6 * r->time / (double)c->steps : 0.0;
    printf("%s,%d,%d,%d,%s,%g,%s,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%.3f,%.3f,%.1f,%.3f,",
           s->stiff.name, n, s->stiff.massless, s->size, solver_name[which], tolerance,
           r->status ? mbsr_status_name(r->status) : "ok", c->steps, c->newton_iterations,
           c->newton_failures, c->error_test_failures, c->factorisations, c->residuals,
           c->jacobian_residuals, c->krylov_iterations, r->rank, r->sparse.entries, r->setup,
           r->time, step, step / n);
    printf(r->status ? "\n" : "%.2e\n", r->error);
    fflush(stdout);
}

/* One factorisation and one solution, on the tree and by KLU. */
static void compare(const setup *s)
{
    sparse *matrix = sparse_open(&s->stiff, s->model, s->data);
    if (!matrix) return;
    const sparse_comparison c = sparse_compare(matrix, s->y, s->yp);
    const sparse_info info = sparse_get_info(matrix);
    printf("# %s %d: factor %.1f us, solve %.1f us on the tree; %.1f and %.1f us by KLU (%ld "
           "unknowns, %ld entries, "
           "%ld in the factors); largest difference %.0e\n",
           s->stiff.name, s->stiff.bodies, 1e6 * c.tree_factor, 1e6 * c.tree_solve, 1e6 * c.factor,
           1e6 * c.solve, info.unknowns, info.entries, info.factors, c.difference);
    sparse_destroy(matrix);
}

/* Name, bodies, error to be compared with; then the places. */
static void write_reference(const setup *s, const char *folder, double error)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s_%d.txt", folder, s->stiff.name, s->stiff.bodies);
    FILE *file = fopen(path, "w");
    if (!file) bench_check(MBSR_ERR_VALUE, "cannot write", path);
    fprintf(file, "%.17g\n", error);
    for (int k = 0; k < s->stiff.bodies; ++k)
        fprintf(file, "%.17g %.17g %.17g\n", s->reference[3 * k], s->reference[3 * k + 1],
                s->reference[3 * k + 2]);
    fclose(file);
}

/* All runs of a model; microseconds a step of the tree solver at the first tolerance. */
static double run_plan(const struct plan *plan, const char *folder)
{
    setup s;
    double step = 0.0;
    open_setup(&s, plan);
    run r = integrate(&s, TREE, plan->reference);
    bench_check(r.status, "reference", s.stiff.name);
    memcpy(s.reference, s.places, 3 * (size_t)s.stiff.bodies * sizeof(double));
    printf("# %s, %d bodies, t = 0 .. %g s: start %.3f s; reference at %g: %ld steps, %.1f s\n",
           s.stiff.name, s.stiff.bodies, s.stiff.T, s.start_time, plan->reference, r.stats.steps,
           r.time);
    compare(&s);
    for (size_t k = 0; k < sizeof tolerances / sizeof tolerances[0]; ++k) {
        for (int which = 0; which < SOLVERS; ++which) {
            if (!(plan->solvers & 1 << which) || (k > 0 && which > 0)) continue;
            r = integrate(&s, 1 << which, tolerances[k]);
            report(&s, which, tolerances[k], &r);
            if (k == 0 && which == 0) step = 1e6 * r.time / (double)r.stats.steps;
        }
    }
    if (plan->target > 0.0) write_reference(&s, folder, plan->target);
    close_setup(&s);
    return step;
}

/* The slopes of the time of a step over the number of bodies, model by model. */
static void print_slopes(const double step[PLANS])
{
    for (int k = 0, last; k < PLANS; k = last) {
        double n[PLANS], time[PLANS];
        int points = 0;
        for (last = k; last < PLANS && plans[last].make == plans[k].make; ++last) {
            if (step[last] <= 0.0) continue;
            n[points] = plans[last].n;
            time[points++] = step[last];
        }
        if (points < 2) continue;
        stiff_model s;
        plans[k].make(&s, 3);
        printf("# time of a step, tree solver, %g: %s, %g to %g bodies: slope %.3f\n",
               tolerances[0], s.name, n[0], n[points - 1], bench_fit_power(points, n, time).slope);
        stiff_free(&s);
    }
}

int main(int argc, char **argv)
{
    const int most = argc > 2 ? atoi(argv[2]) : 1000000;
    double step[PLANS] = {0.0};
    if (argc < 2 || most < 1) {
        fprintf(stderr, "bench_newton folder [largest number of bodies]\n");
        return EXIT_FAILURE;
    }
    bench_header(stdout, "libmbsrank: whole runs of stiff trees, momentum form, SUNDIALS IDA");
    printf("# %d output times; setup_s: driver\n"
           "model,bodies,massless,unknowns,solver,tolerance,result,steps,newton_iterations,"
           "newton_failures,error_test_failures,factorisations,residuals,difference_residuals,"
           "krylov_iterations,rank,entries,setup_s,cpu_s,us_per_step,us_per_step_and_body,"
           "error_m\n",
           POINTS);
    for (int k = 0; k < PLANS; ++k) {
        if (plans[k].n <= most) step[k] = run_plan(plans + k, argv[1]);
    }
    print_slopes(step);
    return EXIT_SUCCESS;
}
