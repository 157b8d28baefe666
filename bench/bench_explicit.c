/* The IDA driver beside an explicit method where nothing is stiff: damped chains of 30 boxes, joint
 * axes in turn y and z, integrated on the tree in the momentum form, and by the classical
 * Runge-Kutta method on forward dynamics. An implicit method has to solve for each step; this is
 * what that costs.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_explicit [samples]      CSV on standard output
 *
 * The error is the largest of the angles at the end, in rad, beside a Runge-Kutta run of 50 times
 * the most steps of the table. Times are the least of the samples, which take turns. */
#include "bench.h"
#include "work.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LINKS = 30, MOST_RUNS = 8, REFERENCE = 200000 };

static const double T = 5.0; /* s */

/* Stiffness and damping of each joint, N m/rad and N m s/rad. */
static const struct chain {
    const char *name;
    double stiffness, damping;
} chains[] = {
    {"slack", 20.0, 0.2},
    {"elastic", 200.0, 0.2},
    {"damped", 50.0, 1.0},
    {"stiff", 200.0, 5.0}, /* the explicit method has to take steps for stability */
};
enum { CHAINS = sizeof chains / sizeof chains[0] };

static mbsr_model *make(const struct chain *of)
{
    mbsr_model *m;
    bench_check(mbsr_model_create(NULL, &m, NULL), "mbsr_model_create", NULL);
    for (int k = 0; k < LINKS; ++k) {
        const mbsr_frame at = mbsr_frame_at(k > 0 ? 1.0 : 0.0, 0.0, 0.0);
        mbsr_body_def body = mbsr_default_body_def();
        const mbsr_force_def spring =
            mbsr_force_joint_spring(k, 0, of->stiffness, of->damping, 0.0);
        body.parent = k - 1;
        body.joint = mbsr_joint_revolute(&at, NULL, (double[3]){0.0, k % 2 ? 0.0 : 1.0, k % 2});
        body.inertia = mbsr_inertia_box(1.0, (double[3]){1.0, 0.3, 0.3});
        bench_check(mbsr_model_add_body(m, &body, NULL), "body", mbsr_model_error(m)->text);
        bench_check(mbsr_model_add_force(m, &spring, NULL), "spring", mbsr_model_error(m)->text);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    bench_check(mbsr_model_add_force(m, &gravity, NULL), "gravity", mbsr_model_error(m)->text);
    bench_check(mbsr_model_finish(m), "mbsr_model_finish", mbsr_model_error(m)->text);
    return m;
}

typedef struct setup {
    mbsr_model *model;
    mbsr_data *data;
    double reference[LINKS];
} setup;

/* One run: `steps` of Runge-Kutta or, where that is 0, IDA with `tolerance`. */
typedef struct run {
    int steps;
    double tolerance;
    double time, error; /* s, rad */
    mbsr_ida_stats stats;
} run;

static void explicit_run(const setup *s, int steps, double *x)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    const double h = T / steps;
    double y[2 * LINKS], slope[2 * LINKS] = {0.0};
    for (int step = 0; step < steps; ++step) {
        double sum[2 * LINKS] = {0.0};
        for (int stage = 0; stage < 4; ++stage) {
            for (int k = 0; k < 2 * LINKS; ++k)
                y[k] = x[k] + (stage > 0 ? at[stage] * h * slope[k] : 0.0);
            memcpy(slope, y + LINKS, LINKS * sizeof *slope);
            if (mbsr_forward_dynamics(s->model, s->data, (step + at[stage]) * h, y, y + LINKS, NULL,
                                      slope + LINKS)) {
                x[0] = NAN; /* unstable */
                return;
            }
            for (int k = 0; k < 2 * LINKS; ++k) sum[k] += weight[stage] * slope[k];
        }
        for (int k = 0; k < 2 * LINKS; ++k) x[k] += h / 6.0 * sum[k];
    }
}

static void implicit_run(const setup *s, run *r, double *x)
{
    double y[3 * LINKS] = {0.0}, yp[3 * LINKS] = {0.0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida *ida;
    mbsr_error error;
    memcpy(y, x, LINKS * sizeof *y);
    opt.rtol = opt.atol = r->tolerance;
    bench_check(mbsr_dae_consistent(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                "start", mbsr_data_error(s->data)->text);
    bench_check(mbsr_ida_create(s->model, s->data, &opt, &ida, &error), "driver", error.text);
    const double begin = bench_now();
    bench_check(mbsr_ida_start(ida, 0.0, y, yp), "start", mbsr_ida_error(ida)->text);
    bench_check(mbsr_ida_advance(ida, T, NULL, y, yp), "run", mbsr_ida_error(ida)->text);
    r->time = bench_now() - begin;
    bench_check(mbsr_ida_get_stats(ida, &r->stats), "statistics", NULL);
    mbsr_ida_destroy(ida);
    memcpy(x, y, LINKS * sizeof *x);
}

static void integrate(const setup *s, run *r)
{
    double x[2 * LINKS] = {0.0};
    const double least = r->time;
    for (int k = 0; k < LINKS; ++k) x[k] = 0.1;
    if (r->steps > 0) {
        const double begin = bench_now();
        explicit_run(s, r->steps, x);
        r->time = bench_now() - begin;
    } else {
        implicit_run(s, r, x);
    }
    r->error = 0.0;
    for (int k = 0; k < LINKS; ++k) {
        const double off = fabs(x[k] - s->reference[k]);
        if (!(off <= r->error)) r->error = off;
    }
    if (least > 0.0) r->time = fmin(least, r->time);
}

static void report(const char *name, int which, const run *r, work *w)
{
    const double evaluations = r->steps > 0 ? 4.0 * r->steps : (double)r->stats.residuals;
    const long steps = r->steps > 0 ? r->steps : r->stats.steps;
    printf("%s,%s,%g,%ld,%.0f,%ld,%.3g,%.2f,%.2e\n", name, which ? "ida" : "rk4", r->tolerance,
           steps, evaluations, r->stats.factorisations, r->time, 1e6 * r->time / (double)steps,
           r->error);
    if (r->error < 1.0)
        work_add(w, r->error, (double[]){r->time, evaluations, 0.0, 0.0, (double)steps});
}

static void run_chain(const struct chain *of, int samples)
{
    setup s = {0};
    run runs[2][MOST_RUNS] = {{{0}}};
    work cost[2] = {{0}};
    double x[2 * LINKS] = {0.0};
    s.model = make(of);
    bench_check(mbsr_data_create(s.model, &s.data, NULL), "mbsr_data_create", NULL);
    for (int k = 0; k < LINKS; ++k) x[k] = 0.1;
    explicit_run(&s, REFERENCE, x);
    memcpy(s.reference, x, sizeof s.reference);
    for (int sample = 0; sample < samples; ++sample) {
        for (int k = 0; k < MOST_RUNS; ++k) {
            if (k < MOST_RUNS - 1) {
                runs[1][k].tolerance = pow(10.0, -3.0 - k);
                integrate(&s, &runs[1][k]);
            }
            runs[0][k].steps = 250 << k >> 1;
            integrate(&s, &runs[0][k]);
        }
    }
    for (int which = 0; which < 2; ++which) {
        for (int k = 0; k < MOST_RUNS - which; ++k)
            report(of->name, which, &runs[which][k], &cost[which]);
    }
    printf("# %s: time of IDA over that of rk4 at equal error %.2f, evaluations %.2f\n", of->name,
           work_ratio(&cost[1], &cost[0], 0), work_ratio(&cost[1], &cost[0], 1));
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : 7;
    if (samples < 1) {
        fprintf(stderr, "bench_explicit [samples]\n");
        return EXIT_FAILURE;
    }
    bench_header(stdout,
                 "libmbsrank: the IDA driver beside the explicit Runge-Kutta method of order 4");
    printf("# chains of %d boxes, %g s\n"
           "chain,method,tolerance,steps,evaluations,factorisations,cpu_s,us_per_step,error_rad\n",
           LINKS, T);
    for (int k = 0; k < CHAINS; ++k) run_chain(&chains[k], samples);
    return EXIT_SUCCESS;
}
