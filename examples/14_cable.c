/* A cable of 100 massless segments with point masses at their ends hangs between two supports and
 * is let go at one.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each segment hangs on the one before by a universal joint, its body's origin and its particle at
 * the far end; segments have no moments of inertia. Hanging shape: with the horizontal force H and
 * the weight w of a particle the slope of segment i is tan(a_i) = w (i - 49.5) / H, by symmetry,
 * and H is such that the cable spans the supports. The library must find the joints at rest in this
 * shape while the last particle is held with that force. Then it is let go and pushed sideways.
 * Energy and the angular momentum about the vertical stay constant: joints between segments without
 * inertia pass on no torque. No direction lacks mass and nothing is stiff, so an explicit method
 * with 0.5 ms steps does it, each in O(N). cable.csv has shapes for cable.gp. */
#include <mbsrank/mbsrank.h>

#include "build.h"
#include "progress.h"
#include "rk4.h"

#include <math.h>

enum { N = 100, STEPS = 2000, SHAPES = 10 };
static const double length = 2.0, span = 1.6, mass = 0.2, g = 9.81, T = 1.0; /* m, kg, s */

typedef struct hold {
    double x, z; /* N */
} hold;

/* On the last particle: moment about it and force. */
static int hold_end(void *user, double t, int n, double *f)
{
    const hold *h = user;
    (void)t, (void)n;
    f[3] = h->x;
    f[5] = h->z;
    return MBSR_OK;
}

static mbsr_model *cable(hold *end)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    const mbsr_frame top = mbsr_frame_at(0.0, 0.0, length / N);
    mbsr_model *m = new_model();
    int last = MBSR_GROUND;
    for (int i = 0; i < N; ++i)
        last = add_body(m, NULL, last, mbsr_joint_universal(NULL, &top, y, x),
                        mbsr_inertia_particle(mass / N));
    add_force(m, mbsr_force_gravity(0.0, 0.0, -g));
    if (end) add_force(m, mbsr_force_applied(last, hold_end, end));
    return m;
}

/* Slope of segment i for w / H = s. */
static double slope(double s, int i)
{
    return atan(s * (i - 0.5 * (N - 1)));
}

/* w / H of the hanging cable, by halving. */
static double hanging(void)
{
    double least = 0.0, most = 1.0;
    for (int k = 0; k < 60; ++k) {
        const double s = 0.5 * (least + most);
        double wide = 0.0;
        for (int i = 0; i < N; ++i) wide += length / N * cos(slope(s, i));
        *(wide > span ? &least : &most) = s;
    }
    return least;
}

/* Angular momentum about the vertical after the push, by hand: a particle at r, all in one plane,
 * moves sideways by rate (r . e), e being the direction of the first segment. */
static double pushed(double s, double rate)
{
    const double e[2] = {cos(slope(s, 0)), sin(slope(s, 0))};
    double x = 0.0, z = 0.0, sum = 0.0;
    for (int i = 0; i < N; ++i) {
        x += length / N * cos(slope(s, i));
        z += length / N * sin(slope(s, i));
        sum += mass / N * x * rate * (x * e[0] + z * e[1]);
    }
    return sum;
}

/* Largest acceleration of a joint, in rad/s^2, while the end is held. */
static double unrest(const double *q, hold end)
{
    const double u[2 * N] = {0.0};
    double udot[2 * N], worst = 0.0;
    mbsr_model *m = cable(&end);
    mbsr_data *d;
    mbsr_error error;
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);
    check(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot), mbsr_data_error(d));
    for (int i = 0; i < 2 * N; ++i) worst = fmax(worst, fabs(udot[i]));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return worst;
}

typedef struct problem {
    mbsr_ode *ode;
    mbsr_data *d;
} problem;

/* x = (q, p) */
static void slopes(void *user, double t, const double *x, double *xdot)
{
    const problem *p = user;
    check(mbsr_ode_rhs(p->ode, t, x, xdot), mbsr_data_error(p->d));
}

/* Energy and angular momentum about the vertical, J and J s; the points of the cable go into the
 * file, the last one to *tip. */
static void look(mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                 FILE *file, double kept[2], double tip[3])
{
    double p[MBSR_POSE_SIZE], kinetic, potential, momentum[6];
    check(mbsr_stage_positions(m, d, t, q), mbsr_data_error(d));
    check(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    check(mbsr_energy(m, d, &kinetic, &potential), mbsr_data_error(d));
    check(mbsr_tree_momentum(m, d, NULL, NULL, NULL, momentum), mbsr_data_error(d));
    kept[0] = kinetic + potential;
    kept[1] = momentum[2];
    fprintf(file, "0,0,0\n");
    for (int i = 0; i < N; ++i) {
        check(mbsr_body_pose(m, d, i, p), mbsr_data_error(d));
        for (int k = 0; k < 3; ++k) tip[k] = p[MBSR_POSE_X + k];
        fprintf(file, "%g,%g,%g\n", tip[0], tip[1], tip[2]);
    }
    fprintf(file, "\n\n");
}

/* Lets the end go; returns the largest change of energy and of angular momentum, which starts at
 * Lz. */
static double fall(mbsr_model *m, const double *q, const double *u, double Lz, FILE *file)
{
    double x[4 * N], rates[2 * N] = {0.0}, tip[3], begin[2], now[2], worst = 0.0;
    mbsr_data *d;
    mbsr_ode *ode;
    mbsr_error error;
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);
    check(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    check(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
    look(m, d, 0.0, q, u, file, begin, tip);
    begin[1] = Lz;
    printf("t [s]   tip x, y, z [m]                energy   momentum\n");
    for (int k = 1; k <= STEPS; ++k) {
        const double h = T / STEPS, t = k * h;
        rk4_step(slopes, &(problem){ode, d}, 4 * N, t - h, h, x);
        show_progress(t / T);
        if (k % (STEPS / SHAPES)) continue;
        check(mbsr_ode_velocities(ode, t, x, rates), mbsr_data_error(d));
        look(m, d, t, x, rates, file, now, tip);
        for (int i = 0; i < 2; ++i) worst = fmax(worst, fabs(now[i] -= begin[i]));
        printf("%5.2f   %+8.4f %+8.4f %+8.4f   %+.1e   %+.1e\n", t, tip[0], tip[1], tip[2], now[0],
               now[1]);
    }
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return worst;
}

int main(void)
{
    const double s = hanging(), w = mass / N * g, level = 0.5 * acos(-1.0);
    double q[2 * N] = {0.0}, u[2 * N] = {0.0};
    /* segments point along -z at zero; turned about y by -90 degrees, along x */
    for (int i = 0; i < N; ++i) q[2 * i] = -slope(s, i) + (i ? slope(s, i - 1) : -level);
    u[1] = 1.0; /* rad/s */
    const double held = unrest(q, (hold){.x = w / s, .z = 0.5 * (N + 1) * w});
    const double loose = unrest(q, (hold){0.0, 0.0});
    printf("largest acceleration, held: %.1e rad/s^2, let go: %.1e rad/s^2\n", held, loose);
    FILE *file = csv("cable.csv");
    const double change = fall(cable(NULL), q, u, pushed(s, u[1]), file);
    fclose(file);
    return held < 1e-6 && loose > 1.0 && change < 1e-6 ? 0 : 1;
}
