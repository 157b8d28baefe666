/* Forward and inverse dynamics of trees of rigid bodies in space, nanoseconds per body.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_trees folder [samples]     CSV on standard output
 *
 * The trees of the folder (tests/reference/trees) are those that the programs of bench/peers time
 * in other libraries; before they are timed their accelerations are compared with the reference. A
 * sample is the mean over as many calls as last about 5 ms; the samples of all trees are taken in
 * one random order. */
#include "bench.h"
#include "trees.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 21, CALLS = 3, TREES = 13 };

static const double sample_time = 5e-3;
static const char *const call_name[CALLS] = {"forward", "inverse", "momentum"};

static const struct {
    const char *name;
    int bodies, massless; /* 0 bodies: from the file */
} trees[TREES] = {
    {"chain7", 0, 0},           {"chain30", 0, 0},          {"humanoid36", 0, 0},
    {"btree1023", 0, 0},        {"chain1000", 0, 0},        {"made30", 30, 0},
    {"made1000", 1000, 0},      {"half_massless30", 30, 2}, {"half_massless1000", 1000, 2},
    {"made10000", 10000, 0},    {"made100000", 100000, 0},  {"half_massless100000", 100000, 2},
    {"made1000000", 1000000, 0}};

typedef struct candidate {
    bench_model tree;
    mbsr_data *data;
    double *out, *y, *yp, *F;
    double build; /* s a body */
    int repeats[CALLS];
} candidate;

static int call(candidate *c, int which)
{
    const bench_model *t = &c->tree;
    switch (which) {
    case 0: return mbsr_forward_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, c->out);
    case 1: return mbsr_inverse_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, c->out);
    default: return mbsr_dae_residual(t->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, c->F);
    }
}

static double time_call(candidate *c, int which)
{
    const double begin = bench_now();
    for (int k = 0; k < c->repeats[which]; ++k)
        bench_check(call(c, which), call_name[which], mbsr_data_error(c->data)->text);
    return (bench_now() - begin) / c->repeats[which] / c->tree.bodies * 1e9;
}

/* Largest difference from the reference, relative to the largest acceleration. */
static double defect(candidate *c)
{
    double difference = 0.0, largest = 0.0;
    bench_check(call(c, 0), "forward", mbsr_data_error(c->data)->text);
    for (int k = 0; k < c->tree.nu && c->tree.udot; ++k) {
        difference = fmax(difference, fabs(c->out[k] - c->tree.udot[k]));
        largest = fmax(largest, fabs(c->tree.udot[k]));
    }
    return largest > 0.0 ? difference / largest : 0.0;
}

static void open_candidate(candidate *c, int k, const char *folder)
{
    const double begin = bench_now();
    if (trees[k].bodies)
        bench_make_chain(&c->tree, trees[k].bodies, trees[k].massless);
    else
        bench_read_tree(&c->tree, folder, trees[k].name);
    c->build = (bench_now() - begin) / c->tree.bodies;
    const mbsr_model *m = c->tree.model;
    bench_check(mbsr_data_create_lean(m, &c->data, NULL), "mbsr_data_create_lean", NULL);
    mbsr_data *full = NULL; /* for the start */
    bench_check(mbsr_data_create(m, &full, NULL), "mbsr_data_create", NULL);
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    c->out = bench_allocate((size_t)c->tree.nu, sizeof(double));
    c->y = bench_allocate(size, sizeof(double));
    c->yp = bench_allocate(size, sizeof(double));
    c->F = bench_allocate(size, sizeof(double));
    bench_check(mbsr_dae_pack(m, full, MBSR_DAE_MOMENTUM, 0.0, c->tree.q, c->tree.u, c->y),
                "mbsr_dae_pack", mbsr_data_error(full)->text);
    mbsr_data_destroy(full);
    for (int which = 0; which < CALLS; ++which) {
        c->repeats[which] = 1;
        double once = time_call(c, which) * c->tree.bodies * 1e-9;
        once = fmin(once, time_call(c, which) * c->tree.bodies * 1e-9);
        c->repeats[which] = 1 + (int)(sample_time / once);
    }
}

int main(int argc, char **argv)
{
    static candidate list[TREES];
    const int samples = argc > 2 ? atoi(argv[2]) : SAMPLES;
    if (argc < 2 || samples < 1) {
        fprintf(stderr, "bench_trees folder [samples]\n");
        return 2;
    }
    bench_header(stdout, "dynamics of trees of rigid bodies: CPU time per body");
    printf("tree,bodies,call,defect,build_us,data_bytes,min_ns,median_ns,q3_ns\n");
    for (int k = 0; k < TREES; ++k) open_candidate(list + k, k, argv[1]);
    const int total = TREES * CALLS * samples;
    double *sample = bench_allocate((size_t)total, sizeof *sample);
    int *order = bench_allocate((size_t)total, sizeof *order);
    uint64_t seed = 1;
    for (int k = 0; k < total; ++k) order[k] = k;
    bench_shuffle(&seed, (size_t)total, order);
    for (int k = 0; k < total; ++k) {
        const int tree = order[k] / samples / CALLS, which = order[k] / samples % CALLS;
        sample[order[k]] = time_call(list + tree, which);
    }
    for (int k = 0; k < TREES; ++k) {
        const double error = defect(list + k);
        for (int which = 0; which < CALLS; ++which) {
            const bench_quartiles s =
                bench_statistics(samples, sample + (k * CALLS + which) * samples);
            printf("%s,%d,%s,%.2g,%.2f,%zu,%.1f,%.1f,%.1f\n", trees[k].name, list[k].tree.bodies,
                   call_name[which], error, 1e6 * list[k].build,
                   mbsr_data_size_lean(list[k].tree.model) / (size_t)list[k].tree.bodies, s.min,
                   s.median, s.q3);
        }
    }
    return 0;
}
