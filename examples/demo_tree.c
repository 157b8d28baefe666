/* The demo's second part: a tree of wood, shaken at its foot; two bodies of three have no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Every segment of the tree is three bodies: a massless cross that bends about one axis, a massless
 * link that creeps about the other, and a rod that bends about that same axis. The link with its
 * spring and damper in series with the rod's spring makes wood that creeps (a Zener element); a
 * rotation of the link against the rod moves no mass, so its rate follows from the balance of
 * torques alone. Springs k = E I / length, I = pi r^4 / 4, rest so that all torques of the weight
 * are in balance before the foot begins to move; dampers in proportion.
 *
 * Smaller trees and a dense matrix show what a body costs; small masses in place of none that zero
 * is their limit. Writes a table and CSV files for tree.gp.
 *
 *   demo_tree FOLDER [BODIES] */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>
#include <time.h>

static const double pi = 3.14159265358979323846, E = 5e9, rho = 600.0, g = 9.81; /* N/m^2, ... */
static const double damping = 2e-3, creep = 0.05; /* s: damper / spring */
static const double trunk = 0.15, height = 1.0;   /* m: radius and length of the trunk */
static const double T = 3.0, tolerance = 1e-4;
enum { FRAMES = 150, MOST = 10 };

typedef struct segment {
    int parent; /* segment, -1: the foot */
    double length, radius, tilt, turn;
    int cross, link, rod; /* bodies */
} segment;

/* ---- the tree ---- */

/* Numbers that repeat, 0 .. 1. */
static double chance(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / 16777216.0;
}

static double *numbers(int count)
{
    double *x = calloc((size_t)count + 1, sizeof *x);
    if (!x) exit(1);
    return x;
}

/* Branches in two, breadth first; the squares of the radii add up. */
static segment *grow(int count)
{
    segment *s = calloc((size_t)count + 2, sizeof *s);
    unsigned state = 7;
    if (!s) exit(1);
    s[0] = (segment){.parent = -1, .length = height, .radius = trunk};
    for (int k = 0, next = 1; next < count; ++k) {
        const double share = 0.35 + 0.3 * chance(&state), turn = 2.0 * pi * chance(&state);
        for (int side = 0; side < 2 && next < count; ++side, ++next) {
            const double part = side ? 1.0 - share : share;
            s[next] = (segment){.parent = k,
                                .length = s[k].length * (0.8 + 0.15 * chance(&state)),
                                .radius = s[k].radius * sqrt(part),
                                .tilt = 0.55 * sqrt(1.0 - part) * (0.7 + 0.6 * chance(&state)),
                                .turn = turn + pi * side};
        }
    }
    return s;
}

/* x = 0.15 m of a smooth step there and back in the first second. */
static int foot(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const double w = 2.0 * pi, size = 0.15;
    if (t <= 0.0 || t >= 1.0) return MBSR_OK;
    const double s = sin(0.5 * w * t), c = cos(0.5 * w * t);
    p[MBSR_POSE_X] = size * s * s * s * s;
    V[3] = size * 2.0 * w * s * s * s * c;
    A[3] = size * w * w * (3.0 * s * s * c * c - s * s * s * s);
    return MBSR_OK;
}

static mbsr_inertia rod_inertia(const segment *s, double share)
{
    const double end[3] = {0.0, 0.0, s->length}, start[3] = {0.0, 0.0, 0.0};
    return mbsr_inertia_rod(share * rho * pi * s->radius * s->radius * s->length, start, end);
}

/* ratio: mass of what has none, in masses of its rod. rest: angle of each spring, by body, or
 * NULL. */
static mbsr_model *build(segment *tree, int count, double ratio, const double *rest)
{
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m;
    mbsr_error error;
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
    def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, foot, NULL);
    check(mbsr_model_create(&def, &m, &error), &error);
    for (int k = 0; k < count; ++k) {
        segment *s = tree + k;
        const segment *below = s->parent < 0 ? NULL : tree + s->parent;
        const double tip[3] = {0.0, 0.0, below ? below->length : 0.0};
        const mbsr_frame turned = mbsr_frame_rotated(tip, up, s->turn),
                         tilted = mbsr_frame_rotated(NULL, x, s->tilt),
                         at = mbsr_frame_product(&turned, &tilted);
        const mbsr_inertia small = ratio > 0.0 ? rod_inertia(s, ratio) : mbsr_inertia_zero();
        s->cross = add_body(m, "cross", below ? below->rod : MBSR_GROUND,
                            mbsr_joint_revolute(&at, NULL, x), small);
        s->link = add_body(m, "link", s->cross, mbsr_joint_revolute(NULL, NULL, y), small);
        s->rod =
            add_body(m, "rod", s->link, mbsr_joint_revolute(NULL, NULL, y), rod_inertia(s, 1.0));
        if (!rest) continue;
        const double r = s->radius, stiffness = E * 0.25 * pi * r * r * r * r / s->length;
        add_force(m, mbsr_force_joint_spring(s->cross, 0, stiffness, damping * stiffness,
                                             rest[s->cross] / stiffness));
        add_force(m, mbsr_force_joint_spring(s->link, 0, 2.0 * stiffness, creep * stiffness,
                                             rest[s->link] / (2.0 * stiffness)));
        add_force(m, mbsr_force_joint_spring(s->rod, 0, 2.0 * stiffness, damping * stiffness,
                                             rest[s->rod] / (2.0 * stiffness)));
    }
    add_force(m, mbsr_force_gravity(0.0, 0.0, -g));
    return m;
}

/* Torques that hold the tree up at q = 0. */
static double *torques(segment *tree, int count)
{
    mbsr_model *m = build(tree, count, 0.0, NULL);
    mbsr_data *d;
    mbsr_error error;
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);
    double *zero = numbers(mbsr_model_nu(m)), *tau = numbers(mbsr_model_nu(m));
    check(mbsr_bias_forces(m, d, 0.0, zero, zero, tau), mbsr_data_error(d));
    free(zero);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return tau;
}

/* ---- runs ---- */

typedef struct outcome {
    mbsr_ida_stats stats;
    double seconds, start, tip[FRAMES + 1];
} outcome;

static double seconds_of(clock_t begin)
{
    return (double)(clock() - begin) / CLOCKS_PER_SEC;
}

/* Both ends of every rod. */
static void draw(mbsr_simulation *r, const segment *tree, int count, FILE *file)
{
    for (int k = 0; k < count; ++k) {
        double p[MBSR_POSE_SIZE];
        check(mbsr_body_pose(r->model, r->data, tree[k].rod, p), mbsr_data_error(r->data));
        const double *o = p + MBSR_POSE_X, *z = p + MBSR_POSE_R + 6;
        fprintf(file, "%.5f,%.5f,%.5f,%.5f\n", o[0], o[1], o[2], tree[k].radius);
        fprintf(file, "%.5f,%.5f,%.5f,%.5f\n\n", o[0] + tree[k].length * z[0],
                o[1] + tree[k].length * z[1], o[2] + tree[k].length * z[2], tree[k].radius);
    }
}

/* What a run gives out at its output times. */
typedef struct output {
    mbsr_simulation *r;
    const segment *tree;
    int count;
    outcome *to;
    const char *folder; /* NULL: no pictures */
} output;

static FILE *create(const char *folder, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return csv(path);
}

static int receive(void *user, int index, double t, const double *y, const double *yp)
{
    (void)yp;
    const output *o = user;
    mbsr_simulation *r = o->r;
    const double *q = y;
    check(mbsr_stage_positions(r->model, r->data, t, q), mbsr_data_error(r->data));
    double p[MBSR_POSE_SIZE];
    check(mbsr_body_pose(r->model, r->data, o->tree[o->count - 1].rod, p),
          mbsr_data_error(r->data));
    o->to->tip[index] = p[MBSR_POSE_X];
    static const struct {
        int index;
        const char *name;
    } picture[] = {{0, "tree_0.csv"}, {15, "tree_1.csv"}, {29, "tree_2.csv"}, {43, "tree_3.csv"}};
    for (int k = 0; k < 4 && o->folder; ++k) {
        if (picture[k].index != index) continue;
        FILE *file = create(o->folder, picture[k].name);
        draw(r, o->tree, o->count, file);
        fclose(file);
    }
    return MBSR_OK;
}

static outcome integrate(segment *tree, int count, double ratio, const double *rest,
                         mbsr_ida_solver solver, const char *folder)
{
    outcome result;
    mbsr_model *m = build(tree, count, ratio, rest);
    clock_t begin = clock();
    double *zero = numbers(9 * count), times[FRAMES + 1];
    mbsr_simulation r = run_start_with(m, zero, zero, tolerance, solver);
    result.start = seconds_of(begin);
    for (int k = 0; k <= FRAMES; ++k) times[k] = T * k / FRAMES;
    output o = {&r, tree, count, &result, folder};
    int next = 0;
    begin = clock();
    check(mbsr_ida_run(r.ida, FRAMES + 1, times, &next, receive, &o), mbsr_ida_error(r.ida));
    result.seconds = seconds_of(begin);
    check(mbsr_ida_get_stats(r.ida, &result.stats), mbsr_ida_error(r.ida));
    mbsr_simulation_end(&r);
    free(zero);
    return result;
}

/* One run, with its line of the table. */
static outcome row(int bodies, double ratio, mbsr_ida_solver solver, const char *folder,
                   FILE *summary)
{
    const int segments = bodies / 3;
    segment *tree = grow(segments);
    double *rest = torques(tree, segments);
    const outcome result = integrate(tree, segments, ratio, rest, solver, folder);
    const mbsr_ida_stats *stats = &result.stats;
    const double step = result.seconds / (double)stats->steps;
    const char *const name = solver == MBSR_IDA_DENSE ? "dense" : "tree";
    printf("%7d  %8g  %-6s  %6ld  %10ld  %10ld  %7.2f  %6.2f  %11.2f  %15.2f\n", 3 * segments,
           ratio, name, stats->steps, stats->newton_iterations, stats->factorisations, result.start,
           result.seconds, 1e3 * step, 1e6 * step / (3.0 * segments));
    fflush(stdout);
    fprintf(summary, "%d,%g,%s,%ld,%ld,%ld,%.3f,%.3f\n", 3 * segments, ratio, name, stats->steps,
            stats->newton_iterations, stats->factorisations, result.start, result.seconds);
    free(rest), free(tree);
    return result;
}

int main(int count, char **arguments)
{
    const char *folder = count > 1 ? arguments[1] : ".";
    const int bodies = count > 2 ? atoi(arguments[2]) : 999;
    if (bodies < 90) {
        fprintf(stderr, "usage: demo_tree [FOLDER [BODIES]], at least 90 bodies\n");
        return 1;
    }
    FILE *summary = create(folder, "tree.csv"), *motion = create(folder, "tree_motion.csv");
    printf("A tree in space, shaken at its foot; two bodies of three have no mass, or one of "
           "`mass` rods; t = 0 .. %g s, rtol = atol = %g.\n\n"
           " bodies      mass  solver   steps  Newton it.  factorised  start s   mbsr_simulation s "
           " ms per step "
           " us per body\n",
           T, tolerance);
    fprintf(
        summary,
        "# bodies,mass,solver,steps,Newton iterations,factorisations,start s,mbsr_simulation s\n");
    const outcome dense = row(bodies / 30, 0.0, MBSR_IDA_DENSE, NULL, summary),
                  small = row(bodies / 30, 0.0, MBSR_IDA_TREE, NULL, summary);
    row(bodies / 10, 0.0, MBSR_IDA_TREE, NULL, summary);
    row(bodies / 3, 0.0, MBSR_IDA_TREE, NULL, summary);
    const outcome none = row(bodies, 0.0, MBSR_IDA_TREE, folder, summary),
                  some = row(bodies, 1e-6, MBSR_IDA_TREE, NULL, summary);
    double largest = 0.0, off = 0.0, solvers = 0.0;
    for (int l = 0; l <= FRAMES; ++l) {
        const double x = none.tip[l] - none.tip[0];
        fprintf(motion, "%.4f,%.6f\n", T * l / FRAMES, x);
        largest = fmax(largest, fabs(x));
        off = fmax(off, fabs(none.tip[l] - some.tip[l]));
        solvers = fmax(solvers, fabs(dense.tip[l] - small.tip[l]));
    }
    printf(
        "\nThe last twig moves by up to %.3f m. With masses of 1e-6 it is off by at most %.1e m, "
        "with the other solver by %.1e m.\n",
        largest, off, solvers);
    fclose(summary), fclose(motion);
    return off < 1e-2 * largest && solvers < 1e-2 * largest ? 0 : 1;
}
