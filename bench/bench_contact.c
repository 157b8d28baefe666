/* Contact: errors against closed forms, and what they cost.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_contact [CASE [largest number of spheres in a box [seconds [least number]]]]
 *
 * CSV on standard output.
 *
 * CASE is one of those below; all without. Each line: what ran, with which tolerance, its error,
 * CPU time, simulated time, steps.
 *
 * rolling_y, rolling_xy, bouncing, elastic_balls, dull_balls are cases of
 * leggedrobotics/SimBenchmark (Kang and Hwangbo, 2018), built from its descriptions; their errors
 * are means over 1000 samples of the squared error of velocities (m^2/s^2) or of the energy (J^2).
 * A slab of 10 kg under 25 balls is pulled by 150 N; 49 balls of 10 kg fall by 5 m without loss; 6
 * x 6 x 6 balls of 10 kg fall by 1 m without loss, or with all of it (m^2, squares of depths, by
 * the driver and in fixed steps; here 3 x 3 x 3, and more where the number of spheres allows them).
 * The other cases: ten boxes on each other (error: largest way from rest, m), twenty sledges of two
 * capsules each, thrown over a floor (40 contacts), spheres in a box at rest. */
#include "bench.h"

#include <mbsrank/contact.h>
#include <mbsrank/simulation.h>
#include <mbsrank/stepper.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 1000 };

typedef struct world {
    mbsr_simulation s;
    mbsr_contacts *contacts;
    int bodies, force;
    double *q, *u;
} world;

static void open_world(world *w, int bodies)
{
    mbsr_error error;
    *w = (world){.s = mbsr_simulation_begin(NULL)};
    bench_check(mbsr_contacts_create(&w->contacts, &error), "contacts", error.text);
    mbsr_simulation_add_force(&w->s, mbsr_force_gravity(0.0, 0.0, -9.81));
    w->q = bench_allocate(7 * (size_t)bodies, sizeof *w->q);
    w->u = bench_allocate(6 * (size_t)bodies, sizeof *w->u);
}

static void add_shape_to(world *w, int body, mbsr_shape shape)
{
    mbsr_error error;
    shape.body = body;
    bench_check(mbsr_contacts_add(w->contacts, &shape, NULL, &error), "shape", error.text);
}

static int add_free(world *w, mbsr_inertia inertia, double x, double y, double z)
{
    double *q = w->q + 7 * (ptrdiff_t)w->bodies++;
    q[0] = 1.0;
    q[4] = x, q[5] = y, q[6] = z;
    return mbsr_simulation_add_body(&w->s, NULL, MBSR_GROUND, mbsr_joint_free(NULL, NULL), inertia);
}

/* A plane through x with the normal z. */
static void add_wall(world *w, mbsr_contact_law law, const double x[3], const double z[3])
{
    mbsr_shape wall = mbsr_default_shape();
    wall.kind = MBSR_SHAPE_PLANE;
    wall.frame = mbsr_frame_along(x, z);
    wall.law = law;
    wall.law.stiffness = INFINITY;
    add_shape_to(w, MBSR_GROUND, wall);
}

static void add_floor(world *w, mbsr_contact_law law)
{
    const double x[3] = {0.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    add_wall(w, law, x, z);
}

static mbsr_shape sphere(double radius, mbsr_contact_law law)
{
    mbsr_shape shape = mbsr_default_shape();
    shape.kind = MBSR_SHAPE_SPHERE;
    shape.size[0] = radius;
    shape.law = law;
    return shape;
}

static void start_world(world *w, double tolerance)
{
    mbsr_error error;
    mbsr_force_def force;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    bench_check(mbsr_contacts_force(w->contacts, 0, &force, &error), "element", error.text);
    w->force = mbsr_simulation_add_force(&w->s, force);
    bench_check(mbsr_simulation_start(&w->s, &opt, 0.0, w->q, w->u), "start", w->s.error.text);
}

static double energy_of(const world *w)
{
    double kinetic, potential;
    bench_check(mbsr_energy(w->s.model, w->s.data, &kinetic, &potential), "energy",
                mbsr_data_error(w->s.data)->text);
    return kinetic + potential;
}

static void end_world(world *w)
{
    mbsr_simulation_end(&w->s);
    mbsr_contacts_destroy(w->contacts);
    free(w->q);
    free(w->u);
}

/* Runs to t in so many parts; the mean of `error` at their ends. */
static void run_in_parts(world *w, const char *name, double tolerance, double t, int parts,
                         double (*error)(const world *w, const void *user), const void *user)
{
    double sum = 0.0;
    const double began = bench_now();
    for (int k = 1; k <= parts; ++k) {
        bench_check(mbsr_simulation_to(&w->s, t * k / parts), name, w->s.error.text);
        sum += error(w, user);
    }
    const double cost = bench_now() - began;
    mbsr_ida_stats stats;
    bench_check(mbsr_simulation_get_stats(&w->s, &stats), "stats", NULL);
    printf("%s,libmbsrank,%g,%.3g,%.3g,%g,%ld\n", name, tolerance, sum / parts, cost, t,
           stats.steps);
    fflush(stdout);
    end_world(w);
}

static void run_world(world *w, const char *name, double tolerance, double t,
                      double (*error)(const world *w, const void *user), const void *user)
{
    run_in_parts(w, name, tolerance, t, SAMPLES, error, user);
}

/* ---- cases of SimBenchmark ---- */

/* Squared error of the velocities of slab and first ball; user: direction. */
static double rolling_error(const world *w, const void *user)
{
    const double *way = user;
    const double a = (150.0 - 0.4 * 35.0 * 9.81) / (10.0 + 25.0 * 2.0 / 7.0), v = a * w->s.t;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double slab = w->s.u[3 + k] - v * way[k],
                     ball = w->s.u[9 + k] - 2.0 / 7.0 * v * way[k];
        sum += slab * slab + ball * ball;
    }
    return sum;
}

static void rolling(const char *name, double tolerance)
{
    const double edges[3] = {20.0, 20.0, 1.0}, k = 1e9, deep = 35.0 * 9.81 / (4.0 * k);
    const double angle = strcmp(name, "rolling_y") == 0 ? 0.5 : 1.0 / 3.0,
                 pi = 3.14159265358979323846;
    const double way[3] = {cos(pi * angle), sin(pi * angle), 0.0};
    double wrench[6] = {0.0, 0.0, 0.0, 150.0 * way[0], 150.0 * way[1], 0.0};
    mbsr_contact_law law = {
        .stiffness = k, .exponent = 1.0, .damping = 1e4, .friction = 0.4, .slip = 1e-8};
    world w;
    open_world(&w, 26);
    add_floor(&w, law);
    mbsr_shape slab = mbsr_default_shape();
    for (int l = 0; l < 3; ++l) slab.size[l] = 0.5 * edges[l];
    slab.law = law;
    const int body = add_free(&w, mbsr_inertia_box(10.0 / 400.0, edges), 0.0, 0.0, 0.5 - deep);
    add_shape_to(&w, body, slab);
    law.friction = 0.8;
    for (int l = 0; l < 25; ++l) {
        const int ball = add_free(&w, mbsr_inertia_sphere(6.0 / pi, 0.5), 2.0 * (l / 5) - 4.0,
                                  2.0 * (l % 5) - 4.0, 1.5 - deep - 9.81 / (0.5 * k));
        add_shape_to(&w, ball, sphere(0.5, law));
    }
    mbsr_simulation_add_force(&w.s, mbsr_force_applied(body, mbsr_stored_force, wrench));
    start_world(&w, tolerance);
    run_world(&w, name, tolerance, 4.0, rolling_error, way);
}

/* user: energy at the start */
static double energy_error(const world *w, const void *user)
{
    const double error = energy_of(w) - *(const double *)user;
    return error * error;
}

static void bouncing(const char *name, double tolerance)
{
    const mbsr_contact_law law = {.stiffness = 1e9, .exponent = 1.5};
    const double density = 10.0 / (4.0 / 3.0 * 3.14159265358979323846 * 1e-3);
    world w;
    open_world(&w, 49);
    add_floor(&w, law);
    for (int k = 0; k < 49; ++k)
        add_shape_to(
            &w, add_free(&w, mbsr_inertia_sphere(density, 0.1), 2.0 * (k / 7), 2.0 * (k % 7), 5.0),
            sphere(0.1, law));
    start_world(&w, tolerance);
    const double energy = energy_of(&w);
    run_world(&w, name, tolerance, 20.0, energy_error, &energy);
}

/* Of side^3 balls; the published cases have side 6. */
static int cube_side = 3;

/* Balls of 10 kg in a cube, 1 m above the floor, each shifted by up to a millimetre. */
static void open_cube(world *w, mbsr_contact_law law)
{
    const int side = cube_side, balls = side * side * side;
    const double density = 10.0 / (4.0 / 3.0 * 3.14159265358979323846 * 1e-3);
    uint64_t seed = 42;
    open_world(w, balls);
    add_floor(w, law);
    for (int k = 0; k < balls; ++k) {
        double x[3];
        for (int l = 0; l < 3; ++l) x[l] = bench_uniform(&seed, 0.0, 1e-3);
        add_shape_to(w,
                     add_free(w, mbsr_inertia_sphere(density, 0.1), 0.21 * (k % side) + x[0],
                              0.21 * (k / side % side) + x[1],
                              1.101 + 0.21 * (k / side / side) + x[2]),
                     sphere(0.1, law));
    }
}

static void run_cube(world *w, const char *name, double tolerance,
                     double (*error)(const world *w, const void *user), const void *user)
{
    char of[40];
    snprintf(of, sizeof of, "%s_%d", name, w->bodies);
    run_world(w, of, tolerance, 2.0, error, user);
}

static void elastic_balls(const char *name, double tolerance)
{
    world w;
    open_cube(&w, (mbsr_contact_law){.stiffness = 1e9, .exponent = 1.5});
    start_world(&w, tolerance);
    const double energy = energy_of(&w);
    run_cube(&w, name, tolerance, energy_error, &energy);
}

/* Squares of how deep balls are in each other and in the floor. */
static double overlap(const world *w, const void *user)
{
    double sum = 0.0;
    (void)user;
    for (int k = 0; k < w->bodies; ++k) {
        const double *x = w->s.q + 7 * k + 4, deep = fmax(0.0, 0.1 - x[2]);
        sum += deep * deep;
        for (int l = 0; l < k; ++l) {
            const double *y = w->s.q + 7 * l + 4;
            const double square = (x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                                  (x[2] - y[2]) * (x[2] - y[2]);
            if (square < 0.04) sum += (0.2 - sqrt(square)) * (0.2 - sqrt(square));
        }
    }
    return sum;
}

/* They keep a thirtieth of the speed of the first blow. */
static void dull_balls(const char *name, double tolerance)
{
    world w;
    open_cube(&w, (mbsr_contact_law){.stiffness = 1e9, .exponent = 1.5, .damping = 7.0});
    start_world(&w, tolerance);
    run_cube(&w, name, tolerance, overlap, NULL);
}

/* The same in steps of fixed size h and order 1, a sample for each. Their accuracy is that of the
 * depths, which the law determines; corrections may leave a thousandth of a radius. */
static void stepped_balls(const char *name, double h, mbsr_contact_law law)
{
    enum { SECONDS = 2 };
    mbsr_error error;
    mbsr_stepper *stepper;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    const int steps = (int)lround(SECONDS / h);
    double sum = 0.0;
    world w;
    open_cube(&w, law);
    start_world(&w, 1e-3);
    opt.h = h;
    opt.order = 1;
    opt.tolerance = 1e-3;
    bench_check(mbsr_stepper_create(w.s.model, w.s.data, &opt, &stepper, &error), name, error.text);
    bench_check(mbsr_stepper_start(stepper, 0.0, w.q, w.u), name, NULL);
    const double began = bench_now();
    for (int k = 0; k < steps; ++k) {
        bench_check(mbsr_stepper_step(stepper), name, mbsr_stepper_error(stepper)->text);
        (void)mbsr_stepper_motion(stepper, NULL, w.s.q, NULL);
        sum += overlap(&w, NULL);
    }
    printf("%s_%d,libmbsrank,steps of %g,%.3g,%.3g,%d,%d\n", name, w.bodies, h, sum / steps,
           bench_now() - began, SECONDS, steps);
    mbsr_stepper_destroy(stepper);
    end_world(&w);
}

/* Stiffnesses for which balls are as deep in each other as MuJoCo's with both of its settings. */
static void dull_balls_stepped(const char *name, double h)
{
    /* The steps take what a blow has, all but 5 % and .5 % of its velocity: no damping is needed.
     */
    stepped_balls(name, h, (mbsr_contact_law){.stiffness = 2e7, .exponent = 1.0});
    stepped_balls(name, h, (mbsr_contact_law){.stiffness = 2e8, .exponent = 1.0});
}

/* ---- others ---- */

/* The largest way of a body from where it was, along x and y. */
static double drift(const world *w, const void *user)
{
    double most = 0.0;
    (void)user;
    for (int k = 0; k < w->bodies; ++k)
        most = fmax(
            most, hypot(w->s.q[7 * k + 4] - w->q[7 * k + 4], w->s.q[7 * k + 5] - w->q[7 * k + 5]));
    return most;
}

static void stack(const char *name, double tolerance)
{
    const mbsr_contact_law law = {
        .stiffness = 1e7, .exponent = 1.5, .damping = 1.0, .friction = 0.5, .slip = 1e-4};
    const double edges[3] = {0.2, 0.2, 0.2};
    mbsr_shape box = mbsr_default_shape();
    world w;
    open_world(&w, 10);
    add_floor(&w, law);
    box.law = law;
    for (int l = 0; l < 3; ++l) box.size[l] = 0.1;
    for (int k = 0; k < 10; ++k)
        add_shape_to(&w, add_free(&w, mbsr_inertia_box(1000.0, edges), 0.0, 0.0, 0.1 + 0.2 * k),
                     box);
    start_world(&w, tolerance);
    run_world(&w, name, tolerance, 100.0, drift, NULL);
}

static double nothing_known(const world *w, const void *user)
{
    (void)w, (void)user;
    return NAN;
}

static void sledges(const char *name, double tolerance)
{
    const mbsr_contact_law law = {
        .stiffness = 1e6, .exponent = 1.5, .damping = 1.0, .friction = 0.4, .slip = 1e-3};
    const double edges[3] = {0.3, 0.2, 0.1};
    world w;
    open_world(&w, 20);
    add_floor(&w, law);
    for (int k = 0; k < 20; ++k) {
        const int body =
            add_free(&w, mbsr_inertia_box(1000.0, edges), k % 5, 1.0 * (k / 5), 0.1 + 0.01 * k);
        for (int l = 0; l < 2; ++l) {
            mbsr_shape runner = sphere(0.03, law);
            const double x[3] = {0.0, l ? 0.1 : -0.1, -0.05}, z[3] = {1.0, 0.0, 0.0};
            runner.kind = MBSR_SHAPE_CAPSULE;
            runner.size[1] = 0.15;
            runner.frame = mbsr_frame_along(x, z);
            add_shape_to(&w, body, runner);
        }
        w.u[6 * k + 3] = 1.0 + 0.1 * k;
        w.u[6 * k + 1] = 0.2 * (k % 4);
    }
    start_world(&w, tolerance);
    run_world(&w, name, tolerance, 2.0, nothing_known, NULL);
}

/* side^3 spheres fall into a box and come to rest. */
static void box_of_spheres(int side, double tolerance, double t)
{
    const mbsr_contact_law law = {
        .stiffness = 1e4, .exponent = 1.5, .damping = 2.0, .friction = 0.3, .slip = 1e-3};
    const double half = 0.11 * side, centre = 0.2 * 0.5 * (side - 1);
    char name[40];
    world w;
    open_world(&w, side * side * side);
    add_floor(&w, law);
    for (int k = 0; k < 4; ++k) {
        const double z[3] = {k < 2 ? 1.0 - 2.0 * k : 0.0, k < 2 ? 0.0 : 5.0 - 2.0 * k, 0.0},
                     x[3] = {-half * z[0], -half * z[1], 0.0};
        add_wall(&w, law, x, z);
    }
    for (int k = 0; k < side * side * side; ++k) {
        const double shift = 5e-3 * sin(7.0 * k);
        add_shape_to(
            &w,
            add_free(&w, mbsr_inertia_sphere(240.0, 0.1), 0.2 * (k % side) - centre + shift,
                     0.2 * (k / side % side) - centre - shift, 0.11 + 0.22 * (k / side / side)),
            sphere(0.1, law));
    }
    snprintf(name, sizeof name, "box_of_%d", side * side * side);
    start_world(&w, tolerance);
    run_in_parts(&w, name, tolerance, t, 1, nothing_known, NULL);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*run)(const char *name, double tolerance);
        double tolerance[3]; /* 0: none more */
    } cases[] = {{"rolling_y", rolling, {1e-6, 1e-8, 1e-10}},
                 {"rolling_xy", rolling, {1e-6, 1e-8, 1e-10}},
                 {"bouncing", bouncing, {1e-5, 1e-7, 1e-9}},
                 {"elastic_balls", elastic_balls, {1e-5, 1e-7, 0.0}},
                 {"dull_balls", dull_balls, {1e-3, 0.0, 0.0}},
                 {"dull_balls", dull_balls_stepped, {2e-3, 0.0, 0.0}},
                 {"stack", stack, {1e-4, 1e-6, 0.0}},
                 {"sledges", sledges, {1e-4, 1e-6, 0.0}}};
    const char *only = argc > 1 && strcmp(argv[1], "all") != 0 ? argv[1] : NULL;
    const int most = argc > 2 ? atoi(argv[2]) : 125, least = argc > 4 ? atoi(argv[4]) : 8;
    const double time = argc > 3 ? atof(argv[3]) : 1.0;
    if (only && argc > 2)
        while (cube_side < 6 && (cube_side + 1) * (cube_side + 1) * (cube_side + 1) <= most)
            ++cube_side;
    bench_header(stdout, "contact");
    puts("case,program,setting,error,cpu_s,simulated_s,steps");
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        for (int l = 0; l < 3 && cases[k].tolerance[l] > 0.0; ++l)
            if (!only || strcmp(only, cases[k].name) == 0)
                cases[k].run(cases[k].name, cases[k].tolerance[l]);
    }
    for (int side = 2; side * side * side <= most; ++side)
        if (side * side * side >= least && (!only || strcmp(only, "box") == 0))
            box_of_spheres(side, 1e-3, time);
    return 0;
}
