/* Models with closed loops: time per body of the residual of the momentum form, of factoring and
 * solving its Newton system, of forward dynamics, of inverse dynamics with motors on as many joints
 * as move freely, and of a start.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_loops [samples]            CSV on standard output
 *   bench_loops --write FOLDER
 *       mechanisms for other libraries (peers/loops.h) to files of this folder
 *
 * `fourbars`: chains of rods in the plane with a four-bar on each (4 bodies and 2 rows a piece),
 * with couplers that have mass or none (`massless`), with stiff pins (`stiff`, 1e10 N/m); `ring`:
 * one loop of rods; `linkages`: four-bars in space, whose couplers hang on hinges or on universal
 * joints; `gears`, `hands`, `differentials`: joints that are coupled (trees.h). `by_blocks`: the
 * same bodies without the pins, with Newton systems without vector code, as those of closed models
 * are. `klu`: the equations of motion of the closed ones in redundant coordinates (kkt.h) by
 * SuiteSparse's KLU, which has accelerations and forces for them and no derivatives of anything. A
 * sample is the mean over as many calls as last about 5 ms; a start is timed once. */
#include "bench.h"
#include "kkt.h"
#include "trees.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 15, FORWARD = 3, INVERSE, CALLS, KKT_CALLS = 3 };

static const double sample_time = 5e-3;
static const char *const call_name[CALLS] = {"residual", "factor", "solve", "forward", "inverse"};

static const struct bench_case {
    const char *name, *variant;
    int count, ring, massless;
    bench_loop closed;
    int by_blocks;
} cases[] = {{"fourbars", "closed", 10, 0, 0, 1, 0},
             {"fourbars", "closed", 100, 0, 0, 1, 0},
             {"fourbars", "closed", 1000, 0, 0, 1, 0},
             {"fourbars", "closed", 10000, 0, 0, 1, 0},
             {"fourbars", "massless", 10, 0, 1, 1, 0},
             {"fourbars", "massless", 100, 0, 1, 1, 0},
             {"fourbars", "massless", 1000, 0, 1, 1, 0},
             {"fourbars", "stiff", 10, 0, 0, BENCH_STIFF, 0},
             {"fourbars", "stiff", 1000, 0, 0, BENCH_STIFF, 0},
             {"fourbars", "by_blocks", 1000, 0, 0, 0, 1},
             {"ring", "closed", 10, 1, 0, 1, 0},
             {"ring", "closed", 100, 1, 0, 1, 0},
             {"ring", "closed", 1000, 1, 0, 1, 0},
             {"ring", "by_blocks", 1000, 1, 0, 0, 1},
             {"linkages", "hinges", 100, 0, 0, 1, 0},
             {"linkages", "universal", 10, 0, 0, 1, 0},
             {"linkages", "universal", 100, 0, 0, 1, 0},
             {"linkages", "universal", 1000, 0, 0, 1, 0},
             {"linkages", "universal massless", 100, 0, 1, 1, 0},
             {"linkages", "ball", 10, 0, 0, 1, 0},
             {"linkages", "ball", 100, 0, 0, 1, 0},
             {"linkages", "ball", 1000, 0, 0, 1, 0},
             {"gears", "closed", 10, 0, 0, 1, 0},
             {"gears", "closed", 100, 0, 0, 1, 0},
             {"gears", "closed", 1000, 0, 0, 1, 0},
             {"gears", "open", 100, 0, 0, 0, 0},
             {"hands", "closed", 10, 0, 0, 1, 0},
             {"hands", "closed", 100, 0, 0, 1, 0},
             {"hands", "open", 100, 0, 0, 0, 0},
             {"differentials", "closed", 100, 0, 0, 1, 0}};
enum { CASES = sizeof cases / sizeof cases[0] };

static int in_space(const struct bench_case *of)
{
    return !strcmp(of->name, "linkages");
}

static bench_gearing gearing_of(const struct bench_case *of)
{
    return !strcmp(of->name, "gears")   ? BENCH_GEARS
           : !strcmp(of->name, "hands") ? BENCH_HANDS
                                        : BENCH_DIFFERENTIALS;
}

static int is_gearing(const struct bench_case *of)
{
    return gearing_of(of) != BENCH_DIFFERENTIALS || !strcmp(of->name, "differentials");
}

/* Rods in the plane, closed by pins: what kkt.h and other libraries take. */
static int has_pins(const struct bench_case *of)
{
    return !in_space(of) && !is_gearing(of);
}

static bench_coupler coupler_of(const struct bench_case *of)
{
    return !strcmp(of->variant, "hinges") ? BENCH_HINGE
           : !strcmp(of->variant, "ball") ? BENCH_BALL
                                          : BENCH_UNIVERSAL;
}

typedef struct candidate {
    bench_model tree;
    mbsr_data *data;
    mbsr_newton *newton;
    double *y, *yp, *F;
    int *motor, motors;
    double start; /* s */
} candidate;

/* Joints with motors: all of open models and of those that are coupled, of a ring all but two, of
 * each piece all but those that its pin holds, and of one with stiff pins, which hold none, all. */
static void choose_motors(candidate *c, const struct bench_case *of)
{
    const int nu = c->tree.nu, rates = of->ring ? nu : nu / of->count;
    int held = of->ring ? 2 : in_space(of) && strcmp(of->variant, "hinges") ? 3 : 2;
    if (of->closed != BENCH_RIGID || is_gearing(of)) held = 0;
    c->motor = bench_allocate((size_t)nu, sizeof *c->motor);
    c->motors = 0;
    for (int k = 0; k < nu; ++k) {
        if (k % rates < rates - held) c->motor[c->motors++] = k;
    }
}

static void open_candidate(candidate *c, const struct bench_case *of)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = of->by_blocks;
    if (is_gearing(of))
        bench_make_gearing(&c->tree, gearing_of(of), of->count, of->closed);
    else if (of->ring)
        bench_make_ring(&c->tree, of->count, of->closed != BENCH_OPEN);
    else if (in_space(of))
        bench_make_linkages(&c->tree, of->count, coupler_of(of), of->massless,
                            of->closed != BENCH_OPEN);
    else
        bench_make_fourbars(&c->tree, of->count, of->massless, of->closed);
    const mbsr_model *m = c->tree.model;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    bench_check(mbsr_data_create(m, &c->data, NULL), "mbsr_data_create", NULL);
    bench_check(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &c->newton, NULL),
                "mbsr_newton_create", NULL);
    c->y = bench_allocate(3 * size, sizeof(double));
    c->yp = c->y + size;
    c->F = c->yp + size;
    const double *q = c->tree.q, *u = c->tree.u;
    bench_check(mbsr_dae_pack(m, c->data, MBSR_DAE_MOMENTUM, 0.0, q, u, c->y), "mbsr_dae_pack",
                mbsr_data_error(c->data)->text);
    choose_motors(c, of);
    const double before = bench_now();
    bench_check(mbsr_dae_consistent(m, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, NULL, NULL),
                "mbsr_dae_consistent", mbsr_data_error(c->data)->text);
    c->start = bench_now() - before;
}

static void close_candidate(candidate *c)
{
    mbsr_newton_destroy(c->newton);
    mbsr_data_destroy(c->data);
    bench_free_tree(&c->tree);
    free(c->y);
    free(c->motor);
}

/* ---- beside them KLU on the equations of motion in redundant coordinates ---- */

static bench_pin pin_of(const bench_rod *rod, int a, int b)
{
    return (bench_pin){a, b, rod[a].x + rod[a].length * cos(rod[a].angle),
                       rod[a].y + rod[a].length * sin(rod[a].angle)};
}

/* Mass and length of rod i, as of trees.c. */
static double mass_of(const struct bench_case *of, int rods, int i)
{
    static const double mass[4] = {1.5, 0.4, 0.6, 0.3};
    return of->ring ? 1.0 / rods : mass[i % 4];
}

static double length_of(const struct bench_case *of, int rods, int i)
{
    static const double length[4] = {0.5, 0.3, 0.45, 0.3};
    return of->ring ? 1.0 / rods : length[i % 4];
}

/* The rods that pin k ties; -1: the ground. */
static int first_of(const struct bench_case *of, int rods, int k)
{
    return of->ring ? rods - 1 : 4 * k + 2;
}

static int second_of(const struct bench_case *of, int k)
{
    return of->ring ? -1 : 4 * k + 3;
}

/* The mechanism of a case where it starts. */
static bench_kkt *open_kkt(candidate *c, const struct bench_case *of)
{
    static const double gravity[2] = {0.0, -9.81};
    const int rods = c->tree.bodies, pins = of->ring ? 1 : of->count;
    bench_rod *rod = bench_allocate((size_t)rods, sizeof *rod);
    bench_pin *pin = bench_allocate((size_t)pins, sizeof *pin);
    bench_check(mbsr_stage_positions(c->tree.model, c->data, 0.0, c->y), "mbsr_stage_positions",
                NULL);
    for (int i = 0; i < rods; ++i) {
        double p[3];
        bench_check(mbsr_body_pose(c->tree.model, c->data, i, p), "mbsr_body_pose", NULL);
        rod[i] = (bench_rod){mbsr_body_parent(c->tree.model, i),
                             p[0],
                             p[1],
                             p[2],
                             mass_of(of, rods, i),
                             length_of(of, rods, i)};
    }
    for (int k = 0; k < pins; ++k) pin[k] = pin_of(rod, first_of(of, rods, k), second_of(of, k));
    bench_kkt *kkt = bench_kkt_open(rods, rod, pins, pin, gravity);
    free(rod);
    free(pin);
    return kkt;
}

/* Both find the same angular acceleration of the first body, from rest. */
static void compare(candidate *c, bench_kkt *kkt)
{
    const int nu = c->tree.nu;
    if (c->tree.bodies > 100) return;
    if (!bench_kkt_factor(kkt)) bench_check(MBSR_ERR_VALUE, "KLU", NULL);
    double *udot = bench_allocate(2 * (size_t)nu, sizeof *udot);
    bench_check(mbsr_forward_dynamics(c->tree.model, c->data, 0.0, c->y, udot + nu, NULL, udot),
                "mbsr_forward_dynamics", mbsr_data_error(c->data)->text);
    const double found = bench_kkt_solve(kkt)[2];
    if (!(fabs(found - udot[0]) <= 1e-6 * (1.0 + fabs(udot[0])))) {
        fprintf(stderr, "bench_loops: KLU has %.12g, the library %.12g\n", found, udot[0]);
        exit(1);
    }
    free(udot);
}

static int call_kkt(bench_kkt *kkt, int which)
{
    return which == 1 ? bench_kkt_factor(kkt) : bench_kkt_solve(kkt) != NULL;
}

static void measure_kkt(candidate *c, const struct bench_case *of, int samples, double *sample)
{
    if (of->closed != BENCH_RIGID || of->massless || !has_pins(of)) return;
    bench_kkt *kkt = open_kkt(c, of);
    if (!kkt) {
        printf("# %s %d: no KLU\n", of->name, of->count);
        return;
    }
    compare(c, kkt);
    for (int which = 1; which < KKT_CALLS; ++which) {
        for (int j = 0; j < samples; ++j) {
            int calls = 0;
            const double before = bench_now();
            double passed;
            do {
                if (!call_kkt(kkt, which)) bench_check(MBSR_ERR_VALUE, "KLU", NULL);
                ++calls;
                passed = bench_now() - before;
            } while (passed < sample_time);
            sample[j] = 1e9 * passed / calls / c->tree.bodies;
        }
        const bench_quartiles s = bench_statistics(samples, sample);
        printf("%s,klu,%d,%d,%s,%.0f,%.0f,%.0f\n", of->name, c->tree.bodies,
               mbsr_model_rows(c->tree.model), call_name[which], s.median, s.q1, s.q3);
    }
    bench_kkt_close(kkt);
}

/* ---- the library ---- */

static int call(candidate *c, int which)
{
    const mbsr_model *m = c->tree.model;
    const double *u = c->y + mbsr_model_nq(m) + c->tree.nu, *udot = c->yp;
    switch (which) {
    case 0: return mbsr_dae_residual(m, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, c->F);
    case 1: return mbsr_newton_factor(c->newton, c->data, 0.0, c->y, c->yp, 100.0);
    case 2: return mbsr_newton_solve(c->newton, c->yp, c->F);
    case FORWARD: return mbsr_forward_dynamics(m, c->data, 0.0, c->y, u, NULL, c->F);
    default:
        return mbsr_inverse_dynamics(m, c->data, 0.0, c->y, u, udot,
                                     &(mbsr_motors){c->motors, c->motor}, c->F);
    }
}

/* Seconds a call. */
static double measure(candidate *c, int which)
{
    int calls = 0;
    const double before = bench_now();
    double passed;
    do {
        bench_check(call(c, which), call_name[which],
                    which >= FORWARD ? mbsr_data_error(c->data)->text
                                     : mbsr_newton_error(c->newton)->text);
        ++calls;
        passed = bench_now() - before;
    } while (passed < sample_time);
    return passed / calls;
}

/* ---- for other libraries ---- */

/* A rod on its hinge: place in the parent's axes, angle, acceleration at rest. */
static void write_rod(FILE *file, const candidate *c, const struct bench_case *of, int i)
{
    const mbsr_model *m = c->tree.model;
    const int parent = mbsr_body_parent(m, i), rods = c->tree.bodies;
    const double length = length_of(of, rods, i), mass = mass_of(of, rods, i);
    double p[3], on[3] = {0.0, 0.0, 0.0};
    bench_check(mbsr_body_pose(m, c->data, i, p), "mbsr_body_pose", NULL);
    if (parent >= 0) bench_check(mbsr_body_pose(m, c->data, parent, on), "mbsr_body_pose", NULL);
    const double x = p[0] - on[0], y = p[1] - on[1], cosine = cos(on[2]), sine = sin(on[2]);
    fprintf(file, "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", parent, cosine * x + sine * y,
            cosine * y - sine * x, c->y[i], c->F[i], mass, length, mass * length * length / 12.0);
}

static void write_case(const struct bench_case *of, const char *folder)
{
    char path[1000];
    candidate c;
    open_candidate(&c, of);
    const int rods = c.tree.bodies, pins = of->ring ? 1 : of->count;
    double *rest = bench_allocate((size_t)rods, sizeof *rest);
    snprintf(path, sizeof path, "%s/%s_%d.loops", folder, of->name, of->count);
    FILE *file = fopen(path, "w");
    if (!file) bench_check(MBSR_ERR_VALUE, path, "cannot be written");
    bench_check(mbsr_forward_dynamics(c.tree.model, c.data, 0.0, c.y, rest, NULL, c.F),
                "mbsr_forward_dynamics", mbsr_data_error(c.data)->text);
    fprintf(file, "%d %d\n", rods, pins);
    for (int i = 0; i < rods; ++i) write_rod(file, &c, of, i);
    for (int k = 0; k < pins; ++k) {
        const int a = first_of(of, rods, k), b = second_of(of, k);
        fprintf(file, "%d %.17g %d %.17g\n", a, length_of(of, rods, a), b,
                b < 0 ? 0.0 : length_of(of, rods, b));
    }
    if (fclose(file)) bench_check(MBSR_ERR_VALUE, path, "cannot be written");
    free(rest);
    close_candidate(&c);
}

static int write_all(const char *folder)
{
    for (int k = 0; k < CASES; ++k) {
        if (cases[k].closed == BENCH_RIGID && !cases[k].massless && has_pins(cases + k) &&
            cases[k].count <= 100)
            write_case(cases + k, folder);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 3 && !strcmp(argv[1], "--write")) return write_all(argv[2]);
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES;
    double *sample = bench_allocate((size_t)(samples > 0 ? samples : 1), sizeof(double));
    if (samples < 1) return 2;
    bench_header(stdout, "models with closed loops, time per body");
    printf("model,variant,bodies,rows,call,ns_per_body,q1,q3\n");
    for (int k = 0; k < CASES; ++k) {
        candidate c;
        open_candidate(&c, cases + k);
        const int bodies = c.tree.bodies, rows = mbsr_model_rows(c.tree.model);
        printf("%s,%s,%d,%d,start,%.0f,,\n", cases[k].name, cases[k].variant, bodies, rows,
               1e9 * c.start / bodies);
        for (int which = 0; which < CALLS; ++which) {
            for (int j = 0; j < samples; ++j) sample[j] = 1e9 * measure(&c, which) / bodies;
            const bench_quartiles s = bench_statistics(samples, sample);
            printf("%s,%s,%d,%d,%s,%.0f,%.0f,%.0f\n", cases[k].name, cases[k].variant, bodies, rows,
                   call_name[which], s.median, s.q1, s.q3);
        }
        measure_kkt(&c, cases + k, samples, sample);
        fflush(stdout);
        close_candidate(&c);
    }
    free(sample);
    return 0;
}
