/* Calls whose instructions are counted: under callgrind, with every other cost left out, a dump
 * follows each call of `measured` (count.sh). Standard output has one line a dump:
 *
 *   kernel tree call bodies
 *
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   instructions_count folder     folder: tests/reference/trees */
#include "batch/build.h"
#include "bench.h"
#include "sweeps/build.h"
#include "trees.h"

#include <mbsrank/index.h>

#include <stdio.h>
#include <stdlib.h>

enum {
    CALLS = 5,
    ACTUATED = CALLS,
    FORWARD_BATCH,
    INVERSE_BATCH,
    REPORT,
    ALL_CALLS,
    TREES = 7,
    LOOPS = 26,
    STATES = 16 /* of a batch: a multiple of all kernels' lanes */
};

static const char *const call_name[ALL_CALLS] = {"forward",       "inverse",       "momentum",
                                                 "factor",        "solve",         "actuated",
                                                 "forward_batch", "inverse_batch", "report"};

static const struct {
    const char *name;
    int bodies, massless, springs;             /* of a chain; 0 bodies: from the file */
    void (*make)(bench_model *tree, int size); /* by `size`, in the place of a chain */
    int size;
    bool batch; /* at several states, too */
} trees[TREES] = {{"chain30", 0, 0, 0, NULL, 0, true},
                  {"humanoid36", 0, 0, 0, NULL, 0, true},
                  {"btree1023", 0, 0, 0, NULL, 0, true},
                  {"half_massless30", 30, 2, 0, NULL, 0, false},
                  {"sprung30", 30, 0, 1, NULL, 0, false},
                  {"segments31", 0, 0, 0, bench_make_segments, 31, false},
                  {"beam100", 0, 0, 0, bench_make_beam, 100, false}};

typedef struct counted {
    bench_model tree;
    mbsr_data *data;
    mbsr_newton *newton;
    double *out, *y, *yp, *F;
    int *motor, motors; /* joints with motors, in closed models */
    mbsr_batch *batch;
    double *q, *u, *tau, *many; /* STATES of each, of results too */
} counted;

static int report_index(counted *c)
{
    mbsr_index_report *report;
    const int status =
        mbsr_index_report_create(c->tree.model, c->data, 0.0, c->tree.q, c->tree.u, &report);
    mbsr_index_report_destroy(c->tree.model, report);
    return status;
}

static int call(counted *c, int which)
{
    const bench_model *t = &c->tree;
    switch (which) {
    case 0: return mbsr_forward_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, c->out);
    case 1: return mbsr_inverse_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau, NULL, c->out);
    case 2: return mbsr_dae_residual(t->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, c->F);
    case 3: return mbsr_newton_factor(c->newton, c->data, 0.0, c->y, c->yp, 100.0);
    case 4: return mbsr_newton_solve(c->newton, c->yp, c->F);
    case FORWARD_BATCH:
        return mbsr_batch_forward_dynamics(t->model, c->batch, 0.0, STATES, c->q, c->u, c->tau,
                                           c->many, NULL);
    case INVERSE_BATCH:
        return mbsr_batch_inverse_dynamics(t->model, c->batch, 0.0, STATES, c->q, c->u, c->tau,
                                           c->many, NULL);
    case REPORT: return report_index(c);
    default:
        return mbsr_inverse_dynamics(t->model, c->data, 0.0, t->q, t->u, t->tau,
                                     &(mbsr_motors){c->motors, c->motor}, c->out);
    }
}

/* Known to callgrind by its name; never inlined, as it is called through a pointer. */
int measured(counted *c, int which);

int measured(counted *c, int which)
{
    return call(c, which);
}

static int (*volatile measure)(counted *c, int which) = measured;

/* Data, solver and vectors of c->tree. */
static void make_counted(counted *c)
{
    const mbsr_model *m = c->tree.model;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    bench_check(mbsr_data_create(m, &c->data, NULL), "mbsr_data_create", NULL);
    bench_check(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &c->newton, NULL),
                "mbsr_newton_create", NULL);
    c->out = bench_allocate((size_t)c->tree.nu, sizeof(double));
    c->y = bench_allocate(size, sizeof(double));
    c->yp = bench_allocate(size, sizeof(double));
    c->F = bench_allocate(size, sizeof(double));
    bench_check(mbsr_dae_pack(m, c->data, MBSR_DAE_MOMENTUM, 0.0, c->tree.q, c->tree.u, c->y),
                "mbsr_dae_pack", mbsr_data_error(c->data)->text);
    c->motor = bench_allocate((size_t)c->tree.nu, sizeof(int));
    c->motors = 0;
}

static void open_counted(counted *c, int k, const char *folder)
{
    if (trees[k].make)
        trees[k].make(&c->tree, trees[k].size);
    else if (trees[k].bodies)
        bench_make_chain(&c->tree, trees[k].bodies, trees[k].massless, trees[k].springs);
    else
        bench_read_tree(&c->tree, folder, trees[k].name);
    make_counted(c);
}

static void close_counted(counted *c)
{
    mbsr_newton_destroy(c->newton);
    mbsr_data_destroy(c->data);
    bench_free_tree(&c->tree);
    free(c->out);
    free(c->y);
    free(c->yp);
    free(c->F);
    free(c->motor);
}

/* Models with closed loops, and without: what an implicit integrator calls. */
enum {
    FOURBARS,
    MASSLESS,
    STIFF,
    RING,
    OPEN,
    AT_LEAF,
    AT_ROOT,
    IN_SPACE,
    IN_SPACE_MASSLESS,
    IN_SPACE_OPEN,
    GEARS,
    GEARS_OPEN,
    HANDS,
    HANDS_OPEN,
    BARS
};
static const struct {
    const char *name;
    int kind, count;
    bench_coupler on; /* in space */
} loops[LOOPS] = {{"fourbars10", FOURBARS, 10, BENCH_HINGE},
                  {"fourbars100", FOURBARS, 100, BENCH_HINGE},
                  {"massless10", MASSLESS, 10, BENCH_HINGE},
                  {"massless100", MASSLESS, 100, BENCH_HINGE},
                  {"stiff10", STIFF, 10, BENCH_HINGE},
                  {"stiff100", STIFF, 100, BENCH_HINGE},
                  {"ring10", RING, 10, BENCH_HINGE},
                  {"ring100", RING, 100, BENCH_HINGE},
                  {"open_chain1000", OPEN, 1000, BENCH_HINGE},
                  {"loop_at_leaf1000", AT_LEAF, 1000, BENCH_HINGE},
                  {"loop_at_root1000", AT_ROOT, 1000, BENCH_HINGE},
                  {"universal10", IN_SPACE, 10, BENCH_UNIVERSAL},
                  {"universal100", IN_SPACE, 100, BENCH_UNIVERSAL},
                  {"universal_massless10", IN_SPACE_MASSLESS, 10, BENCH_UNIVERSAL},
                  {"universal_massless100", IN_SPACE_MASSLESS, 100, BENCH_UNIVERSAL},
                  {"open_universal", IN_SPACE_OPEN, 100, BENCH_UNIVERSAL},
                  {"ball10", IN_SPACE, 10, BENCH_BALL},
                  {"ball100", IN_SPACE, 100, BENCH_BALL},
                  {"open_ball", IN_SPACE_OPEN, 100, BENCH_BALL},
                  {"gears10", GEARS, 10, BENCH_HINGE},
                  {"gears100", GEARS, 100, BENCH_HINGE},
                  {"open_gears", GEARS_OPEN, 100, BENCH_HINGE},
                  {"hands10", HANDS, 10, BENCH_HINGE},
                  {"hands100", HANDS, 100, BENCH_HINGE},
                  {"open_hands", HANDS_OPEN, 100, BENCH_HINGE},
                  {"bars300", BARS, 300, BENCH_HINGE}};

static void make_loops(bench_model *tree, int k)
{
    const int kind = loops[k].kind, number = loops[k].count;
    if (kind == BARS)
        bench_make_crowd(tree, BENCH_BARS, number);
    else if (kind >= GEARS)
        bench_make_gearing(tree, kind < HANDS ? BENCH_GEARS : BENCH_HANDS, number,
                           kind == GEARS || kind == HANDS ? BENCH_RIGID : BENCH_OPEN);
    else if (kind == RING)
        bench_make_ring(tree, number, 1);
    else if (kind <= STIFF)
        bench_make_fourbars(tree, number, kind == MASSLESS,
                            kind == STIFF ? BENCH_STIFF : BENCH_RIGID);
    else if (kind >= IN_SPACE)
        bench_make_linkages(tree, number, loops[k].on, kind == IN_SPACE_MASSLESS,
                            kind != IN_SPACE_OPEN);
    else
        bench_make_one_loop(tree, number, kind == AT_ROOT, kind != OPEN);
}

/* All joint rates but two of a ring and, of a piece, as many as its rigid pin holds. */
static void choose_motors(counted *c, int k)
{
    const int kind = loops[k].kind, nu = c->tree.nu, rates = nu / loops[k].count;
    const int held = kind >= IN_SPACE ? 3 : kind < STIFF ? 2 : 0;
    for (int j = 0; j < nu; ++j) {
        if (kind == RING ? j != 3 && j != 6 : j % rates < rates - held) c->motor[c->motors++] = j;
    }
}

static void count_loops(int k)
{
    counted c;
    make_loops(&c.tree, k);
    make_counted(&c);
    choose_motors(&c, k);
    const bool closed = mbsr_model_rows(c.tree.model) > 0, coupled = loops[k].kind >= GEARS,
               small = loops[k].kind <= RING || (loops[k].kind >= IN_SPACE && !coupled);
    for (int which = 0; which <= ACTUATED; ++which) {
        const bool wanted = which == 0          ? closed && (small || coupled)
                            : which == ACTUATED ? closed && small
                                                : which > 1;
        if (!wanted) continue;
        bench_check(call(&c, which), call_name[which], mbsr_data_error(c.data)->text);
        bench_check(measure(&c, which), call_name[which], mbsr_data_error(c.data)->text);
        printf("loops %s %s %d\n", loops[k].name, call_name[which], c.tree.bodies);
    }
    close_counted(&c);
}

/* Factor and solution by the front alone. */
static void count_front(counted *c, const char *name)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = 1;
    mbsr_newton_destroy(c->newton);
    bench_check(mbsr_newton_create(c->tree.model, MBSR_DAE_MOMENTUM, &opt, &c->newton, NULL),
                "mbsr_newton_create", NULL);
    for (int which = 3; which <= 4; ++which) {
        bench_check(call(c, which), call_name[which], mbsr_newton_error(c->newton)->text);
        bench_check(measure(c, which), call_name[which], mbsr_newton_error(c->newton)->text);
        printf("%s %s %d\n", name, call_name[which], c->tree.bodies);
    }
}

/* The general step of a hinge, in a chain and in a tree. */
static void count_hinges(const char *folder)
{
    counted c;
    bench_make_chain(&c.tree, 100, 0, 1);
    make_counted(&c);
    count_front(&c, "front chain100");
    close_counted(&c);
    bench_read_tree(&c.tree, folder, "humanoid36");
    make_counted(&c);
    count_front(&c, "front humanoid36");
    close_counted(&c);
}

/* Many loops that close on one body, by the front. */
static void count_crowds(void)
{
    static const struct {
        const char *name;
        bench_crowd kind;
    } crowds[] = {{"bars", BENCH_BARS}, {"carrier", BENCH_CARRIER}, {"legs", BENCH_LEGS}};
    for (int k = 0; k < 6; ++k) {
        const int number = k % 2 ? 100 : 20;
        char name[32];
        counted c;
        bench_make_crowd(&c.tree, crowds[k / 2].kind, number);
        make_counted(&c);
        snprintf(name, sizeof name, "crowds %s%d", crowds[k / 2].name, number);
        count_front(&c, name);
        close_counted(&c);
    }
}

/* A report takes memory and time as bodies times directions. */
static void count_reports(void)
{
    for (int number = 10; number <= 40; number *= 4) {
        counted c;
        bench_make_sprung_cranks(&c.tree, number);
        make_counted(&c);
        bench_check(call(&c, REPORT), call_name[REPORT], mbsr_data_error(c.data)->text);
        bench_check(measure(&c, REPORT), call_name[REPORT], mbsr_data_error(c.data)->text);
        printf("crowds cranks%d report %d\n", number, c.tree.bodies * number);
        close_counted(&c);
    }
}

static void count(counted *c, const char *tree, const mbsri_sweep_kernels *kernels)
{
    c->tree.model->tree.plain->kernels = c->tree.model->tree.newton->kernels =
        c->tree.model->tree.evaluated->kernels = kernels;
    /* the solver chooses its own by these */
    mbsr_newton_destroy(c->newton);
    bench_check(mbsr_newton_create(c->tree.model, MBSR_DAE_MOMENTUM, NULL, &c->newton, NULL),
                "mbsr_newton_create", NULL);
    const int status = mbsr_forward_dynamics(c->tree.model, c->data, 0.0, c->tree.q, c->tree.u,
                                             c->tree.tau, c->out);
    for (int which = status == MBSR_UNDETERMINED ? 1 : 0; which < CALLS; ++which) {
        /* the first call finds the functions of shared libraries */
        bench_check(call(c, which), call_name[which], mbsr_data_error(c->data)->text);
        bench_check(measure(c, which), call_name[which], mbsr_data_error(c->data)->text);
        printf("%s %s %s %d\n", kernels->name, tree, call_name[which], c->tree.bodies);
    }
}

/* The same state STATES times. */
static double *repeated(int n, const double *x)
{
    double *many = bench_allocate((size_t)(n * STATES), sizeof *many);
    for (int k = 0; k < n * STATES; ++k) many[k] = x[k % n];
    return many;
}

/* For each body and state. */
static void count_batch(counted *c, const char *tree, const mbsri_batch_kernels *kernels)
{
    const bench_model *t = &c->tree;
    bench_check(mbsri_batch_make(t->model, kernels, &c->batch, NULL), "mbsri_batch_make", NULL);
    c->q = repeated(t->nq, t->q);
    c->u = repeated(t->nu, t->u);
    c->tau = repeated(t->nu, t->tau);
    c->many = repeated(t->nu, t->tau);
    for (int which = FORWARD_BATCH; which <= INVERSE_BATCH; ++which) {
        bench_check(call(c, which), call_name[which], mbsr_batch_error(c->batch)->text);
        bench_check(measure(c, which), call_name[which], mbsr_batch_error(c->batch)->text);
        bench_check(mbsr_batch_one_by_one(c->batch), call_name[which], "states go one by one");
        printf("%s %s %s %d\n", kernels->name, tree, call_name[which], t->bodies * STATES);
    }
    mbsr_batch_destroy(c->batch);
    free(c->q);
    free(c->u);
    free(c->tau);
    free(c->many);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: instructions_count folder\n");
        return 2;
    }
    for (int k = 0; k < TREES; ++k) {
        counted c;
        open_counted(&c, k, argv[1]);
        count(&c, trees[k].name, &mbsri_sweeps_base);
        if (trees[k].batch) count_batch(&c, trees[k].name, &mbsri_batch_base);
#if defined(MBSR_WITH_V3)
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
            count(&c, trees[k].name, &mbsri_sweeps_v3);
            if (trees[k].batch) count_batch(&c, trees[k].name, &mbsri_batch_v3);
        }
#endif
        close_counted(&c);
    }
    for (int k = 0; k < LOOPS; ++k) count_loops(k);
    count_hinges(argv[1]);
    count_crowds();
    count_reports();
    return 0;
}
