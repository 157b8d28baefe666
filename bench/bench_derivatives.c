/* Products with the derivatives of forward dynamics, beside forward dynamics itself, in one run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_derivatives [samples [largest N [folder]]]     CSV on standard output
 *
 * Chains of hinges with a spring at each, N = 10 to 10 000 bodies, and with a folder
 * (tests/reference/trees) a humanoid: nanoseconds a body of forward dynamics, of linearising it, of
 * a tangent, of an adjoint; of the same in all masses, places of joints along one axis and
 * stiffnesses; to N = 100 of the three matrices. */
#include "bench.h"
#include "trees.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 21, TASKS = 8, MOST_DENSE = 100 };

static const char *const task_name[TASKS] = {"forward",
                                             "linearise",
                                             "tangent",
                                             "adjoint",
                                             "parameters_linearise",
                                             "parameters_tangent",
                                             "parameters_adjoint",
                                             "matrices"};

typedef struct scene {
    bench_model tree;
    mbsr_data *data;
    mbsr_derivatives *derivatives, *chosen; /* without parameters and with */
    double *theta;                          /* of these, a change and then gradients */
    int parameters;
    double *dq, *out, *by_q, *by_u, *by_tau, *matrix; /* matrix: NULL where too large */
    int tasks, repeats[TASKS];
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
    case 3:
        status = mbsr_derivatives_adjoint(s->derivatives, s->dq, NULL, s->by_q, s->by_u, s->by_tau);
        break;
    case 4:
        status = mbsr_derivatives_forward(s->chosen, 0.0, t->q, t->u, t->tau, s->out, NULL);
        break;
    case 5: status = mbsr_derivatives_parameter_tangent(s->chosen, s->theta, s->out, NULL); break;
    case 6:
        status =
            mbsr_derivatives_parameter_adjoint(s->chosen, s->dq, NULL, s->theta + s->parameters);
        break;
    default: {
        const size_t size = (size_t)t->nu * (size_t)t->nu;
        status = mbsr_derivatives_matrices(s->derivatives, s->matrix, s->matrix + size,
                                           s->matrix + 2 * size);
    }
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

/* Masses, places of joints along z and stiffnesses of all bodies. */
static void choose_parameters(scene *s, uint64_t *random)
{
    mbsr_parameters *list;
    mbsr_error error;
    bench_check(mbsr_parameters_create(s->tree.model, &list, &error), "parameters", error.text);
    const int count = mbsr_parameters_count(list);
    int *which = bench_allocate((size_t)count + 1, sizeof *which);
    s->parameters = 0;
    for (int k = 0; k < count; ++k) {
        mbsr_parameter p;
        (void)mbsr_parameter_get(list, k, &p);
        if (p.part == MBSR_PARAMETER_MASS || (p.part == MBSR_PARAMETER_JOINT && p.index == 2) ||
            (p.part == MBSR_PARAMETER_LAW && strstr(p.name, "stiffness")))
            which[s->parameters++] = k;
    }
    bench_check(mbsr_derivatives_create(s->tree.model, &s->chosen, &error), "derivatives",
                error.text);
    bench_check(mbsr_derivatives_parameters(s->chosen, list, s->parameters, which), "parameters",
                mbsr_derivatives_error(s->chosen)->text);
    s->theta = bench_allocate(2 * (size_t)s->parameters + 1, sizeof(double));
    for (int k = 0; k < s->parameters; ++k) s->theta[k] = bench_uniform(random, -1.0, 1.0);
    free(which);
    mbsr_parameters_destroy(list);
}

/* Of a tree that is there. */
static void open_scene(scene *s)
{
    uint64_t random = 5;
    const size_t nu = (size_t)s->tree.nu;
    mbsr_error error;
    bench_check(mbsr_data_create(s->tree.model, &s->data, &error), "data", error.text);
    bench_check(mbsr_derivatives_create(s->tree.model, &s->derivatives, &error), "derivatives",
                error.text);
    double **const vector[] = {&s->dq, &s->out, &s->by_q, &s->by_u, &s->by_tau};
    for (int k = 0; k < 5; ++k) *vector[k] = bench_allocate(nu, sizeof(double));
    const bool dense = s->tree.bodies <= MOST_DENSE;
    s->tasks = dense ? TASKS : TASKS - 1;
    s->matrix = dense ? bench_allocate(3 * nu * nu, sizeof(double)) : NULL;
    for (size_t k = 0; k < nu; ++k) s->dq[k] = bench_uniform(&random, -1.0, 1.0);
    choose_parameters(s, &random);
    run(s, 1);
    run(s, 4);
    for (int task = 0; task < s->tasks; ++task) {
        s->repeats[task] = 1;
        const double once = measure(s, task);
        s->repeats[task] = once > 2e-3 ? 1 : 1 + (int)(2e-3 / (once + 1e-9));
    }
}

static void close_scene(scene *s)
{
    mbsr_derivatives_destroy(s->derivatives);
    mbsr_derivatives_destroy(s->chosen);
    free(s->theta);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->tree.model);
    double *const vector[] = {s->dq,     s->out,    s->by_q,   s->by_u,    s->by_tau,
                              s->matrix, s->tree.q, s->tree.u, s->tree.tau};
    for (int k = 0; k < 9; ++k) free(vector[k]);
}

static void report(const char *name, scene *s, int samples, double *sample)
{
    double forward = 1.0;
    open_scene(s);
    bench_sample_all(s->tasks, samples, measure, s, sample);
    for (int task = 0; task < s->tasks; ++task) {
        const bench_quartiles q = bench_statistics(samples, sample + task * samples);
        const double unit = 1e9 / s->tree.bodies;
        if (task == 0) forward = q.median;
        printf("%s,%d,%s,%.4g,%.4g,%.4g,%.4g,%.3g\n", name, s->tree.bodies, task_name[task],
               unit * q.min, unit * q.q1, unit * q.median, unit * q.q3, q.median / forward);
    }
    close_scene(s);
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES, most = argc > 2 ? atoi(argv[2]) : 10000;
    double *sample = bench_allocate((size_t)(TASKS * samples), sizeof *sample);
    bench_header(stdout, "derivatives: nanoseconds a body");
    printf("tree,bodies,task,min,q1,median,q3,forward_dynamics\n");
    for (int bodies = 10; bodies <= most; bodies *= 10) {
        scene s;
        bench_make_chain(&s.tree, bodies, 0, 1);
        report("chain", &s, samples, sample);
    }
    if (argc > 3) {
        scene s;
        bench_read_tree(&s.tree, argv[3], "humanoid36");
        report("humanoid", &s, samples, sample);
        free(s.tree.udot);
    }
    free(sample);
    return 0;
}
