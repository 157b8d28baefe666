/* Stiff trees with parts without mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stiff.h"

#include "bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double g = 9.81;

static void begin(stiff_model *s, const char *name, int bodies, int balls, int loads)
{
    memset(s, 0, sizeof *s);
    snprintf(s->name, sizeof s->name, "%s", name);
    s->body = bench_allocate((size_t)bodies, sizeof *s->body);
    s->ball = bench_allocate((size_t)balls + 1, sizeof *s->ball);
    s->load = bench_allocate((size_t)loads + 1, sizeof *s->load);
}

void stiff_free(stiff_model *s)
{
    free(s->body);
    free(s->ball);
    free(s->load);
}

/* A body at (x, y, z) of its predecessor; its number. */
static int add(stiff_model *s, int parent, double x, double y, double z)
{
    stiff_body *b = s->body + s->bodies;
    b->parent = parent;
    b->place[0] = x, b->place[1] = y, b->place[2] = z;
    ++s->massless;
    return s->bodies++;
}

static void weigh(stiff_model *s, int body, double mass, const double com[3],
                  const double tensor[6])
{
    stiff_body *b = s->body + body;
    b->mass = mass;
    memcpy(b->com, com, sizeof b->com);
    memcpy(b->tensor, tensor, sizeof b->tensor);
    --s->massless;
}

/* One more axis of a body's joint, along x, y or z; `rest` so that it pushes with `load` at 0. */
static void axis(stiff_model *s, int body, int turns, int along, double stiffness, double damping,
                 double load)
{
    stiff_axis *a = s->body[body].axis + s->body[body].axes++;
    a->turns = turns;
    a->direction[along] = 1.0;
    a->stiffness = stiffness;
    a->damping = damping;
    a->rest = stiffness > 0.0 ? load / stiffness : 0.0;
}

/* ---- beam ------------------------------------------------------------------------------------ */

static void push_tip(int k, double t, const double *p, const double *v, double *f)
{
    const double pi = acos(-1.0), phi = t <= pi ? 1.5 * sin(t) * sin(t) : 0.0;
    (void)k, (void)p, (void)v;
    f[0] = -phi, f[1] = phi, f[2] = 0.0;
}

void stiff_beam(stiff_model *s, int n)
{
    const double retardation = 1e-3; /* s */
    const double l = 1.0 / n, end[3] = {l, 0.0, 0.0}, none[6] = {0.0};
    begin(s, "beam", n, 0, 1);
    for (int k = 0; k < n; ++k) {
        const double stiffness = k == 0 ? 2.0 * n : n;
        add(s, k - 1, k == 0 ? 0.0 : l, 0.0, 0.0);
        axis(s, k, 1, 2, stiffness, retardation * stiffness, 0.0);
        weigh(s, k, k < n - 1 ? l : 0.5 * l, end, none);
    }
    s->in_plane = 1;
    s->loads = 1;
    s->load[0] = n - 1;
    memcpy(s->load_at, end, sizeof end);
    s->force = push_tip;
    s->T = 5.0;
    s->chain = 1;
    s->mass_size = l;
    s->moment_size = l * l * l;
}

/* ---- cable ----------------------------------------------------------------------------------- */

/* Pulls the end to one side and then to another, smoothly. */
static void pull_end(int k, double t, const double *p, const double *v, double *f)
{
    const double pi = acos(-1.0), most = 4.0; /* N */
    (void)k, (void)p, (void)v;
    f[0] = t < 1.0 ? most * sin(pi * t) * sin(pi * t) : 0.0;
    f[1] = t > 0.5 && t < 1.5 ? most * cos(pi * t) * cos(pi * t) : 0.0;
    f[2] = 0.0;
}

void stiff_cable(stiff_model *s, int n)
{
    const double length = 10.0, mass = 2.0, bending = 0.5, retardation = 1e-2; /* m, kg, N m^2, s */
    const double l = length / n, end[3] = {0.0, 0.0, -l}, none[6] = {0.0};
    begin(s, "cable", n, 0, 1);
    for (int k = 0; k < n; ++k) {
        const double stiffness = (k == 0 ? 2.0 : 1.0) * bending / l;
        add(s, k - 1, 0.0, 0.0, k == 0 ? 0.0 : -l);
        for (int along = 0; along < 2; ++along)
            axis(s, k, 1, along, stiffness, retardation * stiffness, 0.0);
        weigh(s, k, mass / n, end, none);
    }
    s->loads = 1;
    s->load[0] = n - 1;
    memcpy(s->load_at, end, sizeof end);
    s->force = pull_end;
    s->gravity[2] = -g;
    s->T = 1.0;
    s->chain = 1;
    s->mass_size = mass / n;
    s->moment_size = mass / n * l * l;
}

/* ---- vehicle --------------------------------------------------------------------------------- */

static const double axle = 1.3, speed = 15.0, wheel_load = 350.0 * 9.81, tyre_load = 390.0 * 9.81;

/* Height of the road under wheel k = 2 * (rear) + right, m: a bump, higher on the left. */
static double road(int k, double t)
{
    const double from = 0.1 + (k < 2 ? 0.0 : 2.0 * axle / speed), width = 0.12;
    const double height = k % 2 ? 0.03 : 0.05, x = (t - from) / width;
    return x > 0.0 && x < 1.0 ? 0.5 * height * (1.0 - cos(2.0 * acos(-1.0) * x)) : 0.0;
}

/* On the contact patch. */
static void stand(int k, double t, const double *p, const double *v, double *f)
{
    const double stiffness = 1e6, slip = 500.0; /* N/m, N s/m */
    f[0] = -slip * v[0];
    f[1] = -slip * v[1];
    f[2] = tyre_load - stiffness * (p[2] - road(k, t));
}

/* A ball joint with rubber: a point of one body is held at a point of another. */
static void hold(stiff_model *s, int a, double ax, double ay, double az, int b, double bx,
                 double by, double bz)
{
    s->ball[s->balls++] = (stiff_ball){.a = a,
                                       .b = b,
                                       .at_a = {ax, ay, az},
                                       .at_b = {bx, by, bz},
                                       .stiffness = 5e6,
                                       .damping = 5e3,
                                       .length = 0.06};
}

enum { TRANSLATION, ROTATION };

/* Arm, upright with bearing, wheel and contact patch; the arm's number. x, y: middle of the wheel.
 * */
static int wheel_on_arm(stiff_model *s, double x, double side)
{
    const double centre[3] = {0.0}, tensor[6] = {0.8, 1.5, 0.8};
    const int arm = add(s, 0, x, 0.35 * side, -0.32);
    axis(s, arm, TRANSLATION, 0, 3e6, 3e3, 0.0);
    axis(s, arm, TRANSLATION, 1, 4e6, 4e3, 0.0);
    axis(s, arm, ROTATION, 0, 300.0, 3.0, 0.0);
    const int upright = add(s, arm, 0.0, 0.38 * side, 0.0);
    axis(s, upright, ROTATION, 2, 50.0, 2.0, 0.0);
    axis(s, upright, ROTATION, 0, 50.0, 2.0, 0.0);
    axis(s, upright, ROTATION, 1, 50.0, 2.0, 0.0);
    const int bearing = add(s, upright, 0.0, 0.02 * side, 0.07);
    axis(s, bearing, ROTATION, 2, 2e5, 100.0, 0.0);
    axis(s, bearing, ROTATION, 0, 2e5, 100.0, 0.0);
    const int wheel = add(s, bearing, 0.0, 0.0, 0.0);
    axis(s, wheel, ROTATION, 1, 0.0, 0.5, 0.0);
    weigh(s, wheel, 40.0, centre, tensor);
    const int patch = add(s, bearing, 0.0, 0.0, -0.30);
    axis(s, patch, TRANSLATION, 0, 2e5, 1e3, 0.0);
    axis(s, patch, TRANSLATION, 1, 1.5e5, 1e3, 0.0);
    axis(s, patch, TRANSLATION, 2, 2.2e5, 300.0, -tyre_load);
    s->load[s->loads++] = patch;
    return arm;
}

/* Upper arm, tie rod on the rack and trailing rod, which hold the upright. */
static void links(stiff_model *s, double x, double side, int rack, double ahead, int upright)
{
    const int upper = add(s, 0, x, 0.40 * side, 0.05);
    axis(s, upper, ROTATION, 0, 200.0, 2.0, 0.0);
    hold(s, upper, 0.0, 0.31 * side, 0.0, upright, 0.0, -0.02 * side, 0.37);
    const int tie = add(s, rack, 0.0, 0.38 * side, 0.0);
    axis(s, tie, ROTATION, 2, 20.0, 0.5, 0.0);
    axis(s, tie, ROTATION, 0, 20.0, 0.5, 0.0);
    hold(s, tie, 0.0, 0.35 * side, 0.0, upright, ahead, 0.0, 0.02);
    const int trailing = add(s, 0, x - 0.5, 0.60 * side, -0.35);
    axis(s, trailing, ROTATION, 2, 20.0, 0.5, 0.0);
    axis(s, trailing, ROTATION, 1, 20.0, 0.5, 0.0);
    hold(s, trailing, 0.50, 0.0, 0.0, upright, 0.0, -0.13 * side, -0.03);
}

/* Mount, tube and piston, three spring-dampers in series from the chassis to the arm. */
static void strut(stiff_model *s, double x, double side, int arm)
{
    const double load = wheel_load * 0.38 / 0.20;
    const int mount = add(s, 0, x, 0.55 * side, 0.30);
    axis(s, mount, TRANSLATION, 2, 6e5, 600.0, -load);
    axis(s, mount, ROTATION, 0, 30.0, 1.0, 0.0);
    axis(s, mount, ROTATION, 1, 30.0, 1.0, 0.0);
    const int tube = add(s, mount, 0.0, 0.0, -0.25);
    axis(s, tube, TRANSLATION, 2, 2e5, 100.0, -load);
    const int piston = add(s, tube, 0.0, 0.0, -0.20);
    axis(s, piston, TRANSLATION, 2, 25e3, 2e3, -load);
    hold(s, piston, 0.0, 0.0, -0.14, arm, 0.0, 0.20 * side, 0.03);
}

/* Half of an anti-roll bar and its drop link; the right half turns on the left one. */
static int anti_roll(stiff_model *s, double x, double side, int left, int arm)
{
    const int bar = side > 0.0 ? add(s, 0, x - 0.25, 0.40, -0.10) : add(s, left, 0.0, -0.80, 0.0);
    axis(s, bar, ROTATION, 1, side > 0.0 ? 10.0 : 3e3, side > 0.0 ? 1.0 : 3.0, 0.0);
    const int drop = add(s, bar, 0.25, 0.0, 0.0);
    axis(s, drop, ROTATION, 0, 5.0, 0.3, 0.0);
    axis(s, drop, ROTATION, 1, 5.0, 0.3, 0.0);
    hold(s, drop, 0.0, 0.0, -0.19, arm, 0.0, 0.05 * side, 0.03);
    return bar;
}

void stiff_vehicle(stiff_model *s)
{
    enum { BODIES = 55, BALLS = 20, WHEELS = 4 };
    const double centre[3] = {0.0}, tensor[6] = {500.0, 2200.0, 2400.0};
    begin(s, "vehicle", BODIES, BALLS, WHEELS);
    s->body[add(s, STIFF_GROUND, 0.0, 0.0, 0.55)].free = 1;
    weigh(s, 0, 1400.0, centre, tensor);
    for (int rear = 0; rear < 2; ++rear) {
        const double x = rear ? -axle : axle, ahead = rear ? -0.15 : 0.15;
        const int rack = add(s, 0, x + ahead, 0.0, -0.30);
        axis(s, rack, TRANSLATION, 1, 2e6, 5e3, 0.0);
        for (int right = 0, bar = 0; right < 2; ++right) {
            const double side = right ? -1.0 : 1.0;
            const int arm = wheel_on_arm(s, x, side);
            links(s, x, side, rack, ahead, arm + 1);
            strut(s, x, side, arm);
            bar = anti_roll(s, x, side, bar, arm);
        }
    }
    s->force = stand;
    s->gravity[2] = -g;
    s->T = 1.0;
    s->mass_size = 10.0;
    s->moment_size = 0.1;
}

/* ---- random trees ---------------------------------------------------------------------------- */

static void random_direction(uint64_t *seed, double direction[3])
{
    double square;
    do {
        square = 0.0;
        for (int k = 0; k < 3; ++k) {
            direction[k] = bench_uniform(seed, -1.0, 1.0);
            square += direction[k] * direction[k];
        }
    } while (square > 1.0 || square < 0.01);
    for (int k = 0; k < 3; ++k) direction[k] /= sqrt(square);
}

/* Any body before k with mass, all equally likely: those with k % 3 != 0. */
static int random_parent(uint64_t *seed, int k)
{
    const int with_mass = k - (k + 2) / 3;
    if (with_mass == 0) return STIFF_GROUND;
    const int chosen = (int)(bench_random(seed) % (uint64_t)with_mass);
    return chosen / 2 * 3 + 1 + chosen % 2;
}

static void random_body(stiff_model *s, uint64_t *seed, int k)
{
    static const double tensor[6] = {0.02, 0.018, 0.012, 0.001, -0.002, 0.0005};
    const int rides = k % 3 == 1;
    double x[3], com[3];
    for (int i = 0; i < 3; ++i) {
        x[i] = rides ? 0.0 : bench_uniform(seed, -0.3, 0.3);
        com[i] = bench_uniform(seed, -0.1, 0.1);
    }
    add(s, rides ? k - 1 : random_parent(seed, k), x[0], x[1], x[2]);
    axis(s, k, 1, 0, 0.0, 0.0, 0.0);
    stiff_axis *a = s->body[k].axis;
    if (rides)
        memcpy(a->direction, s->body[k - 1].axis->direction, sizeof a->direction);
    else
        random_direction(seed, a->direction);
    if (k % 3 != 0) weigh(s, k, 1.5, com, tensor);
    a->rest = a->start = bench_uniform(seed, -1.0, 1.0);
}

void stiff_tree(stiff_model *s, int n)
{
    uint64_t seed = 1;
    const double lever = 0.5; /* m, of a weight */
    begin(s, "tree", n, 0, 0);
    for (int k = 0; k < n; ++k) random_body(s, &seed, k);
    double *behind = bench_allocate((size_t)n, sizeof *behind);
    for (int k = n - 1; k >= 0; --k) {
        stiff_axis *a = s->body[k].axis;
        behind[k] += s->body[k].mass;
        if (s->body[k].parent >= 0) behind[s->body[k].parent] += behind[k];
        const double weight = fmax(behind[k], 1.5) * g * lever;
        a->stiffness = weight * pow(10.0, bench_uniform(&seed, 1.0, 5.0));
        a->damping = a->stiffness * pow(10.0, bench_uniform(&seed, -4.0, -2.0));
    }
    free(behind);
    s->gravity[2] = -g;
    s->T = 1.0;
    s->mass_size = 1.5;
    s->moment_size = 0.02;
}
