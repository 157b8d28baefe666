/* Forward and inverse dynamics of trees of rigid bodies in space, nanoseconds per body.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_trees folder [samples]     CSV on standard output
 *
 * The trees of the folder (tests/reference/trees) are those that the programs of bench/peers time
 * in other libraries; before they are timed their accelerations are compared with the reference. A
 * sample is the mean over as many calls as last about 5 ms; the samples of all trees are taken in
 * one random order. newton_factor and newton_solve linearise and solve the Newton system of the
 * momentum form. The calls *_batch take STATES states at once, the tree's first and others near
 * it; their time is that of one state. Trees of more than MOST_BODIES bodies are left out there,
 * for their memory. */
#include "bench.h"
#include "trees.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum {
    SAMPLES = 21,
    CALLS = 7,
    NEWTON = 3,
    FIRST_BATCH = 5,
    TREES = 14,
    STATES = 64,
    MOST_BODIES = 10000
};

static const double sample_time = 5e-3;
static const double newton_rate = 50.0; /* c of the Newton system, 1/s */
static const char *const call_name[CALLS] = {"forward",       "inverse",      "momentum",
                                             "newton_factor", "newton_solve", "forward_batch",
                                             "inverse_batch"};

static const struct {
    const char *name;
    int bodies, massless; /* 0 bodies: from the file */
} trees[TREES] = {{"massless_iii", 0, 0},
                  {"chain7", 0, 0},
                  {"chain30", 0, 0},
                  {"humanoid36", 0, 0},
                  {"btree1023", 0, 0},
                  {"chain1000", 0, 0},
                  {"made30", 30, 0},
                  {"made1000", 1000, 0},
                  {"half_massless30", 30, 2},
                  {"half_massless1000", 1000, 2},
                  {"made10000", 10000, 0},
                  {"made100000", 100000, 0},
                  {"half_massless100000", 100000, 2},
                  {"made1000000", 1000000, 0}};

typedef struct candidate {
    bench_model tree;
    mbsr_data *data;
    double *out, *y, *yp, *F;
    double build; /* s a body */
    mbsr_newton *newton;
    mbsr_batch *batch;
    double *q, *u, *tau, *many; /* STATES of each, of results too */
    int repeats[CALLS];
} candidate;

static int call(candidate *c, int which)
{
    const bench_model *t = &c->tree;
    switch (which) {
    case 0: return mbsr_forward_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, c->out);
    case 1: return mbsr_inverse_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, NULL, c->out);
    case 2: return mbsr_dae_residual(t->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, c->F);
    case 3: return mbsr_newton_factor(c->newton, c->data, 0.0, c->y, c->yp, newton_rate);
    case 4: return mbsr_newton_solve(c->newton, c->yp, c->F);
    case 5:
        return mbsr_batch_forward_dynamics(t->model, c->batch, 0.0, STATES, c->q, c->u, c->tau,
                                           c->many, NULL);
    default:
        return mbsr_batch_inverse_dynamics(t->model, c->batch, 0.0, STATES, c->q, c->u, c->tau,
                                           c->many, NULL);
    }
}

static int states_of(int which)
{
    return which < FIRST_BATCH ? 1 : STATES;
}

static bool is_timed(const candidate *c, int which)
{
    return which < FIRST_BATCH || c->tree.bodies <= MOST_BODIES;
}

static const char *error_text(const candidate *c, int which)
{
    if (which >= FIRST_BATCH) return mbsr_batch_error(c->batch)->text;
    return which < NEWTON ? mbsr_data_error(c->data)->text : mbsr_newton_error(c->newton)->text;
}

static double time_call(candidate *c, int which)
{
    if (!is_timed(c, which)) return 0.0;
    const double begin = bench_now();
    for (int k = 0; k < c->repeats[which]; ++k)
        bench_check(call(c, which), call_name[which], error_text(c, which));
    return (bench_now() - begin) / c->repeats[which] / c->tree.bodies / states_of(which) * 1e9;
}

static double measure(void *list, int which)
{
    return time_call((candidate *)list + which / CALLS, which % CALLS);
}

static double largest(int n, const double *x)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k]));
    return most;
}

static double difference(int n, const double *x, const double *should)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) {
        const double one = fabs(x[k] - should[k]);
        if (!(one <= most)) most = one; /* a NaN stays */
    }
    return most;
}

static void invert(candidate *c, const double *udot)
{
    bench_check(mbsr_inverse_dynamics(c->tree.model, c->data, 0.0, c->tree.q, c->tree.u, udot, NULL,
                                      c->out),
                "inverse", mbsr_data_error(c->data)->text);
}

/* How far the results are from the reference. Accelerations: relative to the largest of them.
 * Joint forces are small differences of large ones in a long tree: relative to the largest of those
 * that it takes when every other acceleration has the opposite sign. */
static double defect(candidate *c, int which)
{
    const bench_model *t = &c->tree;
    if (which == 0 || which == FIRST_BATCH) {
        bench_check(call(c, which), call_name[which], NULL);
        return difference(t->nu, which ? c->many : c->out, t->udot) / largest(t->nu, t->udot);
    }
    double *other = bench_allocate((size_t)t->nu, sizeof *other);
    for (int k = 0; k < t->nu; ++k) other[k] = k % 2 ? t->udot[k] : -t->udot[k];
    invert(c, other);
    free(other);
    const double size = fmax(largest(t->nu, t->tau), largest(t->nu, c->out));
    invert(c, t->udot);
    return difference(t->nu, c->out, t->tau) / size;
}

/* States of which each number is off the tree's by at most 0.1. */
static double *spread(int n, const double *x)
{
    uint64_t seed = 2;
    double *many = bench_allocate((size_t)n * STATES, sizeof *many);
    for (int k = 0; k < n * STATES; ++k)
        many[k] = x[k % n] + (k < n ? 0.0 : bench_uniform(&seed, -0.1, 0.1));
    return many;
}

static void open_batch(candidate *c)
{
    bench_check(mbsr_batch_create(c->tree.model, &c->batch, NULL), "mbsr_batch_create", NULL);
    c->q = spread(c->tree.nq, c->tree.q);
    c->u = spread(c->tree.nu, c->tree.u);
    c->tau = spread(c->tree.nu, c->tree.tau);
    c->many = bench_allocate((size_t)c->tree.nu * STATES, sizeof(double));
}

static void open_candidate(candidate *c, int k, const char *folder)
{
    const double begin = bench_now();
    if (trees[k].bodies)
        bench_make_chain(&c->tree, trees[k].bodies, trees[k].massless, 0);
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
    bench_check(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &c->newton, NULL),
                "mbsr_newton_create", NULL);
    for (size_t l = 0; l < size; ++l)
        c->yp[l] = 0.01 * (double)(l % 7); /* r of newton_solve, too */
    if (c->tree.bodies <= MOST_BODIES) open_batch(c);
    for (int which = 0; which < CALLS; ++which) {
        const double scale = c->tree.bodies * states_of(which) * 1e-9;
        c->repeats[which] = 1;
        double once = time_call(c, which) * scale;
        once = fmin(once, time_call(c, which) * scale);
        c->repeats[which] = once > 0.0 ? 1 + (int)(sample_time / once) : 1;
    }
}

/* One line; what has no reference has no defect. */
static void report(candidate *c, int k, int samples, double *sample)
{
    const int tree = k / CALLS, which = k % CALLS;
    if (!is_timed(c, which)) return;
    const bench_quartiles s = bench_statistics(samples, sample + k * samples);
    char error[16] = "";
    if ((which < 2 || which == FIRST_BATCH) && c->tree.udot)
        snprintf(error, sizeof error, "%.2g", defect(c, which));
    printf("%s,%d,%s,%s,%.2f,%zu,%.1f,%.1f,%.1f\n", trees[tree].name, c->tree.bodies,
           call_name[which], error, 1e6 * c->build,
           mbsr_data_size_lean(c->tree.model) / (size_t)c->tree.bodies, s.min, s.median, s.q3);
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
    double *sample = bench_allocate((size_t)(TREES * CALLS * samples), sizeof *sample);
    bench_sample_all(TREES * CALLS, samples, measure, list, sample);
    for (int k = 0; k < TREES * CALLS; ++k) report(list + k / CALLS, k, samples, sample);
    return 0;
}
