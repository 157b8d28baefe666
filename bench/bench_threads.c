/* Time of one evaluation by several threads beside that by one: subtrees of large trees, states of
 * a batch.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_threads [samples [threads]]     CSV on standard output; threads: 2
 *
 * Trees of hinges: full binary ones, and two chains on the root. Elapsed time, not CPU time; both
 * ways in turn, and the ratio of one to the other in each pair. Beside them what the memory gives
 * one thread and several: an array far beyond the caches, read, and read and written. */
#include "bench.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SAMPLES = 15, STATES = 4096, TASKS = 3 };

static const double sample_time = 0.05;
static const char *const task_name[TASKS] = {"forward", "inverse", "residual"};

typedef struct tree {
    mbsr_model *model;
    mbsr_data *data;
    mbsr_batch *batch[2];
    int nu, states;
    double *q, *u, *tau, *out, *y, *yp, *F;
} tree;

static double elapsed(void)
{
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int add(tree *t, int parent)
{
    static uint64_t random = 1;
    const double axis[3] = {bench_uniform(&random, -1.0, 1.0), bench_uniform(&random, -1.0, 1.0),
                            1.0},
                 edges[3] = {0.3, 0.1, 0.2};
    const mbsr_frame at = mbsr_frame_at(0.2, 0.1, 0.3);
    mbsr_body_def def = mbsr_default_body_def();
    int id;
    def.parent = parent;
    def.joint = mbsr_joint_revolute(&at, NULL, axis);
    def.inertia = mbsr_inertia_box(1000.0, edges);
    bench_check(mbsr_model_add_body(t->model, &def, &id), "mbsr_model_add_body",
                mbsr_model_error(t->model)->text);
    return id;
}

/* A full binary tree on this body. */
static void add_binary(tree *t, int parent, int bodies)
{
    if (bodies < 1) return;
    const int id = add(t, parent);
    add_binary(t, id, bodies / 2);
    add_binary(t, id, bodies / 2);
}

static void make_model(tree *t, int bodies, int branches)
{
    bench_check(mbsr_model_create(NULL, &t->model, NULL), "mbsr_model_create", NULL);
    if (branches) add_binary(t, MBSR_GROUND, bodies);
    for (int i = 0, last = MBSR_GROUND; i < bodies && !branches; ++i)
        last = add(t, i == bodies / 2 ? MBSR_GROUND : last);
    bench_check(mbsr_model_finish(t->model), "mbsr_model_finish", mbsr_model_error(t->model)->text);
}

static void make(tree *t, int bodies, int branches, int states)
{
    uint64_t random = 2;
    make_model(t, bodies, branches);
    t->nu = mbsr_model_nu(t->model);
    t->states = states;
    const size_t n = (size_t)t->nu * (size_t)states;
    bench_check(mbsr_data_create_lean(t->model, &t->data, NULL), "mbsr_data_create_lean", NULL);
    t->q = bench_allocate(n, sizeof(double));
    t->u = bench_allocate(n, sizeof(double));
    t->tau = bench_allocate(n, sizeof(double));
    t->out = bench_allocate(n, sizeof(double));
    t->y = bench_allocate(3 * (size_t)t->nu, sizeof(double));
    t->yp = bench_allocate(3 * (size_t)t->nu, sizeof(double));
    t->F = bench_allocate(3 * (size_t)t->nu, sizeof(double));
    for (size_t k = 0; k < n; ++k) {
        t->q[k] = bench_uniform(&random, -1.0, 1.0);
        t->u[k] = bench_uniform(&random, -1.0, 1.0);
        t->tau[k] = bench_uniform(&random, -1.0, 1.0);
    }
    for (int k = 0; k < t->nu; ++k) {
        t->y[k] = t->q[k];
        t->y[2 * t->nu + k] = t->u[k];
    }
}

static void release(tree *t)
{
    mbsr_data_destroy(t->data);
    mbsr_model_destroy(t->model);
    free(t->q), free(t->u), free(t->tau), free(t->out);
    free(t->y), free(t->yp), free(t->F);
}

/* which < TASKS: by the data; else forward and inverse dynamics by a batch. */
static int call(tree *t, int which, mbsr_batch *batch)
{
    const mbsr_model *m = t->model;
    if (batch && which == 1)
        return mbsr_batch_inverse_dynamics(m, batch, 0.0, t->states, t->q, t->u, t->tau, t->out,
                                           NULL);
    if (batch)
        return mbsr_batch_forward_dynamics(m, batch, 0.0, t->states, t->q, t->u, t->tau, t->out,
                                           NULL);
    switch (which) {
    case 0: return mbsr_forward_dynamics(m, t->data, 0.0, t->q, t->u, t->tau, t->out);
    case 1: return mbsr_inverse_dynamics(m, t->data, 0.0, t->q, t->u, t->tau, NULL, t->out);
    default: return mbsr_dae_residual(m, t->data, MBSR_DAE_MOMENTUM, 0.0, t->y, t->yp, t->F);
    }
}

static double time_of(tree *t, int which, mbsr_batch *batch, int repeats)
{
    const double start = elapsed();
    for (int k = 0; k < repeats; ++k)
        bench_check(call(t, which, batch), task_name[which], mbsr_data_error(t->data)->text);
    return (elapsed() - start) / repeats;
}

/* One line: ns a body (and state) by one thread and by several, and the median ratio. */
static void compare(tree *t, const char *name, int bodies, int which, mbsr_split *split,
                    int samples, int threads)
{
    mbsr_batch *const one_batch = split ? NULL : t->batch[0], *const many_batch =
                                                                  split ? NULL : t->batch[1];
    double *one = bench_allocate((size_t)samples, sizeof *one),
           *many = bench_allocate((size_t)samples, sizeof *many),
           *ratio = bench_allocate((size_t)samples, sizeof *ratio);
    const double first = time_of(t, which, one_batch, 1);
    const int repeats = first > sample_time ? 1 : (int)(sample_time / first) + 1;
    const double unit = 1e9 / bodies / t->states;
    for (int k = 0; k < samples; ++k) {
        one[k] = unit * time_of(t, which, one_batch, repeats);
        mbsr_data_use_split(t->data, split);
        many[k] = unit * time_of(t, which, many_batch, repeats);
        mbsr_data_use_split(t->data, NULL);
        ratio[k] = one[k] / many[k];
    }
    printf("%s,%d,%d,%s,%d,%.1f,%.1f,%.2f\n", name, bodies, t->states, task_name[which], threads,
           bench_statistics(samples, one).median, bench_statistics(samples, many).median,
           bench_statistics(samples, ratio).median);
    fflush(stdout);
    free(one), free(many), free(ratio);
}

static void measure_tree(const char *name, int bodies, int branches, const mbsr_parallel *parallel,
                         int samples)
{
    tree t;
    mbsr_split *split;
    make(&t, bodies, branches, 1);
    bench_check(mbsr_split_create(t.model, parallel, &split, NULL), "mbsr_split_create", NULL);
    for (int which = 0; which < TASKS; ++which)
        compare(&t, name, bodies, which, split, samples, parallel->workers);
    mbsr_split_destroy(split);
    release(&t);
}

static void measure_batch(int bodies, const mbsr_parallel *parallel, int samples)
{
    tree t;
    make(&t, bodies, 0, STATES);
    bench_check(mbsr_batch_create(t.model, t.batch, NULL), "mbsr_batch_create", NULL);
    bench_check(mbsr_batch_create_parallel(t.model, parallel, t.batch + 1, NULL),
                "mbsr_batch_create_parallel", NULL);
    for (int which = 0; which < 2; ++which)
        compare(&t, "batch", bodies, which, NULL, samples, parallel->workers);
    for (int k = 0; k < 2; ++k) mbsr_batch_destroy(t.batch[k]);
    release(&t);
}

/* ---- memory ---- */

enum { STREAM_VECTORS = 1 << 24 }; /* 256 MB */

typedef double vector __attribute__((vector_size(16)));

typedef struct stream {
    vector *at;
    int parts, writes;
    vector sum[64];
} stream;

static void run_part(void *arg, int k)
{
    stream *s = arg;
    const long from = (long)STREAM_VECTORS / 4 * k / s->parts * 4,
               to = (long)STREAM_VECTORS / 4 * (k + 1) / s->parts * 4;
    vector a = s->sum[k], b = a, c = a, d = a;
    for (long l = from; l < to && !s->writes; l += 4)
        a += s->at[l], b += s->at[l + 1], c += s->at[l + 2], d += s->at[l + 3];
    for (long l = from; l < to && s->writes; ++l) s->at[l] += 1.0;
    s->sum[k] = a + b + c + d;
}

/* The most of some, GB/s. */
static double rate_of(stream *s, const mbsr_parallel *parallel, int parts, int writes, int samples)
{
    double least = INFINITY;
    s->parts = parts;
    s->writes = writes;
    for (int k = 0; k < samples; ++k) {
        const double start = elapsed();
        if (parts > 1)
            parallel->run(parallel->user, parts, run_part, s);
        else
            run_part(s, 0);
        least = fmin(least, elapsed() - start);
    }
    return 1e-9 * (1 + writes) * (double)STREAM_VECTORS * (double)sizeof(vector) / least;
}

static void measure_memory(const mbsr_parallel *parallel, int samples)
{
    stream s = {.at = aligned_alloc(sizeof(vector), STREAM_VECTORS * sizeof(vector))};
    const int parts = parallel->workers < 64 ? parallel->workers : 64;
    if (!s.at) bench_check(MBSR_ERR_NO_MEMORY, "memory", NULL);
    memset(s.at, 0, STREAM_VECTORS * sizeof(vector));
    for (int writes = 0; writes < 2; ++writes) {
        const double one = rate_of(&s, parallel, 1, writes, samples),
                     many = rate_of(&s, parallel, parts, writes, samples);
        printf("# memory, %s: %.1f GB/s by one thread, %.1f by %d: ratio %.2f\n",
               writes ? "read and written" : "read", one, many, parts, many / one);
    }
    free(s.at);
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES, count = argc > 2 ? atoi(argv[2]) : 2;
    mbsr_threads *threads;
    mbsr_error error;
    if (samples < 1) return EXIT_FAILURE;
    bench_check(mbsr_threads_create(count, &threads, &error), "mbsr_threads_create", error.text);
    const mbsr_parallel parallel = mbsr_threads_parallel(threads);
    bench_header(stdout, "one evaluation by several threads");
    printf("# ns: elapsed, a body and state, medians; ratio: one thread to several, median of "
           "pairs\n");
    measure_memory(&parallel, samples);
    printf("tree,bodies,states,task,threads,ns_one,ns_threads,ratio\n");
    static const int sizes[] = {1023, 16383, 131071, 1048575};
    for (int k = 0; k < 4; ++k) measure_tree("binary", sizes[k], 1, &parallel, samples);
    for (int k = 1; k < 4; ++k) measure_tree("two_chains", sizes[k], 0, &parallel, samples);
    measure_batch(30, &parallel, samples);
    mbsr_threads_destroy(threads);
    return EXIT_SUCCESS;
}
