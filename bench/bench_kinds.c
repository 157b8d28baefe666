/* Time per body of chains with bodies of other kinds than rigid bodies in space on stock joints.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_kinds [samples]     CSV on standard output
 *
 * Chains of hinges, all with the same task: forward and inverse dynamics, the residual of the
 * momentum form, and one factorisation with one solution of its Newton system. In space some joints
 * have a table of their own, whose functions call those of the stock joint: to the library such a
 * joint is a user's. */
#include "bench.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdlib.h>

enum { SAMPLES = 21, TASKS = 4 };

static const double sample_time = 5e-3;
static const char *const task_name[TASKS] = {"forward", "inverse", "residual", "factor_solve"};

static const struct bench_case {
    const char *name;
    int bodies, planar;
    int every; /* of so many joints one is a user's; 0: none */
} cases[] = {{"space", 100, 0, 0},           {"one_own_joint", 100, 0, 100},
             {"ten_own_joints", 100, 0, 10}, {"all_joints_own", 100, 0, 1},
             {"plane", 100, 1, 0},           {"plane", 1000, 1, 0}};
enum { CASES = sizeof cases / sizeof cases[0] };

typedef struct chain {
    int bodies;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    double *q, *u, *udot, *y, *yp, *F, *x;
    int repeats[TASKS];
} chain;

/* ---- a user's hinge -------------------------------------------------------------------------- */

static const mbsr_joint_table *stock;

static int own_position(const mbsr_joint_args *args, double *p)
{
    return stock->position(args, p);
}

static int own_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    return stock->jacobians(args, K, H, J, kI);
}

static int own_bias(const mbsr_joint_args *args, double *kII)
{
    return stock->bias(args, kII);
}

static int own_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    return stock->rates(args, Kdot, Hdot, Jdot);
}

static mbsr_joint own_hinge(mbsr_joint joint)
{
    static mbsr_joint_table own;
    stock = joint.table;
    own = (mbsr_joint_table){.version = MBSR_JOINT_TABLE_VERSION,
                             .flags = stock->flags,
                             .name = "own",
                             .position = own_position,
                             .jacobians = own_jacobians,
                             .bias = own_bias,
                             .rates = own_rates};
    joint.table = &own;
    return joint;
}

/* ---- models ---------------------------------------------------------------------------------- */

static mbsr_body_def body_of(const struct bench_case *c, int i)
{
    const double axis[3] = {i % 3 == 0, i % 3 == 1, i % 3 == 2}, com[3] = {0.1, 0.2, 0.3};
    const double tensor[6] = {0.1, 0.1, 0.1, 0.0, 0.0, 0.0};
    const mbsr_frame A = mbsr_frame_at(0.3, 0.0, 0.1);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = i - 1;
    if (c->planar) {
        const mbsr_planar_frame end = {i ? 1.0 : 0.0, 0.0, 0.0}, origin = {0.0, 0.0, 0.0};
        const double middle[2] = {0.5, 0.0};
        body.joint = mbsr_joint_planar_revolute(end, origin);
        body.inertia = mbsr_inertia_planar(1.0, middle, 0.1);
        return body;
    }
    body.joint = mbsr_joint_revolute(&A, NULL, axis);
    body.inertia = mbsr_inertia_rigid(1.0, com, tensor);
    if (c->every && i % c->every == c->every / 2) body.joint = own_hinge(body.joint);
    return body;
}

static void make_chain(chain *s, const struct bench_case *c)
{
    const size_t n = (size_t)c->bodies;
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    s->bodies = c->bodies;
    bench_check(mbsr_model_create(NULL, &s->model, NULL), "model", NULL);
    const mbsr_error *error = mbsr_model_error(s->model);
    for (int i = 0; i < c->bodies; ++i) {
        const mbsr_body_def body = body_of(c, i);
        bench_check(mbsr_model_add_body(s->model, &body, NULL), "body", error->text);
    }
    bench_check(mbsr_model_add_force(s->model, &gravity, NULL), "gravity", error->text);
    bench_check(mbsr_model_finish(s->model), "finish", error->text);
    bench_check(mbsr_data_create(s->model, &s->data, NULL), "data", NULL);
    bench_check(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &s->newton, NULL), "newton",
                NULL);
    s->q = bench_allocate(15 * n, sizeof *s->q);
    s->u = s->q + n;
    s->udot = s->u + n;
    s->y = s->udot + n;
    s->yp = s->y + 3 * n;
    s->F = s->yp + 3 * n;
    s->x = s->F + 3 * n;
    for (int i = 0; i < c->bodies; ++i) {
        s->q[i] = 0.1 * sin(i);
        s->u[i] = cos(i);
    }
    bench_check(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y), "pack",
                mbsr_data_error(s->data)->text);
    for (int task = 0; task < TASKS; ++task) s->repeats[task] = 1;
}

static void free_chain(chain *s)
{
    mbsr_newton_destroy(s->newton);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    free(s->q);
}

/* ---- measurement ----------------------------------------------------------------------------- */

static int run(chain *s, int task)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    switch (task) {
    case 0: return mbsr_forward_dynamics(m, d, 0.0, s->q, s->u, NULL, s->udot);
    case 1: return mbsr_inverse_dynamics(m, d, 0.0, s->q, s->u, s->udot, s->x);
    case 2: return mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, s->F);
    default: break;
    }
    const int status = mbsr_newton_factor(s->newton, d, 0.0, s->y, s->yp, 10.0);
    return status ? status : mbsr_newton_solve(s->newton, s->F, s->x);
}

/* Nanoseconds per body of a call, the mean over as many as last 5 ms. */
static double measure(void *context, int which)
{
    chain *s = (chain *)context + which / TASKS;
    const int task = which % TASKS;
    bench_check(run(s, task), task_name[task], mbsr_data_error(s->data)->text);
    for (;;) {
        const double start = bench_now();
        for (int k = 0; k < s->repeats[task]; ++k) run(s, task);
        const double time = bench_now() - start;
        if (time >= sample_time) return 1e9 * time / s->repeats[task] / s->bodies;
        s->repeats[task] = 2 * s->repeats[task];
    }
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES;
    chain chains[CASES] = {0};
    if (samples < 1) {
        fprintf(stderr, "usage: bench_kinds [samples]\n");
        return EXIT_FAILURE;
    }
    for (int c = 0; c < CASES; ++c) make_chain(chains + c, cases + c);
    double *sample = bench_allocate((size_t)(CASES * TASKS * samples), sizeof *sample);
    bench_sample_all(CASES * TASKS, samples, measure, chains, sample);
    bench_header(stdout, "libmbsrank: time per body of chains with bodies of several kinds");
    printf("chain,bodies,task,ns_per_body,min,q1,q3,samples\n");
    for (int k = 0; k < CASES * TASKS; ++k) {
        const struct bench_case *c = cases + k / TASKS;
        const bench_quartiles time = bench_statistics(samples, sample + k * samples);
        printf("%s,%d,%s,%.1f,%.1f,%.1f,%.1f,%d\n", c->name, c->bodies, task_name[k % TASKS],
               time.median, time.min, time.q1, time.q3, samples);
    }
    free(sample);
    for (int c = 0; c < CASES; ++c) free_chain(chains + c);
    return EXIT_SUCCESS;
}
