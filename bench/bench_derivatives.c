/* Products with the derivatives of forward dynamics, beside forward dynamics itself, in one run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_derivatives [samples [largest N]]     CSV on standard output
 *
 * Chains of hinges with a spring at each, N = 10 to 10 000 bodies: nanoseconds a body of forward
 * dynamics, of linearising it, of a tangent and of an adjoint. */
#include "bench.h"
#include "trees.h"

#include <stdlib.h>

enum { SAMPLES = 21, TASKS = 4 };

static const char *const task_name[TASKS] = {"forward", "linearise", "tangent", "adjoint"};

typedef struct scene {
    bench_model tree;
    mbsr_data *data;
    mbsr_derivatives *derivatives;
    double *dq, *out, *by_q, *by_u, *by_tau;
    int repeats[TASKS];
} scene;

static void run(scene *s, int task)
{
    const bench_model *t = &s->tree;
    int status = 0;
    switch (task) {
    case 0:
        status = mbsr_forward_dynamics(t->model, s->data, 0.0, t->q, t->u, t->tau, s->out);
        break;
    case 1:
        status = mbsr_derivatives_forward(s->derivatives, 0.0, t->q, t->u, t->tau, s->out, NULL);
        break;
    case 2:
        status = mbsr_derivatives_tangent(s->derivatives, s->dq, t->u, t->tau, s->out, NULL);
        break;
    default:
        status = mbsr_derivatives_adjoint(s->derivatives, s->dq, NULL, s->by_q, s->by_u, s->by_tau);
    }
    bench_check(status, task_name[task], mbsr_derivatives_error(s->derivatives)->text);
}

static double measure(void *context, int which)
{
    scene *s = context;
    const double start = bench_now();
    for (int k = 0; k < s->repeats[which]; ++k) run(s, which);
    return (bench_now() - start) / s->repeats[which];
}

static void open_scene(scene *s, int bodies)
{
    uint64_t random = 5;
    bench_make_chain(&s->tree, bodies, 0, 1);
    const size_t nu = (size_t)s->tree.nu;
    mbsr_error error;
    bench_check(mbsr_data_create(s->tree.model, &s->data, &error), "data", error.text);
    bench_check(mbsr_derivatives_create(s->tree.model, &s->derivatives, &error), "derivatives",
                error.text);
    double **const vector[] = {&s->dq, &s->out, &s->by_q, &s->by_u, &s->by_tau};
    for (int k = 0; k < 5; ++k) *vector[k] = bench_allocate(nu, sizeof(double));
    for (size_t k = 0; k < nu; ++k) s->dq[k] = bench_uniform(&random, -1.0, 1.0);
    run(s, 1);
    for (int task = 0; task < TASKS; ++task) {
        s->repeats[task] = 1;
        const double once = measure(s, task);
        s->repeats[task] = once > 2e-3 ? 1 : 1 + (int)(2e-3 / (once + 1e-9));
    }
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES, most = argc > 2 ? atoi(argv[2]) : 10000;
    double *sample = bench_allocate((size_t)(TASKS * samples), sizeof *sample);
    bench_header(stdout, "derivatives: nanoseconds a body, chains of hinges with springs");
    printf("bodies,task,min,q1,median,q3,forward_dynamics\n");
    for (int bodies = 10; bodies <= most; bodies *= 10) {
        scene s;
        double forward = 1.0;
        open_scene(&s, bodies);
        bench_sample_all(TASKS, samples, measure, &s, sample);
        for (int task = 0; task < TASKS; ++task) {
            const bench_quartiles q = bench_statistics(samples, sample + task * samples);
            const double unit = 1e9 / bodies;
            if (task == 0) forward = q.median;
            printf("%d,%s,%.4g,%.4g,%.4g,%.4g,%.3g\n", bodies, task_name[task], unit * q.min,
                   unit * q.q1, unit * q.median, unit * q.q3, q.median / forward);
        }
        mbsr_derivatives_destroy(s.derivatives);
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.tree.model);
        double *const vector[] = {s.dq,     s.out,    s.by_q,   s.by_u,
                                  s.by_tau, s.tree.q, s.tree.u, s.tree.tau};
        for (int k = 0; k < 8; ++k) free(vector[k]);
    }
    free(sample);
    return 0;
}
