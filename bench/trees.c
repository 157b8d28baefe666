/* Trees of rigid bodies from files, and chains made up here.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "trees.h"

#include "bench.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *what, const char *name)
{
    fprintf(stderr, "%s: %s\n", what, name);
    exit(1);
}

static int add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    if (mbsr_model_add_body(m, &body, &id) != MBSR_OK) fail(mbsr_model_error(m)->text, "add");
    return id;
}

static void add_spring(mbsr_model *m, int id)
{
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, 5.0, 0.1, 0.2);
    if (mbsr_model_add_force(m, &spring, NULL) != MBSR_OK)
        fail(mbsr_model_error(m)->text, "spring");
}

static void finish(bench_model *tree, double gy, double gz)
{
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, gy, gz);
    mbsr_model *m = tree->model;
    if (mbsr_model_add_force(m, &gravity, NULL) != MBSR_OK || mbsr_model_finish(m) != MBSR_OK)
        fail(mbsr_model_error(m)->text, "finish");
    tree->bodies = mbsr_model_bodies(m);
    tree->nq = mbsr_model_nq(m);
    tree->nu = mbsr_model_nu(m);
}

static double *numbers(int n)
{
    double *x = calloc((size_t)n + 1, sizeof *x);
    if (!x) fail("no memory", "");
    return x;
}

/* One section of a .ref file; `first` and `then` put a free root's coordinates in the model's
 * order: `then` numbers behind the first `first` come to the front. */
static double *section(FILE *file, const char *name, const char *key, bool free_root, int first,
                       int then)
{
    char word[16];
    int n;
    if (fscanf(file, "%15s %d", word, &n) != 2 || strcmp(word, key) != 0) fail("no section", name);
    double *x = numbers(n), head[8];
    for (int k = 0; k < n; ++k) {
        if (fscanf(file, "%lf", x + k) != 1) fail("too short", name);
    }
    if (free_root) {
        memcpy(head, x, (size_t)first * sizeof *x);
        memmove(x, x + first, (size_t)then * sizeof *x);
        memcpy(x + then, head, (size_t)first * sizeof *x);
    }
    return x;
}

static FILE *open_file(const char *folder, const char *name, const char *ending)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s.%s", folder, name, ending);
    FILE *file = fopen(path, "r");
    if (!file) fail("cannot read", path);
    return file;
}

void bench_read_tree(bench_model *tree, const char *folder, const char *name)
{
    FILE *file = open_file(folder, name, "txt");
    bool free_root = false;
    int parent;
    char type;
    double v[20];
    *tree = (bench_model){NULL, 0, 0, 0, NULL, NULL, NULL, NULL};
    if (mbsr_model_create(NULL, &tree->model, NULL) != MBSR_OK) fail("create", name);
    while (fscanf(file, "%d %c", &parent, &type) == 2) {
        for (int k = 0; k < 20; ++k) {
            if (fscanf(file, "%lf", v + k) != 1) fail("too short", name);
        }
        const mbsr_frame A = mbsr_frame_quaternion(v + 3, v + 6);
        const mbsr_joint joint = type == 'F'   ? mbsr_joint_free(NULL, NULL)
                                 : type == 'P' ? mbsr_joint_prismatic(&A, NULL, v)
                                               : mbsr_joint_revolute(&A, NULL, v);
        free_root = free_root || type == 'F';
        add(tree->model, parent < 0 ? MBSR_GROUND : parent, joint,
            mbsr_inertia_rigid(v[10], v + 11, v + 14));
    }
    fclose(file);
    finish(tree, 0.0, -9.81);
    file = open_file(folder, name, "ref");
    tree->q = section(file, name, "q", free_root, 3, 4);
    tree->u = section(file, name, "v", free_root, 3, 3);
    tree->tau = section(file, name, "tau", free_root, 3, 3);
    tree->udot = section(file, name, "qdd", free_root, 3, 3);
    fclose(file);
}

/* Angles of up to `angle`, rates and joint forces of up to 1. */
static void choose_state(bench_model *tree, uint64_t *seed, double angle)
{
    tree->q = numbers(tree->nq);
    tree->u = numbers(tree->nu);
    tree->tau = numbers(tree->nu);
    for (int k = 0; k < tree->nq; ++k) tree->q[k] = bench_uniform(seed, -angle, angle);
    for (int k = 0; k < tree->nu; ++k) {
        tree->u[k] = bench_uniform(seed, -1.0, 1.0);
        tree->tau[k] = bench_uniform(seed, -1.0, 1.0);
    }
}

void bench_make_chain(bench_model *tree, int bodies, int massless, int springs)
{
    uint64_t seed = 1;
    *tree = (bench_model){NULL, 0, 0, 0, NULL, NULL, NULL, NULL};
    if (mbsr_model_create(NULL, &tree->model, NULL) != MBSR_OK) fail("create", "chain");
    for (int i = 0; i < bodies; ++i) {
        double axis[3], quaternion[4];
        for (int k = 0; k < 3; ++k) axis[k] = bench_uniform(&seed, -1.0, 1.0);
        for (int k = 0; k < 4; ++k) quaternion[k] = bench_uniform(&seed, -1.0, 1.0);
        const double x[3] = {0.1 * bench_uniform(&seed, -1.0, 1.0),
                             0.1 * bench_uniform(&seed, -1.0, 1.0), 0.3};
        const double com[3] = {0.05 * bench_uniform(&seed, -1.0, 1.0), 0.0, 0.15};
        const double tensor[6] = {0.02, 0.018, 0.012, 0.001, -0.002, 0.0005};
        const mbsr_frame A = mbsr_frame_quaternion(x, quaternion);
        const bool zero = massless > 0 && i % massless == massless - 2;
        const int id = add(tree->model, i - 1, mbsr_joint_revolute(&A, NULL, axis),
                           zero ? mbsr_inertia_zero() : mbsr_inertia_rigid(1.5, com, tensor));
        if (springs) add_spring(tree->model, id);
    }
    finish(tree, 0.0, -9.81);
    choose_state(tree, &seed, 1.0);
}

static mbsr_inertia rod_along_z(double length)
{
    const double start[3] = {0.0, 0.0, 0.0}, end[3] = {0.0, 0.0, length};
    return mbsr_inertia_rod(1.5, start, end);
}

void bench_make_segments(bench_model *tree, int segments)
{
    uint64_t seed = 1;
    const double length = 0.3, x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    *tree = (bench_model){NULL, 0, 0, 0, NULL, NULL, NULL, NULL};
    if (mbsr_model_create(NULL, &tree->model, NULL) != MBSR_OK) fail("create", "segments");
    for (int k = 0; k < segments; ++k) {
        const double tip[3] = {0.0, 0.0, k > 0 ? length : 0.0};
        const mbsr_frame at = mbsr_frame_rotated(tip, x, k % 2 ? 0.4 : -0.3);
        const int below = k > 0 ? 3 * ((k - 1) / 2) + 2 : MBSR_GROUND,
                  cross = add(tree->model, below, mbsr_joint_revolute(&at, NULL, x),
                              mbsr_inertia_zero()),
                  link = add(tree->model, cross, mbsr_joint_revolute(NULL, NULL, y),
                             mbsr_inertia_zero());
        add_spring(tree->model, link);
        add_spring(tree->model,
                   add(tree->model, link, mbsr_joint_revolute(NULL, NULL, y), rod_along_z(length)));
    }
    finish(tree, 0.0, -9.81);
    choose_state(tree, &seed, 0.1);
}

void bench_make_beam(bench_model *tree, int bodies)
{
    uint64_t seed = 1;
    const double length = 0.1, y[3] = {0.0, 1.0, 0.0};
    *tree = (bench_model){NULL, 0, 0, 0, NULL, NULL, NULL, NULL};
    if (mbsr_model_create(NULL, &tree->model, NULL) != MBSR_OK) fail("create", "beam");
    for (int i = 0; i < bodies; ++i) {
        const double tip[3] = {0.0, 0.0, i > 0 ? length : 0.0};
        const mbsr_frame at = mbsr_frame_rotated(tip, y, 0.0);
        add(tree->model, i > 0 ? i - 1 : MBSR_GROUND, mbsr_joint_revolute(&at, NULL, y),
            rod_along_z(length));
    }
    finish(tree, 0.0, -9.81);
    choose_state(tree, &seed, 0.01);
}

/* A rod in the plane that turns about (x, y) of its parent. */
static int add_rod(mbsr_model *model, int parent, double x, double y, double mass, double length)
{
    const double com[2] = {0.5 * length, 0.0};
    const mbsr_planar_frame at = {x, y, 0.0}, none = {0.0, 0.0, 0.0};
    return add(model, parent, mbsr_joint_planar_revolute(at, none),
               mass > 0.0 ? mbsr_inertia_planar(mass, com, mass * length * length / 12.0)
                          : mbsr_inertia_zero());
}

/* stiffness, N/m: 0 for a rigid pin; with the damping of 1e-4 s times it. */
static void add_pin(mbsr_model *model, int a, double x, int b, double y, double stiffness)
{
    mbsr_closure_def pin =
        mbsr_closure_ball(a, (double[3]){x, 0.0, 0.0}, b, (double[3]){y, 0.0, 0.0});
    for (int k = 0; k < 2; ++k) {
        pin.stiffness[k] = stiffness;
        pin.damping[k] = 1e-4 * stiffness;
    }
    if (mbsr_model_add_closure(model, &pin, NULL) != MBSR_OK)
        fail(mbsr_model_error(model)->text, "pin");
}

static void begin_plane(bench_model *tree)
{
    *tree = (bench_model){NULL, 0, 0, 0, NULL, NULL, NULL, NULL};
    if (mbsr_model_create(NULL, &tree->model, NULL) != MBSR_OK) fail("create", "loops");
}

static void finish_plane(bench_model *tree)
{
    finish(tree, -9.81, 0.0);
    tree->q = numbers(tree->nq);
    tree->u = numbers(tree->nu);
    tree->tau = numbers(tree->nu);
}

void bench_make_fourbars(bench_model *tree, int count, int massless, bench_loop loop)
{
    int last = MBSR_GROUND;
    begin_plane(tree);
    mbsr_model *model = tree->model;
    for (int k = 0; k < count; ++k) {
        last = add_rod(model, last, k > 0 ? 0.5 : 0.0, 0.0, 1.5, 0.5);
        const int crank = add_rod(model, last, 0.02, 0.1, 0.4, 0.3),
                  coupler = add_rod(model, crank, 0.3, 0.0, massless ? 0.0 : 0.6, 0.45),
                  rocker = add_rod(model, last, 0.47, 0.1, 0.3, 0.3);
        if (loop != BENCH_OPEN)
            add_pin(model, coupler, 0.45, rocker, 0.3, loop == BENCH_STIFF ? 1e10 : 0.0);
    }
    finish_plane(tree);
    for (int k = 0; k < count; ++k) {
        const double angle = 1.0 + 0.3 * sin(k), rate = cos(3.0 * k);
        const double q[4] = {0.2 * sin(2.0 * k), angle, -angle, angle},
                     u[4] = {0.1 * cos(k), rate, -rate, rate};
        memcpy(tree->q + 4 * k, q, sizeof q);
        memcpy(tree->u + 4 * k, u, sizeof u);
    }
}

void bench_make_one_loop(bench_model *tree, int rods, int at_root, int closed)
{
    int last = MBSR_GROUND, at = MBSR_GROUND;
    begin_plane(tree);
    for (int k = 0; k < rods; ++k) {
        last = add_rod(tree->model, last, k > 0 ? 0.5 : 0.0, 0.0, 1.5, 0.5);
        if (k == 0 || !at_root) at = last;
    }
    const int crank = add_rod(tree->model, at, 0.02, 0.1, 0.4, 0.3),
              coupler = add_rod(tree->model, crank, 0.3, 0.0, 0.6, 0.45),
              rocker = add_rod(tree->model, at, 0.47, 0.1, 0.3, 0.3);
    if (closed) add_pin(tree->model, coupler, 0.45, rocker, 0.3, 0.0);
    finish_plane(tree);
    for (int k = 0; k < rods + 3; ++k) {
        const int side = k == rods + 1 ? -1 : 1;
        tree->q[k] = k < rods ? 0.2 * sin(2.0 * k) : 1.1 * side;
        tree->u[k] = k < rods ? 0.1 * cos(k) : 0.6 * side;
    }
}

void bench_make_ring(bench_model *tree, int links, int closed)
{
    const double length = 1.0 / links, turn = 2.0 * acos(-1.0) / links;
    int last = MBSR_GROUND;
    begin_plane(tree);
    for (int k = 0; k < links; ++k)
        last = add_rod(tree->model, last, k > 0 ? length : 0.0, 0.0, length, length);
    if (closed) add_pin(tree->model, last, length, MBSR_GROUND, 0.0, 0.0);
    finish_plane(tree);
    for (int k = 0; k < links; ++k) {
        tree->q[k] = k > 0 ? turn : 0.0;
        tree->u[k] = k > 0 ? 0.0 : 0.5;
    }
}

/* A rod along x in space. */
static int add_spatial(mbsr_model *model, int parent, mbsr_joint joint, double mass, double length)
{
    const double com[3] = {0.5 * length, 0.0, 0.0}, across = mass * length * length / 12.0,
                 tensor[6] = {0.1 * across, across, across, 0.0, 0.0, 0.0};
    return add(model, parent, joint,
               mass > 0.0 ? mbsr_inertia_rigid(mass, com, tensor) : mbsr_inertia_zero());
}

void bench_make_linkages(bench_model *tree, int count, bench_coupler on, int massless, int closed)
{
    static const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const int q_of[] = {1, 2, 4}; /* coordinates of the coupler's joint */
    int last = MBSR_GROUND;
    begin_plane(tree);
    mbsr_model *model = tree->model;
    for (int k = 0; k < count; ++k) {
        const mbsr_frame end = mbsr_frame_at(k > 0 ? 0.5 : 0.0, 0.0, 0.0),
                         left = mbsr_frame_at(0.02, 0.1, 0.0), tip = mbsr_frame_at(0.3, 0.0, 0.0),
                         right = mbsr_frame_at(0.47, 0.1, 0.0);
        last = add_spatial(model, last, mbsr_joint_revolute(&end, NULL, k % 2 ? y : z), 1.5, 0.5);
        const int crank = add_spatial(model, last, mbsr_joint_revolute(&left, NULL, z), 0.4, 0.3),
                  coupler =
                      add_spatial(model, crank,
                                  on == BENCH_BALL        ? mbsr_joint_spherical(&tip, NULL)
                                  : on == BENCH_UNIVERSAL ? mbsr_joint_universal(&tip, NULL, z, y)
                                                          : mbsr_joint_revolute(&tip, NULL, z),
                                  massless ? 0.0 : 0.6, 0.45),
                  rocker = add_spatial(model, last, mbsr_joint_revolute(&right, NULL, z), 0.3, 0.3);
        if (closed) add_pin(model, coupler, 0.45, rocker, 0.3, 0.0);
    }
    finish_plane(tree);
    memset(tree->q, 0, (size_t)tree->nq * sizeof *tree->q);
    memset(tree->u, 0, (size_t)tree->nu * sizeof *tree->u);
    for (int k = 0, at = 0; k < count; ++k, at += 3 + q_of[on]) {
        const double angle = 1.0 + 0.3 * sin(k);
        tree->q[at] = 0.2 * sin(2.0 * k);
        tree->q[at + 1] = angle;
        tree->q[at + 2] = on == BENCH_BALL ? cos(0.5 * angle) : -angle;
        if (on == BENCH_BALL) tree->q[at + 5] = -sin(0.5 * angle);
        tree->q[at + 2 + q_of[on]] = angle;
    }
}

/* A leg of six hinges about y, y, x in turn, on the ground. */
static int add_leg(mbsr_model *model, double x, double z)
{
    static const double axis[3][3] = {{0.0, 1.0, 0.0}, {0.0, 1.0, 0.1}, {1.0, 0.0, 0.0}};
    int last = MBSR_GROUND;
    for (int k = 0; k < 6; ++k) {
        const mbsr_frame at =
            k > 0 ? mbsr_frame_at(0.4, 0.0, 0.0) : mbsr_frame_at(2.0 * x, 0.0, 2.0 * z);
        last = add_spatial(model, last, mbsr_joint_revolute(&at, NULL, axis[k % 3]), 0.5, 0.4);
    }
    return last;
}

void bench_make_crowd(bench_model *tree, bench_crowd kind, int count)
{
    begin_plane(tree);
    mbsr_model *model = tree->model;
    const double size = kind == BENCH_CARRIER ? 11.0 : 1.0; /* the carrier's, m and kg */
    int last = kind == BENCH_LEGS ? MBSR_GROUND : add_rod(model, MBSR_GROUND, 0.0, 0.0, size, size);
    for (int k = 0; k < count; ++k) {
        const double x = cos(2.4 * k), z = sin(2.4 * k);
        if (kind == BENCH_LEGS) {
            const int leg = add_leg(model, x, z);
            const mbsr_frame foot = mbsr_frame_at(0.4, 0.0, 0.0), at = mbsr_frame_at(x, 0.0, z);
            const mbsr_closure_def weld = mbsr_closure_weld(leg, &foot, last, &at);
            if (k == 0)
                last = add_spatial(
                    model, leg, mbsr_joint_revolute(&foot, NULL, (double[3]){0, 0, 1}), 20.0, 2.0);
            else if (mbsr_model_add_closure(model, &weld, NULL) != MBSR_OK)
                fail(mbsr_model_error(model)->text, "weld");
            continue;
        }
        const int base = kind == BENCH_BARS ? MBSR_GROUND : last;
        const double at = kind == BENCH_BARS ? k : 10.0 * k / count;
        const int crank = kind == BENCH_BARS ? last : add_rod(model, base, at, 0.0, 1.0, 1.0);
        const int coupler = add_rod(model, crank, 1.0, 0.0, 0.7, 1.0),
                  rocker = add_rod(model, base, at + 1.0, 0.0, 1.3 + 0.1 * z, 1.0);
        add_pin(model, coupler, 1.0, rocker, 1.0, 0.0);
        if (kind == BENCH_BARS) last = rocker;
    }
    finish_plane(tree);
    const int pieces = kind == BENCH_BARS ? 2 : 3; /* bodies of a parallelogram */
    for (int k = 0; k < tree->nq; ++k) {
        const int piece = kind == BENCH_BARS ? 0 : (k - 1) / pieces, at = (k - 1) % pieces;
        const double angle = 1.0 + 0.3 * sin(piece), side = at == pieces - 2 ? -1.0 : 1.0;
        tree->q[k] = kind == BENCH_LEGS ? 0.3 * sin(2.0 * k) : k > 0 ? side * angle : angle;
        tree->u[k] = kind == BENCH_LEGS ? 0.1 * cos(k) : k > 0 ? 0.5 * side : 0.5;
    }
    if (kind == BENCH_CARRIER) tree->q[0] = 0.2, tree->u[0] = 0.1;
}

static int add_slide(mbsr_model *model, int parent, double x)
{
    const mbsr_planar_frame at = {x, 0.0, 0.0}, none = {0.0, 0.0, 0.0};
    const int slide =
        add(model, parent, mbsr_joint_planar_prismatic(at, none), mbsr_inertia_zero());
    const mbsr_force_def spring = mbsr_force_joint_spring(slide, 0, 1e3 + 500.0 * x, 0.0, 0.0);
    if (mbsr_model_add_force(model, &spring, NULL) != MBSR_OK)
        fail(mbsr_model_error(model)->text, "spring");
    return slide;
}

void bench_make_sprung_cranks(bench_model *tree, int count)
{
    const double crank = 0.3, rod = -0.8;
    begin_plane(tree);
    for (int k = 0; k < count; ++k) {
        mbsr_model *m = tree->model;
        const double x = 3.0 * k;
        const int slide = add_slide(m, add_rod(m, MBSR_GROUND, x, 0.0, 1.0, 1.0), 1.0),
                  tip = add_rod(m, add_slide(m, slide, 0.0), 0.0, 0.0, 1.0, 1.0);
        const double at[3] = {x + cos(crank) + cos(crank + rod) - 0.7,
                              sin(crank) + sin(crank + rod) - 1.0, 0.0};
        const mbsr_closure_def stay = mbsr_closure_distance(tip, (double[3]){1.0, 0.0, 0.0},
                                                            MBSR_GROUND, at, hypot(0.7, 1.0));
        if (mbsr_model_add_closure(m, &stay, NULL) != MBSR_OK)
            fail(mbsr_model_error(m)->text, "distance");
    }
    finish_plane(tree);
    for (int k = 0; k < tree->nq; ++k) {
        tree->q[k] = k % 4 == 0 ? crank : k % 4 == 3 ? rod : 0.0;
        tree->u[k] = k % 4 == 0 ? 0.1 : 0.0;
    }
}

/* sum of a_k q of these bodies is zero; loop: as that of a pin. */
static void add_coupling(mbsr_model *model, int terms, const int *body, const double *a,
                         bench_loop loop)
{
    const int first[3] = {0, 0, 0};
    mbsr_closure_def gear = mbsr_closure_coupling(terms, body, first, a, 0.0);
    if (loop == BENCH_OPEN) return;
    if (loop == BENCH_STIFF) gear.stiffness[0] = 1e4, gear.damping[0] = 1.0;
    if (mbsr_model_add_closure(model, &gear, NULL) != MBSR_OK)
        fail(mbsr_model_error(model)->text, "gear");
}

static int add_hinge(mbsr_model *model, int parent, double x, double y, const double axis[3],
                     double mass, double length)
{
    const mbsr_frame at = mbsr_frame_at(x, y, 0.0);
    return add_spatial(model, parent, mbsr_joint_revolute(&at, NULL, axis), mass, length);
}

static int add_hand(mbsr_model *model, int last, int k, bench_loop loop)
{
    static const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, follows[2] = {-0.8, 1.0};
    const int palm = add_hinge(model, last, k > 0 ? 0.1 : 0.0, 0.0, k % 2 ? y : z, 0.5, 0.1);
    for (int finger = 0; finger < 5; ++finger) {
        int at = palm, first = 0;
        for (int joint = 0; joint < 3; ++joint) {
            at = add_hinge(model, at, joint ? 0.04 : 0.1, joint ? 0.0 : 0.02 * (finger - 2),
                           finger ? y : z, 0.04, 0.04);
            if (joint == 0)
                first = at;
            else
                add_coupling(model, 2, (int[2]){first, at}, follows, loop);
        }
    }
    return palm;
}

static int add_differential(mbsr_model *model, int last, int k, bench_loop loop)
{
    static const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, half[3] = {-2.0, 1.0, 1.0};
    const int rod = add_hinge(model, last, k > 0 ? 0.5 : 0.0, 0.0, k % 2 ? y : z, 1.5, 0.5);
    int wheel[3];
    for (int j = 0; j < 3; ++j) wheel[j] = add_hinge(model, rod, 0.1 * j, 0.05, y, 0.3, 0.1);
    add_coupling(model, 3, wheel, half, loop);
    return rod;
}

static int add_gear(mbsr_model *model, int last, int k, bench_gearing kind, bench_loop loop)
{
    static const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, against[2] = {1.0, 1.0};
    const int at = kind == BENCH_TRAIN
                       ? add_hinge(model, MBSR_GROUND, 0.1 * k, 0.0, z, 0.5, 0.05)
                       : add_hinge(model, last, k > 0 ? 0.5 : 0.0, 0.0, k % 2 ? y : z, 1.5, 0.5);
    if (k > 0) add_coupling(model, 2, (int[2]){last, at}, against, loop);
    return at;
}

void bench_make_gearing(bench_model *tree, bench_gearing kind, int count, bench_loop loop)
{
    int last = MBSR_GROUND;
    begin_plane(tree);
    for (int k = 0; k < count; ++k)
        last = kind == BENCH_HANDS           ? add_hand(tree->model, last, k, loop)
               : kind == BENCH_DIFFERENTIALS ? add_differential(tree->model, last, k, loop)
                                             : add_gear(tree->model, last, k, kind, loop);
    finish_plane(tree);
    for (int k = 0; k < tree->nq; ++k) {
        const int joint = kind == BENCH_HANDS ? k % 16 : k % 4;
        double q = 0.2 * sin(2.0 * k), u = 0.1 * cos(k);
        if (kind == BENCH_GEARS || kind == BENCH_TRAIN)
            q = k % 2 ? 0.3 : -0.3, u = k % 2 ? 0.5 : -0.5;
        if (kind == BENCH_HANDS && joint > 0)
            q = joint % 3 == 1 ? 0.5 : 0.4, u = joint % 3 == 1 ? 1.0 : 0.8;
        if (kind == BENCH_DIFFERENTIALS && joint == 1) q = 0.2, u = 0.5;
        if (kind == BENCH_DIFFERENTIALS && joint > 1)
            q = joint == 2 ? 0.5 : -0.1, u = joint == 2 ? 0.9 : 0.1;
        tree->q[k] = q;
        tree->u[k] = u;
    }
}

void bench_free_tree(bench_model *tree)
{
    free(tree->q);
    free(tree->u);
    free(tree->tau);
    free(tree->udot);
    mbsr_model_destroy(tree->model);
}
