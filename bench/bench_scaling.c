/* Time per body of the stages and of the whole residual against the number of bodies, for trees of
 * several shapes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_scaling [samples [largest N]]     CSV on standard output, progress on standard error
 *
 * Bodies are rods of 1 m and 1 kg in the plane, hinged to the end of their predecessor, with a
 * spring-damper in each hinge and under gravity. In all cases but one every fourth body is a dummy
 * link: zero mass, zero length, hinged like the others. Turning it moves no mass whatever hangs on
 * it, so that its block D is zero and the recursion has to skip it. States are small random angles,
 * rates and accelerations.
 *
 * A sample is the mean over as many calls of one stage as last 5 ms. All samples of all cases,
 * sizes and stages are taken in one random order, so that a disturbance does not hit one of them
 * only. */
#include "bench.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <stdlib.h>

enum { SAMPLES = 21, STAGES = 7, SIZES = 9, CASES = 5, GROUP = 4 };

static const double sample_time = 5e-3;
static const int sizes[SIZES] = {10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000};

static const char *const stage_name[STAGES] = {"positions",
                                               "velocities",
                                               "forces",
                                               "backward",
                                               "forward",
                                               "residual_recursive",
                                               "residual_inverse_dynamics"};

enum { FIRST_RESIDUAL = 5 };

typedef enum tree_shape { CHAIN, BINARY, RANDOM, RANDOM_SORTED } tree_shape;

static const struct bench_case {
    const char *name;
    tree_shape shape;
    int dummies;
} cases[CASES] = {{"chain", CHAIN, 1},
                  {"binary", BINARY, 1},
                  {"random", RANDOM, 1},
                  {"random_depth_first", RANDOM_SORTED, 1},
                  {"chain", CHAIN, 0}};

/* One model with its state; y = (q, u), yp = (q', u'). */
typedef struct bench_tree {
    mbsr_model *model;
    mbsr_data *data;
    int N;
    int dummies; /* rank-deficient joints */
    double *y, *yp, *F;
    int repeats[STAGES];
} bench_tree;

/* ---- shapes ---------------------------------------------------------------------------------- */

/* Predecessor and kind of every body, by id. */
typedef struct outline {
    int *parent;
    int *dummy;
} outline;

static outline make_outline(int N)
{
    return (outline){.parent = bench_allocate((size_t)N, sizeof(int)),
                     .dummy = bench_allocate((size_t)N, sizeof(int))};
}

static void free_outline(outline o)
{
    free(o.parent);
    free(o.dummy);
}

static int parent_of(tree_shape shape, int body, uint64_t *random)
{
    if (body == 0) return MBSR_GROUND;
    switch (shape) {
    case CHAIN: return body - 1;
    case BINARY: return (body - 1) / 2;
    default: return (int)(bench_random(random) % (uint64_t)body);
    }
}

/* The same tree with its bodies numbered depth first, which is how the library stores them. */
static outline sort_depth_first(int N, outline from)
{
    const outline to = make_outline(N);
    int *first = bench_allocate((size_t)N, sizeof(int));
    int *next = bench_allocate((size_t)N, sizeof(int));
    int *number = bench_allocate((size_t)N, sizeof(int));
    int count = 0, at = 0;
    for (int k = 0; k < N; ++k) first[k] = next[k] = MBSR_NONE;
    for (int k = N - 1; k > 0; --k) {
        next[k] = first[from.parent[k]];
        first[from.parent[k]] = k;
    }
    while (at >= 0) {
        number[at] = count;
        to.parent[count] = at == 0 ? MBSR_GROUND : number[from.parent[at]];
        to.dummy[count++] = from.dummy[at];
        int onward = first[at];
        while (onward < 0 && at >= 0) {
            onward = next[at];
            at = from.parent[at];
        }
        at = onward;
    }
    free(first);
    free(next);
    free(number);
    free_outline(from);
    return to;
}

static outline draw_outline(const struct bench_case *c, int N, uint64_t *random)
{
    const outline o = make_outline(N);
    for (int k = 0; k < N; ++k) {
        o.parent[k] = parent_of(c->shape, k, random);
        o.dummy[k] = c->dummies && k % GROUP == GROUP - 1;
    }
    return c->shape == RANDOM_SORTED ? sort_depth_first(N, o) : o;
}

/* ---- models ---------------------------------------------------------------------------------- */

/* A rod has its axes in the middle, hinges at y = 0.5 and y = -0.5; a dummy link has everything at
 * its origin. */
static void add_body(bench_tree *tree, outline o, int id)
{
    const double middle[2] = {0.0, 0.0};
    const mbsr_planar_frame centre = {0.0, 0.0, 0.0}, top = {0.0, 0.5, 0.0}, end = {0.0, -0.5, 0.0};
    const int on_centre = o.parent[id] == MBSR_GROUND || o.dummy[o.parent[id]];
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = o.parent[id];
    body.joint = mbsr_joint_planar_revolute(on_centre ? centre : end, o.dummy[id] ? centre : top);
    body.inertia = o.dummy[id] ? mbsr_inertia_zero() : mbsr_inertia_planar(1.0, middle, 1.0 / 12.0);
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, 1.0, 0.1, 0.0);
    const mbsr_error *error = mbsr_model_error(tree->model);
    bench_check(mbsr_model_add_body(tree->model, &body, NULL), "body", error->text);
    bench_check(mbsr_model_add_force(tree->model, &spring, NULL), "spring", error->text);
}

static void make_model(bench_tree *tree, outline o)
{
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    bench_check(mbsr_model_create(NULL, &tree->model, NULL), "model", NULL);
    const mbsr_error *error = mbsr_model_error(tree->model);
    for (int id = 0; id < tree->N; ++id) add_body(tree, o, id);
    bench_check(mbsr_model_add_force(tree->model, &gravity, NULL), "gravity", error->text);
    bench_check(mbsr_model_finish(tree->model), "finish", error->text);
    bench_check(mbsr_data_create(tree->model, &tree->data, NULL), "data", NULL);
}

/* ---- stages ---------------------------------------------------------------------------------- */

static int run_stage(bench_tree *tree, int stage)
{
    const mbsr_model *m = tree->model;
    mbsr_data *d = tree->data;
    const int N = tree->N;
    switch (stage) {
    case 0: return mbsr_stage_positions(m, d, 0.0, tree->y);
    case 1: return mbsr_stage_velocities(m, d, tree->y + N);
    case 2: return mbsr_stage_forces(m, d, NULL);
    case 3: return mbsr_stage_backward(m, d);
    case 4: return mbsr_stage_forward(m, d, tree->yp + N, tree->F);
    case 5: return mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.0, tree->y, tree->yp, tree->F);
    default:
        return mbsr_dae_residual(m, d, MBSR_DAE_INVERSE_DYNAMICS, 0.0, tree->y, tree->yp, tree->F);
    }
}

static void run_checked(bench_tree *tree, int stage)
{
    bench_check(run_stage(tree, stage), stage_name[stage], mbsr_data_error(tree->data)->text);
}

/* A measurement means nothing unless the dummy links, and no other joints, are rank-deficient. */
static void check_rank(bench_tree *tree, const char *name)
{
    run_checked(tree, FIRST_RESIDUAL);
    const int deficient = tree->N - mbsr_total_rank(tree->model, tree->data);
    if (deficient == tree->dummies) return;
    fprintf(stderr, "%s, N = %d: %d deficient joints, but %d dummy links\n", name, tree->N,
            deficient, tree->dummies);
    exit(EXIT_FAILURE);
}

/* Model and random state. */
static void make_tree(bench_tree *tree, const struct bench_case *c, int N)
{
    uint64_t random = (uint64_t)N;
    const outline o = draw_outline(c, N, &random);
    tree->N = N;
    make_model(tree, o);
    for (int id = 0; id < N; ++id) tree->dummies += o.dummy[id];
    free_outline(o);
    tree->y = bench_allocate(2 * (size_t)N, sizeof(double));
    tree->yp = bench_allocate(2 * (size_t)N, sizeof(double));
    tree->F = bench_allocate(2 * (size_t)N, sizeof(double));
    for (int k = 0; k < 2 * N; ++k) {
        tree->y[k] = bench_uniform(&random, -0.1, 0.1);
        tree->yp[k] = bench_uniform(&random, -0.1, 0.1);
    }
    for (int stage = 0; stage < STAGES; ++stage) tree->repeats[stage] = 1;
    check_rank(tree, c->name);
}

static void free_tree(bench_tree *tree)
{
    mbsr_data_destroy(tree->data);
    mbsr_model_destroy(tree->model);
    free(tree->y);
    free(tree->yp);
    free(tree->F);
}

/* ---- measurement ----------------------------------------------------------------------------- */

/* Seconds per call. The stages before, and one call of the stage itself, come first, not timed. */
static double measure(bench_tree *tree, int stage)
{
    for (int before = stage < FIRST_RESIDUAL ? 0 : stage; before <= stage; ++before) {
        run_checked(tree, before);
    }
    for (;;) {
        const int repeats = tree->repeats[stage];
        const double start = bench_now();
        for (int k = 0; k < repeats; ++k) run_checked(tree, stage);
        const double time = bench_now() - start;
        if (time >= sample_time) return time / repeats;
        const double factor = time > 0.05 * sample_time ? 1.2 * sample_time / time : 20.0;
        tree->repeats[stage] = (int)(factor * repeats) + 1;
    }
}

/* sample[((c * size_count + s) * STAGES + stage) * samples + k]: seconds per call. */
typedef struct plan {
    int samples, size_count;
    bench_tree *tree; /* CASES x size_count */
    double *sample;   /* CASES x size_count x STAGES x samples */
} plan;

static void measure_all(plan *p)
{
    const int count = CASES * p->size_count * STAGES * p->samples;
    int *order = bench_allocate((size_t)count, sizeof *order);
    uint64_t random = 1;
    for (int k = 0; k < count; ++k) order[k] = k;
    bench_shuffle(&random, (size_t)count, order);
    for (int k = 0; k < count; ++k) {
        const int job = order[k], stage = job / p->samples % STAGES;
        p->sample[job] = measure(p->tree + job / p->samples / STAGES, stage);
        if (k % 500 == 0) fprintf(stderr, "sample %d of %d\n", k, count);
    }
    free(order);
}

/* ---- output ---------------------------------------------------------------------------------- */

static double share(const struct bench_case *c)
{
    return c->dummies ? 1.0 / GROUP : 0.0;
}

/* CSV lines of one case and stage; returns the line through log(median time) over log(N). */
static bench_line report(plan *p, int c, int stage)
{
    double N[SIZES], median[SIZES];
    for (int s = 0; s < p->size_count; ++s) {
        const int at = c * p->size_count + s;
        const bench_tree *t = p->tree + at;
        const double per_body = 1e9 / t->N;
        const bench_quartiles time =
            bench_statistics(p->samples, p->sample + (at * STAGES + stage) * p->samples);
        printf("%s,%.2f,%s,%d,%d,%.2f,%.2f,%.2f,%.2f,%d\n", cases[c].name, share(cases + c),
               stage_name[stage], t->N, t->dummies, per_body * time.median, per_body * time.min,
               per_body * time.q1, per_body * time.q3, p->samples);
        N[s] = t->N;
        median[s] = time.median;
    }
    return bench_fit_power(p->size_count, N, median);
}

static void report_all(plan *p)
{
    bench_line line[CASES * STAGES];
    printf("shape,massless_share,stage,N,deficient_joints,ns_per_body,min,q1,q3,"
           "samples\n");
    for (int k = 0; k < CASES * STAGES; ++k) line[k] = report(p, k / STAGES, k % STAGES);
    printf("# least squares: slope of log(median time of a call) over log(N), and its standard "
           "error\n");
    printf("# shape,massless_share,stage,slope,standard_error\n");
    for (int k = 0; k < CASES * STAGES; ++k) {
        const struct bench_case *c = cases + k / STAGES;
        printf("# %s,%.2f,%s,%.4f,%.4f\n", c->name, share(c), stage_name[k % STAGES], line[k].slope,
               line[k].error);
    }
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES;
    const int largest = argc > 2 ? atoi(argv[2]) : sizes[SIZES - 1];
    plan p = {.samples = samples};
    while (p.size_count < SIZES && sizes[p.size_count] <= largest) ++p.size_count;
    if (samples < 1 || p.size_count < 2) {
        fprintf(stderr, "usage: bench_scaling [samples [largest N >= %d]]\n", sizes[1]);
        return EXIT_FAILURE;
    }
    bench_header(stdout, "libmbsrank: time per body against the number of bodies, planar trees of "
                         "rods, d = 3, n = 1");
    p.tree = bench_allocate((size_t)(CASES * p.size_count), sizeof *p.tree);
    p.sample = bench_allocate((size_t)(CASES * p.size_count * STAGES * samples), sizeof *p.sample);
    for (int k = 0; k < CASES * p.size_count; ++k)
        make_tree(p.tree + k, cases + k / p.size_count, sizes[k % p.size_count]);
    measure_all(&p);
    report_all(&p);
    for (int k = 0; k < CASES * p.size_count; ++k) free_tree(p.tree + k);
    free(p.sample);
    free(p.tree);
    return EXIT_SUCCESS;
}
