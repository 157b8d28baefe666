/* Two shafts through a massless cross, and the same with a universal joint.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   ground - shaft 1, driven by phi_1 = w t - cross, about x - shaft 2, about y - bearing, about z
 *
 * Shaft 2, with a flywheel, runs at an angle b to shaft 1. The tree ends at its bearing, a bush
 * without mass that a bushing holds to the ground, so the shaft's axis is held elastically. Were it
 * rigid, the angles would obey tan(phi_2) = tan(phi_1) cos(b): the deviation must fall as 1 /
 * stiffness. A cross between two revolute joints and one universal joint must give one motion. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

static const double b = 0.5, w = 10.0, distance = 0.4, T = 1.0; /* rad, rad/s, m, s */
enum { SAMPLES = 100 };

static int turn(void *user, double t, double *phi, double *rate, double *acceleration)
{
    (void)user;
    *phi = w * t;
    *rate = w;
    *acceleration = 0.0;
    return MBSR_OK;
}

static mbsr_model *shafts(int with_cross, double stiffness)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const double c[6] = {10.0, 10.0, 10.0, stiffness, stiffness, stiffness};
    const double damping[6] = {0.1, 0.1, 0.1, 3e-4 * stiffness, 3e-4 * stiffness, 3e-4 * stiffness};
    const double origin[3] = {0.0}, moments[6] = {0.03, 0.03, 0.05, 0.0, 0.0, 0.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_inertia none = mbsr_inertia_zero(),
                       flywheel = mbsr_inertia_rigid(4.0, origin, moments);
    const mbsr_frame on_shaft = mbsr_frame_at(0.0, 0.0, distance);
    const mbsr_frame tilted = mbsr_frame_rotated(NULL, x, b),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    mbsr_model *m = new_model();
    int shaft = add_body(m, "shaft 1", MBSR_GROUND,
                         mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL), none);
    if (with_cross) {
        const int cross = add_body(m, "cross", shaft, mbsr_joint_revolute(NULL, NULL, x), none);
        shaft = add_body(m, "shaft 2", cross, mbsr_joint_revolute(NULL, NULL, y), flywheel);
    } else {
        shaft = add_body(m, "shaft 2", shaft, mbsr_joint_universal(NULL, NULL, x, y), flywheel);
    }
    const int bush = add_body(m, "bearing", shaft, mbsr_joint_revolute(&on_shaft, NULL, z), none);
    add_force(m, mbsr_force_bushing(MBSR_GROUND, &on_ground, bush, NULL, c, damping));
    return m;
}

/* Writes phi_2 over a second; returns its largest deviation from the rigid law. */
static double drive(int with_cross, double stiffness, double *phi)
{
    const double q[3] = {b, 0.0, 0.0}, u[3] = {0.0, -w * sin(b), -w * cos(b)};
    mbsr_simulation r = run_start(shafts(with_cross, stiffness), q, u, 1e-8);
    double worst = 0.0;
    for (int k = 0; k < SAMPLES; ++k) {
        run_to(&r, T * (k + 1) / SAMPLES);
        phi[k] = -r.q[2]; /* of shaft 2 in its bearing */
        const double S = sin(w * r.t), C = cos(w * r.t);
        const double law = w * r.t - atan2(S * C * (1.0 - cos(b)), C * C + cos(b) * S * S);
        worst = fmax(worst, fabs(phi[k] - law));
    }
    printf("%15s   %10.0e   %8d   %6ld   %.3e", with_cross ? "cross" : "universal joint", stiffness,
           r.start.null_directions, run_steps(&r), worst);
    mbsr_simulation_end(&r);
    return worst;
}

int main(void)
{
    double before = 0.0, ratio = 100.0, differ = 0.0;
    printf("model             stiffness   massless    steps   off the rigid law [rad]\n");
    for (double stiffness = 1e4; stiffness < 2e6; stiffness *= 10.0) {
        double phi[2][SAMPLES];
        drive(0, stiffness, phi[0]);
        printf("\n");
        const double off = drive(1, stiffness, phi[1]);
        for (int k = 0; k < SAMPLES; ++k) differ = fmax(differ, fabs(phi[0][k] - phi[1][k]));
        if (before > 0.0) {
            printf(", %.1f times less", before / off);
            ratio = fmin(ratio, before / off);
        }
        printf("\n");
        before = off;
    }
    printf("the two models differ by %.1e rad\n", differ);
    return differ < 1e-7 && ratio > 8.0 && before < 1e-4 ? 0 : 1;
}
