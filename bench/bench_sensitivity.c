/* Sensitivities of runs beside the runs themselves.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_sensitivity [largest N [kind]]     CSV on standard output
 *
 * Chains of N = 10, 100, ... hinges with a spring at each, 0.2 s, tolerances 1e-6: processor time
 * of the run, and in runs that of the forward sensitivities of 1 and 20 parameters, and of an
 * adjoint of 1, 20 and 2 N. The least of three. The same of 20 for chains of which every third body
 * has no mass, segments with directions without mass, and four-bars in a chain. */
#include "bench.h"
#include "trees.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/sensitivity.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REPEATS = 3, FORWARD = 20, KINDS = 4 };

static const char *const kinds[KINDS] = {"hinges", "massless", "segments", "four-bars"};

static void check(int status, const char *text)
{
    if (!status) return;
    fprintf(stderr, "%s\n", text);
    exit(1);
}

static mbsr_model *make_chain(int bodies)
{
    const double axis[2][3] = {{1, 0, 0}, {0, 1, 0}}, com[3] = {0, 0, -0.05},
                 tensor[6] = {1e-4, 1e-4, 1e-4};
    const mbsr_frame below = mbsr_frame_at(0.0, 0.0, -0.1);
    mbsr_model *m;
    check(mbsr_model_create(NULL, &m, NULL), "no memory");
    for (int k = 0; k < bodies; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k > 0 ? k - 1 : MBSR_GROUND;
        body.joint = mbsr_joint_revolute(k > 0 ? &below : NULL, NULL, axis[k % 2]);
        body.inertia = mbsr_inertia_rigid(0.2, com, tensor);
        check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m)->text);
        const mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 50.0, 1.0, 0.0);
        check(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m)->text);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    check(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m)->text);
    check(mbsr_model_finish(m), mbsr_model_error(m)->text);
    return m;
}

/* Stiffness of each joint and mass of each body that has some, at most `count` of them. */
static int choose(const mbsr_parameters *list, int count, int *which)
{
    int found = 0;
    for (int k = 0; k < mbsr_parameters_count(list) && found < count; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(list, k, &p);
        if ((p.part == MBSR_PARAMETER_MASS && p.value > 0.0) || strstr(p.name, ".stiffness"))
            which[found++] = k;
    }
    return found;
}

static void measure(const char *kind, const mbsr_model *m, const mbsr_parameters *list,
                    const double *q, const double *u, int wanted)
{
    const double end = 0.2;
    double least[3] = {INFINITY, INFINITY, INFINITY}; /* run, forward, adjoint */
    const int nq = mbsr_model_nq(m), bodies = mbsr_model_bodies(m);
    double *w = calloc((size_t)nq, sizeof *w), *by = calloc((size_t)wanted, sizeof *by),
           *dq = calloc((size_t)nq * FORWARD, sizeof *dq);
    int *which = calloc((size_t)wanted, sizeof *which);
    mbsr_sensitivity *s;
    mbsr_error error;
    check(!w || !by || !dq || !which, "no memory");
    const int parameters = choose(list, wanted, which);
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    opt.list = list, opt.parameters = parameters, opt.which = which;
    check(mbsr_sensitivity_create(m, &opt, &s, &error), error.text);
    for (int k = 0; k < nq; ++k) w[k] = 1.0;
    const char *text = mbsr_sensitivity_error(s)->text;
    for (int k = 0; k < REPEATS; ++k) {
        double t = bench_now();
        check(mbsr_sensitivity_run(s, 0.0, q, u, 1, &end, NULL, NULL), text);
        least[0] = fmin(least[0], bench_now() - t);
        t = bench_now();
        if (parameters <= FORWARD) check(mbsr_sensitivity_forward(s, dq, NULL), text);
        least[1] = fmin(least[1], bench_now() - t);
        t = bench_now();
        check(mbsr_sensitivity_adjoint(s, w, NULL, by), text);
        least[2] = fmin(least[2], bench_now() - t);
    }
    const long steps = mbsr_sensitivity_steps(s);
    printf("%s,%d,%d,%ld,%.0f,", kind, bodies, parameters, steps,
           1e9 * least[0] / ((double)steps * bodies));
    if (parameters <= FORWARD) printf("%.2f", least[1] / least[0]);
    printf(",%.2f\n", least[2] / least[0]);
    fflush(stdout);
    mbsr_sensitivity_destroy(s);
    free(which), free(dq), free(by), free(w);
}

static void measure_hinges(int bodies)
{
    const int parameters[3] = {1, FORWARD, 2 * bodies};
    mbsr_model *m = make_chain(bodies);
    mbsr_parameters *list;
    double *q = calloc((size_t)bodies, sizeof *q);
    check(!q || mbsr_parameters_create(m, &list, NULL), "no memory");
    q[0] = 0.3;
    for (int k = 0; k < 3; ++k) measure(kinds[0], m, list, q, NULL, parameters[k]);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
    free(q);
}

static void measure_tree(const char *kind, bench_model *tree)
{
    mbsr_parameters *list;
    check(mbsr_parameters_create(tree->model, &list, NULL), "no memory");
    measure(kind, tree->model, list, tree->q, tree->u, FORWARD);
    mbsr_parameters_destroy(list);
    bench_free_tree(tree);
}

static void measure_kind(int kind, int bodies)
{
    bench_model tree;
    switch (kind) {
    case 0: measure_hinges(bodies); return;
    case 1: bench_make_chain(&tree, bodies, 3, 1); break;
    case 2: bench_make_segments(&tree, bodies / 3 + 1); break;
    default: bench_make_fourbars(&tree, bodies / 4 + 1, 0, BENCH_RIGID); break;
    }
    measure_tree(kinds[kind], &tree);
}

int main(int count, char **argument)
{
    const int largest = count > 1 ? atoi(argument[1]) : 1000;
    bench_header(stdout, "sensitivities");
    puts("kind,bodies,parameters,steps,run (ns/body/step),forward (runs),adjoint (runs)");
    for (int bodies = 10; bodies <= largest; bodies *= 10) {
        for (int k = 0; k < KINDS; ++k)
            if (count < 3 || strcmp(argument[2], kinds[k]) == 0) measure_kind(k, bodies);
    }
    return 0;
}
