/* A ball thrown on a floor: Hunt and Crossley's contact, friction, and where the energy goes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * First it flies straight down without weight, at different speeds: with the law N = k x^n (1 + b
 * x') of the contact, m x'' = -N gives b m x' dx' / (1 + b x') = -b k x^n dx, so that the speed
 * after, v2, follows from the speed before, v1, whatever k and n are:
 *
 *   ln(1 + b v1) - b v1 = ln(1 - b v2) + b v2.
 *
 * Then it is thrown along the floor under its weight, without spin. It slides until it rolls; the
 * angular momentum about the line of contact stays, which leaves 5/7 of its speed. All the while
 * kinetic and potential energy and what mbsr_dissipation says has become heat make one sum. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

static const double radius = 0.05, density = 2000.0, damping = 0.4, g = 9.81; /* m, kg/m^3, s/m */

static mbsr_model *ball(double gravity)
{
    const mbsr_contact floor = {.radius = radius,
                                .normal = {0.0, 0.0, 1.0},
                                .stiffness = 2e6,
                                .exponent = 1.5,
                                .damping = damping,
                                .friction = 0.3,
                                .slip = 1e-3};
    mbsr_model *m = new_model();
    const int id = add_body(m, "ball", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                            mbsr_inertia_sphere(density, radius));
    add_force(m, mbsr_force_contact(id, MBSR_GROUND, &floor));
    add_force(m, mbsr_force_gravity(0.0, 0.0, -gravity));
    return m;
}

/* From speed v1 onto the floor; returns how far the speed after is from the closed form. */
static double bounce(double v1)
{
    const double q[7] = {1.0, 0, 0, 0, 0, 0, radius}, u[6] = {0, 0, 0, 0, 0, -v1};
    double least = 0.0, most = fmin(v1, 1.0 / damping);
    for (int k = 0; k < 60; ++k) { /* by halving */
        const double v2 = 0.5 * (least + most);
        const double sum = log1p(-damping * v2) + damping * v2;
        *(sum > log1p(damping * v1) - damping * v1 ? &least : &most) = v2;
    }
    mbsr_simulation r = run_start(ball(0.0), q, u, 1e-8);
    run_to(&r, 0.05);
    printf("%8.2f   %10.6f   %10.6f   %.4f\n", v1, r.u[5], least, r.u[5] / v1);
    const double error = fabs(r.u[5] - least);
    mbsr_simulation_end(&r);
    return error;
}

int main(void)
{
    double worst = 0.0, heat = 0.0, defect = 0.0;
    printf("v1 [m/s]   v2 [m/s]   closed form   restitution\n");
    for (double v1 = 0.25; v1 < 5.0; v1 *= 2.0) worst = fmax(worst, bounce(v1));

    const double q[7] = {1.0, 0, 0, 0, 0, 0, 2.0 * radius}, u[6] = {0, 0, 0, 2.0, 0, 0};
    enum { SAMPLES = 30000 };
    const double T = 1.5;
    mbsr_simulation r = run_start(ball(g), q, u, 1e-8);
    const double begin = run_energy(&r);
    double before = run_dissipation(&r);
    printf(
        "t [s]   height [m]   speed [m/s]   spin times radius   energy [J]   heat [J]   defect\n");
    for (int k = 1; k <= SAMPLES; ++k) {
        run_to(&r, T * k / SAMPLES);
        const double power = run_dissipation(&r);
        heat += 0.5 * T / SAMPLES * (before + power);
        before = power;
        const double missing = run_energy(&r) + heat - begin;
        defect = fmax(defect, fabs(missing));
        if (k % (SAMPLES / 10) == 0)
            printf("%5.2f   %10.6f   %11.6f   %17.6f   %10.6f   %8.6f   %+.1e\n", r.t,
                   r.q[6] - radius, r.u[3], r.u[1] * radius, run_energy(&r), heat, missing);
    }
    const double off = fabs(r.u[3] - 2.0 * 5.0 / 7.0);
    printf("rolls at %.6f m/s, 5/7 of 2 m/s is %.6f; %ld steps\n", r.u[3], 10.0 / 7.0,
           run_steps(&r));
    mbsr_simulation_end(&r);
    return worst < 1e-5 && defect < 1e-4 && off < 1e-4 ? 0 : 1;
}
