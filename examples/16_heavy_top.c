/* The heavy symmetric top on a spherical joint: what is conserved, and the path of its tip.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Moments A, A, C about the point that it stands on, centre of mass l along its axis. Energy, the
 * angular momentum about the vertical and the one about the top's own axis stay constant. Released
 * with its axis at rest, the top sinks and rises between theta_0 and theta_1,
 *
 *   cos(theta_1) = a - sqrt(a^2 - 2 a cos(theta_0) + 1),   a = (C s)^2 / (4 A m g l),
 *
 * s being the spin. Pushed, the tip draws loops or waves instead. Orientation is a quaternion:
 * no position is singular. heavy_top.csv has the paths for heavy_top.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

static const double m = 1.0, g = 9.81, l = 0.1, A = 0.012, C = 0.002, s = 150.0, T = 3.0;
static const double start = 0.6; /* theta_0, rad */

static mbsr_model *top(void)
{
    const double centre[3] = {0.0, 0.0, l}, moments[6] = {A, A, C, 0.0, 0.0, 0.0};
    const mbsr_frame pivot = mbsr_frame_identity();
    mbsr_model *model = new_model();
    add_body(model, "top", MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
             mbsr_inertia_rigid_about(m, centre, &pivot, moments));
    add_force(model, mbsr_force_gravity(0.0, 0.0, -g));
    return model;
}

/* Energy, vertical and axial angular momentum, and the axis itself. */
typedef struct state {
    double energy, vertical, axial, axis[3];
} state;

static state look(mbsr_simulation *r)
{
    double pose[MBSR_POSE_SIZE], momentum[6];
    check(mbsr_body_pose(r->model, r->data, 0, pose), mbsr_data_error(r->data));
    check(mbsr_tree_momentum(r->model, r->data, NULL, NULL, NULL, momentum),
          mbsr_data_error(r->data));
    state x = {.energy = run_energy(r), .vertical = momentum[2]};
    for (int k = 0; k < 3; ++k) {
        x.axis[k] = pose[MBSR_POSE_R + 6 + k]; /* third column of R */
        x.axial += momentum[k] * x.axis[k];
    }
    return x;
}

/* Runs with the axis going round at `push` rad/s at first; *lowest is the least cos(theta).
 * Returns the largest relative change of what should stay. */
static double spin(double push, FILE *file, double *lowest)
{
    const double q[4] = {cos(0.5 * start), 0.0, sin(0.5 * start), 0.0}; /* leans towards x */
    const double u[3] = {s * sin(start) - push * cos(start) * sin(start), 0.0,
                         s * cos(start) + push * sin(start) * sin(start)};
    mbsr_simulation r = run_start(top(), q, u, 1e-9);
    const state begin = look(&r);
    double change = 0.0;
    *lowest = 1.0;
    for (int k = 1; k <= 6000; ++k) {
        run_to(&r, T * k / 6000);
        const state x = look(&r);
        change = fmax(change, fabs(x.energy / begin.energy - 1.0));
        change = fmax(change, fabs(x.vertical / begin.vertical - 1.0));
        change = fmax(change, fabs(x.axial / begin.axial - 1.0));
        *lowest = fmin(*lowest, x.axis[2]);
        if (k % 5 == 0) fprintf(file, "%g,%g,%g,%g\n", r.t, x.axis[0], x.axis[1], x.axis[2]);
    }
    fprintf(file, "\n\n");
    printf("%12.2f   %.8f   %.1e   %5ld\n", push, *lowest, change, run_steps(&r));
    mbsr_simulation_end(&r);
    return change;
}

int main(void)
{
    const double a = C * C * s * s / (4.0 * A * m * g * l), c = cos(start);
    const double expected = a - sqrt(a * a - 2.0 * a * c + 1.0);
    double worst = 0.0, lowest[3];
    FILE *file = csv("heavy_top.csv");
    printf("push [rad/s]   lowest cos   change    steps\n");
    for (int k = 0; k < 3; ++k)
        worst = fmax(worst, spin(k == 0 ? 0.0 : k == 1 ? -2.0 : 2.0, file, &lowest[k]));
    printf("released at rest, closed form: %.8f\n", expected);
    fclose(file);
    return worst < 1e-6 && fabs(lowest[0] - expected) < 1e-6 ? 0 : 1;
}
