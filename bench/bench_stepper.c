/* Times of fixed steps: ragdoll, vehicles; how they are distributed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_stepper [steps]      CSV on standard output; steps of the vehicle, default 1 000 000
 *   bench_stepper --one STEPS  steps of the vehicle alone, of order 2, for counts of instructions
 *
 * CPU time of each step of whole runs: the vehicle (`vehicle`) at 1 kHz with its steering
 * changed before every step, the one with multi-link suspensions (`multilink`; `multilink_kept`:
 * a matrix serves 20 steps) at 1 kHz, a ragdoll (`ragdoll`) that falls and comes to rest at 60
 * Hz, again and again. Beside them times of one residual, factorisation and solution at the last
 * state. Then the histogram of the vehicle's steps. */
#include "bench.h"

#include "real_time.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 1000000, PARTS = 3, BINS = 40 };

typedef struct run {
    const char *name;
    real_time_scene (*build)(void);
    double h;
    int again; /* steps after which it starts anew; 0: never */
    int share; /* of the steps asked for, one in so many */
    int matrix_steps;
} run;

static const run runs[] = {{"vehicle", real_time_vehicle, 1e-3, 0, 1, 1},
                           {"multilink", real_time_multilink, 1e-3, 5000, 20, 1},
                           {"multilink_kept", real_time_multilink, 1e-3, 5000, 20, 20},
                           {"ragdoll", real_time_ragdoll, 1.0 / 60.0, 300, 20, 1}};
enum { RUNS = sizeof runs / sizeof runs[0] };

typedef struct result {
    int steps;
    double *time;       /* s, sorted */
    double part[PARTS]; /* s: residual, factorisation, solution */
    long residuals, factorisations;
    mbsr_stepper_info info;
} result;

static void start(mbsr_stepper *stepper, const real_time_scene *s)
{
    bench_check(mbsr_stepper_start(stepper, 0.0, s->q, s->u), "start",
                mbsr_stepper_error(stepper)->text);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* What one call costs at the stepper's state, s. */
static void measure_parts(const real_time_scene *s, mbsr_data *data, mbsr_stepper *stepper,
                          double h, double *part)
{
    enum { CALLS = 500 };
    const size_t size = (size_t)mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
    double *y = bench_allocate(4 * size, sizeof *y), *yp = y + size, *F = yp + size, *x = F + size;
    double t;
    mbsr_newton *newton;
    mbsr_stepper_state(stepper, &t, y, yp);
    bench_check(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), "newton",
                NULL);
    for (int k = 0; k < PARTS; ++k) {
        int status = 0;
        const double begin = bench_now();
        for (int call = 0; call < CALLS && !status; ++call) {
            if (k == 0) status = mbsr_dae_residual(s->model, data, MBSR_DAE_MOMENTUM, t, y, yp, F);
            if (k == 1) status = mbsr_newton_factor(newton, data, t, y, yp, 1.0 / h);
            if (k == 2) status = mbsr_newton_solve(newton, F, x);
        }
        part[k] = (bench_now() - begin) / CALLS;
        bench_check(status, "a part", mbsr_data_error(data)->text);
    }
    mbsr_newton_destroy(newton);
    free(y);
}

static result measure(const run *what, int order, int steps)
{
    real_time_scene s = what->build();
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    mbsr_data *data;
    mbsr_stepper *stepper;
    mbsr_error error;
    result r = {.steps = steps, .time = bench_allocate((size_t)steps, sizeof *r.time)};
    opt.order = order;
    opt.h = what->h;
    opt.matrix_steps = what->matrix_steps;
    bench_check(mbsr_data_create(s.model, &data, &error), "data", error.text);
    bench_check(mbsr_stepper_create(s.model, data, &opt, &stepper, &error), "stepper", error.text);
    mbsr_stepper_work most = {0};
    for (int k = 0; k < steps; ++k) {
        if (k == 0 || (what->again && k % what->again == 0)) start(stepper, &s);
        if (s.steer) s.steer[0] = 1500.0 * sin(2e-3 * k);
        const double begin = bench_now();
        const int status = mbsr_stepper_step(stepper);
        r.time[k] = bench_now() - begin;
        bench_check(status, "step", mbsr_stepper_error(stepper)->text);
        mbsr_stepper_get_info(stepper, &r.info);
        const mbsr_stepper_work *now = &r.info.last;
        r.residuals += now->residuals;
        r.factorisations += now->factorisations;
        if (now->residuals > most.residuals) most = *now;
    }
    r.info.most = most;
    measure_parts(&s, data, stepper, what->h, r.part);
    qsort(r.time, (size_t)steps, sizeof *r.time, compare);
    mbsr_stepper_destroy(stepper);
    mbsr_data_destroy(data);
    real_time_free(&s);
    return r;
}

static double quantile(const result *r, double share)
{
    const int k = (int)(share * r->steps);
    return r->time[k < r->steps ? k : r->steps - 1];
}

static void print(const run *what, int order, const result *r)
{
    const double median = quantile(r, 0.5);
    printf("%s,%d,%d,%.2f,%.2f,%.2f,%.1f,%.1f,%.1f,%.1f,%.1f,%.2f,%.2f,%d,%d,%d\n", what->name,
           order, r->steps, 1e6 * r->part[0], 1e6 * r->part[1], 1e6 * r->part[2], 1e6 * median,
           1e6 * quantile(r, 0.99), 1e6 * quantile(r, 0.9999), 1e6 * r->time[r->steps - 1],
           median / r->part[0], (double)r->residuals / r->steps,
           (double)r->factorisations / r->steps, r->info.most.residuals,
           r->info.most.factorisations, r->info.most.substeps);
}

/* Counts of steps by their time, in bins a quarter of a power of two wide from half of the
 * median on. */
static void print_histogram(const result *r, int order)
{
    const double first = 0.5 * quantile(r, 0.5);
    int at = 0;
    for (int bin = 0; bin < BINS; ++bin) {
        const double end = bin == BINS - 1 ? INFINITY : first * exp2(0.25 * (bin + 1));
        int count = 0;
        while (at < r->steps && r->time[at] < end) ++at, ++count;
        if (count > 0)
            printf("histogram,%d,%.1f,%.1f,%d\n", order, 1e6 * first * exp2(0.25 * bin), 1e6 * end,
                   count);
    }
}

int main(int argc, char **argv)
{
    if (argc > 2 && strcmp(argv[1], "--one") == 0) {
        result r = measure(runs, 2, atoi(argv[2]));
        free(r.time);
        return 0;
    }
    const int steps = argc > 1 ? atoi(argv[1]) : STEPS;
    bench_check(steps < 100, "steps, 100 at least", NULL);
    bench_header(stdout, "fixed steps of the stepper, CPU time");
    printf("model,order,steps,residual_us,factor_us,solve_us,step_median_us,p99_us,p99_99_us,"
           "largest_us,median_over_residual,residuals_mean,factorisations_mean,residuals_most,"
           "factorisations_then,substeps_then\n");
    result vehicle[2];
    for (int k = 0; k < RUNS; ++k) {
        for (int order = 1; order <= 2; ++order) {
            const result r = measure(runs + k, order, steps / runs[k].share);
            print(runs + k, order, &r);
            if (k == 0)
                vehicle[order - 1] = r;
            else
                free(r.time);
        }
    }
    printf("# steps of the vehicle by their time\nhistogram,order,from_us,to_us,steps\n");
    for (int order = 1; order <= 2; ++order) {
        print_histogram(vehicle + order - 1, order);
        free(vehicle[order - 1].time);
    }
    return 0;
}
