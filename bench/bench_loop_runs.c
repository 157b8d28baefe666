/* Whole runs of mechanisms with closed loops from rest by the driver: steps, CPU time, error, how
 * far loops are open.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_loop_runs FOLDER           CSV on standard output
 *
 * The chains of four-bars and rings of bench_loops fall, for 0.3 to 1 s. The reference is a run of
 * the driver at a tolerance of 1e-10; errors are the largest of angles at the end.
 * `libmbsrank_rk4`: forward dynamics in the Runge-Kutta method of order 4, in as many steps (5, 10,
 * 20 and so on) as it takes to be no farther off than the driver. For each mechanism and tolerance
 * a file NAME_EXPONENT.run in the folder has the time, the error and the angles that runs of other
 * libraries are compared with (peers/loops.cpp, which reads the mechanism from bench_loops
 * --write). CPU time is the median of runs, without what creates the solver. */
#include "bench.h"
#include "trees.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 5 };

static const struct bench_case {
    const char *name;
    int count, ring;
    double T; /* s */
} cases[] = {{"fourbars", 10, 0, 1.0},
             {"fourbars", 100, 0, 0.5},
             {"ring", 10, 1, 0.3},
             {"ring", 100, 1, 0.3}};
enum { CASES = sizeof cases / sizeof cases[0] };

typedef struct outcome {
    long steps;
    double seconds, gap;
} outcome;

/* q: angles at the end. */
static outcome integrate(const bench_model *tree, double T, double tolerance, double *q)
{
    const mbsr_model *m = tree->model;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double *y = bench_allocate(2 * size, sizeof *y), *yp = y + size,
           *u = bench_allocate((size_t)tree->nu, sizeof *u);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_ida_drift drift;
    mbsr_ida_stats stats;
    outcome o;
    bench_check(mbsr_data_create(m, &d, NULL), "mbsr_data_create", NULL);
    bench_check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, tree->q, u, y), "mbsr_dae_pack",
                mbsr_data_error(d)->text);
    bench_check(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                "mbsr_dae_consistent", mbsr_data_error(d)->text);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    bench_check(mbsr_ida_create(m, d, &opt, &ida, NULL), "mbsr_ida_create", NULL);
    const double before = bench_now();
    bench_check(mbsr_ida_start(ida, 0.0, y, yp), "mbsr_ida_start", mbsr_ida_error(ida)->text);
    bench_check(mbsr_ida_advance(ida, T, NULL, y, NULL), "mbsr_ida_advance",
                mbsr_ida_error(ida)->text);
    o.seconds = bench_now() - before;
    bench_check(mbsr_ida_get_stats(ida, &stats), "mbsr_ida_get_stats", NULL);
    o.steps = stats.steps;
    bench_check(mbsr_ida_get_drift(ida, &drift), "mbsr_ida_get_drift", NULL);
    o.gap = drift.gap;
    memcpy(q, y, (size_t)tree->nq * sizeof *q);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    free(y);
    free(u);
    return o;
}

/* The same by forward dynamics; no steps: they were too large for an end with numbers. */
static outcome integrate_explicitly(const bench_model *tree, double T, long steps, double *q)
{
    static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0},
                        at[4] = {0.0, 0.5, 0.5, 1.0};
    const size_t n = (size_t)tree->nu;
    const double h = T / (double)steps;
    const mbsr_model *m = tree->model;
    outcome o = {.steps = steps};
    double *u = bench_allocate(6 * n + (size_t)mbsr_model_rows(m), sizeof *u), *udot = u + n,
           *q0 = udot + n, *u0 = q0 + n, *stage = u0 + n, *rate = stage + n, *gap = rate + n;
    mbsr_data *d = NULL;
    int failed = 0;
    bench_check(mbsr_data_create(m, &d, NULL), "mbsr_data_create", NULL);
    memcpy(q, tree->q, n * sizeof *q);
    const double before = bench_now();
    for (long step = 0; step < steps && !failed; ++step) {
        memcpy(q0, q, n * sizeof *q);
        memcpy(u0, u, n * sizeof *u);
        for (int k = 0; k < 4; ++k) {
            for (size_t j = 0; j < n; ++j) {
                stage[j] = q0[j] + at[k] * h * (k > 0 ? rate[j] : 0.0);
                rate[j] = u0[j] + at[k] * h * (k > 0 ? udot[j] : 0.0);
            }
            failed =
                failed || mbsr_forward_dynamics(m, d, (double)step * h, stage, rate, NULL, udot);
            for (size_t j = 0; j < n; ++j) {
                q[j] += share[k] * h * rate[j];
                u[j] += share[k] * h * udot[j];
            }
        }
    }
    o.seconds = bench_now() - before;
    failed = failed || mbsr_stage_positions(m, d, T, q) || mbsr_closures_gap(m, d, gap);
    if (failed) o.steps = 0;
    for (int k = 0; k < mbsr_model_position_rows(m) && !failed; ++k)
        o.gap = fmax(o.gap, fabs(gap[k]));
    mbsr_data_destroy(d);
    free(u);
    return o;
}

static double distance(int n, const double *a, const double *b)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) {
        const double one = fabs(a[k] - b[k]);
        if (!(one <= most)) most = one; /* a NaN stays */
    }
    return most;
}

static void write_run(const char *folder, const struct bench_case *of, int exponent, double error,
                      int n, const double *q)
{
    char path[1000];
    snprintf(path, sizeof path, "%s/%s_%d_%d.run", folder, of->name, of->count, exponent);
    FILE *file = fopen(path, "w");
    if (!file) bench_check(MBSR_ERR_VALUE, path, "cannot be written");
    fprintf(file, "%.17g %.17g\n", of->T, error);
    for (int k = 0; k < n; ++k) fprintf(file, "%.17g\n", q[k]);
    if (fclose(file)) bench_check(MBSR_ERR_VALUE, path, "cannot be written");
}

static void report(const struct bench_case *of, const bench_model *tree, const char *by,
                   double parameter, const outcome *o, double error)
{
    printf("%s,%s,%d,%d,%g,%ld,%.3g,%.2e,%.1e\n", of->name, by, tree->bodies,
           mbsr_model_rows(tree->model), parameter, o->steps, o->seconds, error, o->gap);
    fflush(stdout);
}

static void run_explicitly(const struct bench_case *of, const bench_model *tree, double goal,
                           const double *reference, double *q)
{
    for (long steps = 5; steps < 5L << 20; steps *= 2) {
        const outcome o = integrate_explicitly(tree, of->T, steps, q);
        const double error = distance(tree->nq, q, reference);
        if (o.steps == 0 || !(error <= goal)) continue;
        report(of, tree, "libmbsrank_rk4", of->T / (double)steps, &o, error);
        return;
    }
}

static void measure(const struct bench_case *of, const char *folder)
{
    bench_model tree;
    if (of->ring)
        bench_make_ring(&tree, of->count, 1);
    else
        bench_make_fourbars(&tree, of->count, 0, BENCH_RIGID);
    const int n = tree.nq;
    double *reference = bench_allocate(2 * (size_t)n, sizeof *reference), *q = reference + n;
    integrate(&tree, of->T, 1e-10, reference);
    for (int exponent = 3; exponent <= 6; ++exponent) {
        const double tolerance = pow(10.0, -exponent);
        double seconds[RUNS];
        outcome o = {0};
        for (int k = 0; k < RUNS; ++k) {
            o = integrate(&tree, of->T, tolerance, q);
            seconds[k] = o.seconds;
        }
        o.seconds = bench_statistics(RUNS, seconds).median;
        const double error = distance(n, q, reference);
        report(of, &tree, "libmbsrank", tolerance, &o, error);
        write_run(folder, of, exponent, error, n, reference);
        run_explicitly(of, &tree, error, reference, q);
    }
    free(reference);
    bench_free_tree(&tree);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "bench_loop_runs FOLDER\n");
        return 2;
    }
    bench_header(stdout, "whole runs of models with closed loops");
    printf("model,library,bodies,rows,tolerance_or_step,steps,cpu_s,error_rad,gap_m\n");
    for (int k = 0; k < CASES; ++k) measure(cases + k, argv[1]);
    return 0;
}
