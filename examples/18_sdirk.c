/* A solver of one's own with the Newton systems solved on the tree: a rope swings against a wall.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * sdirk.h has the method. The rope is a chain of N rigid segments without inertia on ball joints
 * (quaternions), a particle at the end of each; joints resist bending and twist by springs and
 * dampers, stiff against weight. Turning a segment about itself moves no mass: N directions that
 * turn with the motion, whose velocities follow from the balance of moments (index 1). The rope is
 * let go at 60 degrees and lays itself against a wall that it meets askew; contact with friction
 * lifts it out of its plane and twists it. The contact is that of balls of radius 1 cm about the
 * particles with a wall that gives by the law of Hertz: a ball that strikes it at speed v goes in
 * by (5/4 mass v^2 / stiffness)^(2/5). That is 2.5 cm for the last one, which is the fastest with
 * 6.3 m/s; the rope behind it makes it 2.8 cm, so its particle is behind the wall for about 10 ms.
 *
 * First N = 20 is run at two tolerances. Energy and heat must add up, with the heat summed by the
 * weights of the method over its stages, and the rope's end must come to where another solver sees
 * it. Then N = 50 .. 400: the times of a factorisation, an iteration and a step must grow as N.
 * With a dense matrix of 10 N rows a factorisation for N = 400 would take 512 times as long as one
 * for N = 50. rope.csv has shapes for rope.gp. With any argument the finer tolerance and the two
 * longest ropes are left out. */
#include <mbsrank/mbsrank.h>

#include "progress.h"
#include "sdirk.h"

#include <time.h>

enum { CHECKED = 20, LONGEST = 400, SIZES = 4, SHAPES = 10, RUNS = 2, STEPS = 20 };
static const double length = 2.0, mass = 0.2, g = 9.81;    /* m, kg, m/s^2 */
static const double stiffness = 0.002, retardation = 0.01; /* N m^2, s: damping over stiffness */
static const double slant = 1.0471975511965976, T = 1.0;   /* rad, s */

/* The wall: a point, its normal, and the radius of what touches it, m. */
static const double at[3] = {-0.4, 0.0, 0.0}, normal[3] = {1.0, 0.6, 0.0}, radius = 0.01;

/* The end of the rope of 20 at T, m: the driver for IDA (ida.h) with dense matrices by difference
 * quotients, rtol = atol = 1e-8. */
static const double reference[3] = {0.026489, 0.639909, 0.373366};

static mbsr_model *rope(int segments)
{
    const double l = length / segments, k = stiffness / l, d = retardation * k,
                 springs[6] = {k, k, k}, dampers[6] = {d, d, d}, end[3] = {0.0, 0.0, -l};
    const mbsr_frame hook = mbsr_frame_at(0.0, 0.0, length), next = mbsr_frame_at(0.0, 0.0, -l);
    const mbsr_contact wall = {.centre = {0.0, 0.0, -l},
                               .radius = radius,
                               .point = {at[0], at[1], at[2]},
                               .normal = {normal[0], normal[1], normal[2]},
                               .stiffness = 1e5 / segments,
                               .exponent = 1.5,
                               .damping = 0.1,
                               .friction = 0.3,
                               .slip = 0.02};
    mbsr_model *m = new_model();
    int last = MBSR_GROUND;
    for (int i = 0; i < segments; ++i) {
        const mbsr_frame *A = i > 0 ? &next : &hook;
        const int body = add_body(m, NULL, last, mbsr_joint_spherical(A, NULL),
                                  mbsr_inertia_point_mass(mass / segments, end));
        add_force(m, mbsr_force_bushing(last, A, body, NULL, springs, dampers));
        add_force(m, mbsr_force_contact(body, MBSR_GROUND, &wall));
        last = body;
    }
    add_force(m, mbsr_force_gravity(0.0, 0.0, -g));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

typedef struct hung {
    mbsr_model *m;
    mbsr_data *d;
    double *y;
} hung;

/* Straight, at rest, at an angle. */
static hung hang(int segments)
{
    static double q[4 * LONGEST], u[3 * LONGEST];
    hung r = {.m = rope(segments)};
    mbsr_error error;
    for (int i = 0; i < segments; ++i) {
        q[4 * i] = i > 0 ? 1.0 : cos(0.5 * slant);
        q[4 * i + 2] = i > 0 ? 0.0 : -sin(0.5 * slant);
    }
    check(mbsr_data_create(r.m, &r.d, &error), &error);
    r.y = calloc((size_t)mbsr_dae_size(r.m, MBSR_DAE_MOMENTUM), sizeof *r.y);
    if (!r.y) exit(1);
    check(mbsr_dae_pack(r.m, r.d, MBSR_DAE_MOMENTUM, 0.0, q, u, r.y), mbsr_data_error(r.d));
    return r;
}

static void put_away(hung *r)
{
    mbsr_data_destroy(r->d);
    mbsr_model_destroy(r->m);
    free(r->y);
}

static void evaluate(const sdirk *s, double t, const double *y)
{
    check(mbsr_stage_positions(s->m, s->d, t, y), mbsr_data_error(s->d));
    check(mbsr_stage_velocities(s->m, s->d, y + s->nq + s->nu), mbsr_data_error(s->d));
}

static double energy(const sdirk *s)
{
    double kinetic, potential;
    evaluate(s, s->t, s->y);
    check(mbsr_energy(s->m, s->d, &kinetic, &potential), mbsr_data_error(s->d));
    return kinetic + potential;
}

/* Heat of the last step, of size h, by the method's own weights. */
static double heat(const sdirk *s, double h)
{
    double sum = 0.0, power;
    for (int i = 0; i < SDIRK_STAGES; ++i) {
        evaluate(s, s->t - h + s->at[i] * h, s->Y[i]);
        check(mbsr_dissipation(s->m, s->d, &power), mbsr_data_error(s->d));
        sum += h * s->a[SDIRK_STAGES - 1][i] * power;
    }
    return sum;
}

/* Where the particle of a segment is, at the state evaluated: at (0, 0, -l), third column of R. */
static void particle(const sdirk *s, int body, double r[3])
{
    const double l = length / mbsr_model_bodies(s->m);
    double p[MBSR_POSE_SIZE];
    check(mbsr_body_pose(s->m, s->d, body, p), mbsr_data_error(s->d));
    for (int k = 0; k < 3; ++k) r[k] = p[MBSR_POSE_X + k] - l * p[MBSR_POSE_R + 6 + k];
}

/* How far the wall is pressed in, m: by the ball that is deepest. */
static double depth(const sdirk *s)
{
    double r[3], deepest = 0.0;
    evaluate(s, s->t, s->y);
    for (int i = 0; i < mbsr_model_bodies(s->m); ++i) {
        particle(s, i, r);
        const double off = (r[0] - at[0]) * normal[0] + (r[1] - at[1]) * normal[1];
        deepest = fmax(deepest, radius - off / hypot(normal[0], normal[1]));
    }
    return deepest;
}

/* The rope's points into the file, the last into tip. */
static void shape(const sdirk *s, FILE *file, double tip[3])
{
    evaluate(s, s->t, s->y);
    fprintf(file, "%g,0,0,%g\n", s->t, length);
    for (int i = 0; i < mbsr_model_bodies(s->m); ++i) {
        particle(s, i, tip);
        fprintf(file, "%g,%g,%g,%g\n", s->t, tip[0], tip[1], tip[2]);
    }
    fprintf(file, "\n\n");
}

typedef struct outcome {
    double heat, balance, off, depth; /* J, J: what energy and heat do not add up by; m, m */
} outcome;

static outcome swing(double tolerance)
{
    outcome found = {0};
    FILE *file = csv("rope.csv");
    hung r = hang(CHECKED);
    mbsr_consistent_info start;
    double *yp = calloc((size_t)mbsr_dae_size(r.m, MBSR_DAE_MOMENTUM), sizeof *yp);
    if (!yp) exit(1);
    check(mbsr_dae_consistent(r.m, r.d, MBSR_DAE_MOMENTUM, 0.0, r.y, yp, NULL, &start),
          mbsr_data_error(r.d));
    free(yp);
    sdirk s = sdirk_start(r.m, r.d, 0.0, r.y, 1e-4, tolerance);
    double tip[3];
    const double begin = energy(&s);
    shape(&s, file, tip);
    for (int k = 1; k <= SHAPES; ++k) {
        while (s.t < T * k / SHAPES) {
            found.heat += heat(&s, sdirk_step(&s, T * k / SHAPES));
            found.depth = fmax(found.depth, depth(&s));
            show_progress(s.t / T);
        }
        shape(&s, file, tip);
    }
    found.balance = energy(&s) + found.heat - begin;
    for (int k = 0; k < 3; ++k) found.off = fmax(found.off, fabs(tip[k] - reference[k]));
    mbsr_newton_info done;
    check(mbsr_newton_get_info(s.newton, &done), mbsr_newton_error(s.newton));
    printf("%9.0e %6ld %8ld %8ld %8ld   %.6f %+.1e   %14.4f   %+.5f %+.5f %+.5f\n", tolerance,
           s.steps, s.rejected, done.factorisations, done.solves, found.heat, found.balance,
           found.depth, tip[0], tip[1], tip[2]);
    if (start.null_directions != CHECKED || start.elastic) exit(1);
    fclose(file);
    sdirk_end(&s);
    put_away(&r);
    return found;
}

/* Processor time, s. */
static double now(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* Times of a factorisation and of an iteration at the state reached, s. */
static void measure(sdirk *s, double *factor, double *iterate)
{
    const double c = 1.0 / (s->a[0][0] * s->h);
    const int times = 1000 / mbsr_model_bodies(s->m);
    *factor = *iterate = INFINITY;
    for (int round = 0; round < 3; ++round) {
        const double begin = now();
        for (int k = 0; k < times; ++k) {
            check(mbsr_newton_factor(s->newton, s->d, s->t, s->y, s->yp, c),
                  mbsr_newton_error(s->newton));
        }
        const double middle = now();
        for (int k = 0; k < times; ++k) {
            check(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, s->y, s->yp, s->F),
                  mbsr_data_error(s->d));
            check(mbsr_newton_solve(s->newton, s->F, s->delta), mbsr_newton_error(s->newton));
        }
        *factor = fmin(*factor, (middle - begin) / times);
        *iterate = fmin(*iterate, (now() - middle) / times);
    }
}

/* Returns the time of a factorisation and ten iterations, which is about a step's, per body. */
static double grow(int segments)
{
    double factor, iterate;
    hung r = hang(segments);
    sdirk s = sdirk_start(r.m, r.d, 0.0, r.y, 1e-4, 1e-3);
    const double begin = now();
    while (s.steps < STEPS) {
        sdirk_step(&s, T);
        show_progress((double)s.steps / STEPS);
    }
    const double step = (now() - begin) / STEPS;
    measure(&s, &factor, &iterate);
    printf("%5d %14.2f %14.2f %14.2f\n", segments, 1e3 * factor, 1e3 * iterate, 1e3 * step);
    sdirk_end(&s);
    put_away(&r);
    return (factor + 10.0 * iterate) / segments;
}

int main(int argc, char **argv)
{
    (void)argv;
    const double tolerance[RUNS] = {1e-3, 1e-4};
    const int runs = argc > 1 ? 1 : RUNS, sizes = argc > 1 ? SIZES - 2 : SIZES;
    double per_body[SIZES];
    int good = 1;
    printf("tolerance  steps rejected factored   solved   heat [J]   missing   pressed in [m]   "
           "tip x, y, z [m]\n");
    for (int k = 0; k < runs; ++k) {
        const outcome run = swing(tolerance[k]);
        good = good && fabs(run.balance) < tolerance[k] && run.off < tolerance[k];
    }
    printf("\nsegments  factor [ms]   iterate [ms]      step [ms]\n");
    for (int k = 0; k < sizes; ++k) per_body[k] = grow(LONGEST >> (SIZES - 1 - k));
    printf("time per segment, %d to %d: %.2f\n", LONGEST >> (SIZES - sizes), LONGEST >> (SIZES - 1),
           per_body[sizes - 1] / per_body[0]);
    return good && per_body[sizes - 1] < 3.0 * per_body[0] ? 0 : 1;
}
