/* A quarter of a car drives over a bump: wheel carrier and spring seat have no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   road(t) -- tyre -- carrier -- coil spring, damper -- spring seat -- rubber mount -- body
 *
 * Four bodies in a row, each sliding upwards on the one before. Their coordinates, the deflections
 * of the three springs, count from static equilibrium, so weight does not appear. Carrier and seat
 * next to each other without mass: two equations of first order. The table shows what invented
 * masses cost in steps, however small they are. Reference: the massless equations by hand, in
 * absolute coordinates, by a Runge-Kutta method with small steps. */
#include <mbsrank/simulation.h>

#include "rk4.h"
#include "run.h"

#include <math.h>

/* kg; N/m and N s/m of tyre, coil and damper, mount; s */
static const double M = 400.0, k[3] = {2e5, 2e4, 1e6}, d[3] = {50.0, 1500.0, 50.0}, T = 2.0;
enum { POINTS = 200, SUBSTEPS = 500 };

/* 5 cm high, from 0.2 s to 0.4 s: h = 0.05 sin^4 w (t - 0.2) */
static int road(void *user, double t, double *h, double *v, double *a)
{
    const double w = acos(-1.0) / 0.2, S = sin(w * (t - 0.2)), C = cos(w * (t - 0.2));
    (void)user;
    if (t < 0.2 || t > 0.4) return MBSR_OK; /* outputs arrive as zero */
    *h = 0.05 * pow(S, 4.0);
    *v = 0.05 * w * 4.0 * pow(S, 3.0) * C;
    *a = 0.05 * w * w * (12.0 * S * S * C * C - 4.0 * pow(S, 4.0));
    return MBSR_OK;
}

static mbsr_model *quarter_car(double small)
{
    const double up[3] = {0.0, 0.0, 1.0};
    const mbsr_axis rise = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_joint slide = mbsr_joint_prismatic(NULL, NULL, up);
    const char *name[3] = {"carrier", "seat", "body"};
    mbsr_model *m = new_model();
    int body = add_body(m, "road", MBSR_GROUND,
                        mbsr_joint_compound(NULL, NULL, 1, &rise, road, NULL), mbsr_inertia_zero());
    for (int i = 0; i < 3; ++i) {
        body = add_body(m, name[i], body, slide, mbsr_inertia_particle(i < 2 ? small : M));
        add_force(m, mbsr_force_joint_spring(body, 0, k[i], d[i], 0.0));
    }
    return m;
}

/* x = (carrier, seat, body, speed of the body): the forces on carrier and seat balance. */
static void by_hand(void *user, double t, const double *x, double *xdot)
{
    double h = 0.0, hdot = 0.0, hddot = 0.0;
    (void)user;
    road(NULL, t, &h, &hdot, &hddot);
    const double coil = k[1] * (x[1] - x[0]), mount = k[2] * (x[2] - x[1]);
    const double f0 = coil - k[0] * (x[0] - h) + d[0] * hdot, f1 = mount - coil + d[2] * x[3];
    const double a = d[0] + d[1], b = d[1] + d[2], det = a * b - d[1] * d[1];
    xdot[0] = (b * f0 + d[1] * f1) / det;
    xdot[1] = (d[1] * f0 + a * f1) / det;
    xdot[2] = x[3];
    xdot[3] = -(mount + d[2] * (x[3] - xdot[1])) / M;
}

/* Runs with carrier and seat of mass `small`, kg; returns the steps, *error of the body's place,
 * and *rough of its acceleration. */
static long drive(double small, double *error, double *rough)
{
    const double zero[3] = {0.0};
    double x[4] = {0.0};
    mbsr_simulation r = run_start(quarter_car(small), zero, zero, 1e-6);
    FILE *file = small == 0.0 ? csv("quarter_car.csv") : NULL;
    *error = *rough = 0.0;
    for (int i = 0; i < POINTS; ++i) {
        const double h = T / POINTS / SUBSTEPS, t0 = T * i / POINTS;
        double height[4][MBSR_POSE_SIZE];
        for (int s = 0; s < SUBSTEPS; ++s) rk4_step(by_hand, NULL, 4, t0 + s * h, h, x);
        /* here the bump begins, and here it ends: a step across would see little of it */
        const int edge = i * T == 0.2 * POINTS || i * T == 0.4 * POINTS;
        if (edge) check(mbsr_ida_jump(r.ida), mbsr_ida_error(r.ida));
        run_to(&r, T * (i + 1) / POINTS);
        for (int b = 0; b < 4; ++b)
            check(mbsr_body_pose(r.model, r.data, b, height[b]), mbsr_data_error(r.data));
        *error = fmax(*error, fabs(height[3][MBSR_POSE_X + 2] - x[2]));
        /* what a passenger feels: accelerations are as good as the run */
        double felt[3], xdot[4];
        by_hand(NULL, r.t, x, xdot);
        check(mbsr_body_point(r.model, r.data, 3, NULL, NULL, NULL, felt), mbsr_data_error(r.data));
        *rough = fmax(*rough, fabs(felt[2] - xdot[3]));
        if (file) {
            fprintf(file, "%g", r.t);
            for (int b = 0; b < 4; ++b) fprintf(file, ",%g", height[b][MBSR_POSE_X + 2]);
            fputc('\n', file);
        }
    }
    const long steps = run_steps(&r);
    if (file) fclose(file);
    mbsr_simulation_end(&r);
    return steps;
}

int main(void)
{
    double error, worst, rough, other;
    const long without = drive(0.0, &worst, &rough);
    long least = 1000000;
    FILE *file = csv("quarter_car_steps.csv");
    printf("carrier, seat [kg]   steps   body differs from the reference by [m]\n");
    printf("%18g %7ld   %.1e\n", 0.0, without, worst);
    printf("without mass its acceleration differs by %.1e m/s^2\n", rough);
    fprintf(file, "0,%ld\n", without);
    for (double small = 4.0; small > 3e-4; small *= 0.1) { /* 1e-2 .. 1e-6 of the body's mass */
        const long steps = drive(small, &error, &other);
        printf("%18g %7ld   %.1e\n", small, steps, error);
        fprintf(file, "%g,%ld\n", small, steps);
        if (steps < least) least = steps;
    }
    fclose(file);
    return worst < 2e-5 && rough < 1e-2 && error < 1e-6 && least > without ? 0 : 1;
}
