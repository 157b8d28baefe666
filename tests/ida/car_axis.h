/* The car axis of the Test Set for IVP Solvers: the model.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A ground line turns by psi(t), sin psi = r sin(omega t) / L. The left wheel slides at the
 * distance s from the origin along the normal of that line, the right wheel is at the distance L
 * from the left one, in the direction phi. Springs of stiffness 1 hold the wheels above (0, 0) and
 * above the other end of the line. Wheels of mass eps^2 M / 2. */
#ifndef TEST_CAR_AXIS_H
#define TEST_CAR_AXIS_H

#include "reference_runs.h"

static const double L = 1.0, L0 = 0.5, R = 0.1, OMEGA = 10.0, M = 10.0;

static inline int ground_angle(void *unused, double t, double *psi, double *rate,
                               double *acceleration)
{
    (void)unused;
    const double x = R * sin(OMEGA * t) / L, v = OMEGA * R * cos(OMEGA * t) / L,
                 root = sqrt(1.0 - x * x);
    *psi = asin(x);
    *rate = v / root;
    *acceleration = -OMEGA * OMEGA * x / root + x * v * v / (root * root * root);
    return MBSR_OK;
}

/* In the plane or in space; the angle of the bar is phi - psi where the left wheel turns with the
 * ground line (relative), phi where it does not. q = s and that angle. */
typedef struct telling {
    int space, relative;
} telling;

enum { TELLINGS = 4 };
static const telling tellings[TELLINGS] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};

/* psi and -psi, for wheels that slide along a normal that turns and do not turn themselves. */
static inline int there_and_back(void *unused, double t, double *psi, double *rate,
                                 double *acceleration)
{
    ground_angle(unused, t, psi, rate, acceleration);
    psi[1] = -psi[0], rate[1] = -rate[0], acceleration[1] = -acceleration[0];
    return MBSR_OK;
}

/* The ground line, the left wheel, the bar with the right wheel. */
static inline void joints(const telling *how, mbsr_joint joint[3])
{
    const mbsr_planar_frame normal = {0.0, 0.0, acos(0.0)};
    joint[0] = mbsr_joint_planar(run_origin, run_origin, 0, MBSR_ANGLE, ground_angle, NULL);
    joint[1] = how->relative ? mbsr_joint_planar_prismatic(normal, normal)
                             : mbsr_joint_point(normal, MBSR_X, 0, NULL, NULL);
    joint[2] = mbsr_joint_planar_revolute(run_origin, run_origin);
    if (!how->space) return;
    const double e_y[3] = {0.0, 1.0, 0.0}, e_z[3] = {0.0, 0.0, 1.0};
    const mbsr_axis turn = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1},
                    axes[] = {
                        turn, {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 1.0, 0.0}}, turn};
    joint[0] = mbsr_joint_compound(NULL, NULL, 1, &turn, ground_angle, NULL);
    joint[1] = how->relative ? mbsr_joint_prismatic(NULL, NULL, e_y)
                             : mbsr_joint_compound(NULL, NULL, 3, axes, there_and_back, NULL);
    joint[2] = mbsr_joint_revolute(NULL, NULL, e_z);
}

static inline mbsr_model *car_axis(double eps, const telling *how)
{
    mbsr_model *m = run_model();
    const double mass = eps * eps * M / 2.0, origin[3] = {0.0, 0.0, 0.0}, end[3] = {L, 0.0, 0.0};
    mbsr_joint joint[3];
    joints(how, joint);
    const int line = run_body(m, "ground line", MBSR_GROUND, joint[0], mbsr_inertia_zero());
    /* in space the wheel that does not turn stands on the ground */
    const int left = run_body(m, "left wheel", how->space && !how->relative ? MBSR_GROUND : line,
                              joint[1], mbsr_inertia_particle(mass));
    const int bar = run_body(m, "bar", left, joint[2],
                             how->space ? mbsr_inertia_point_mass(mass, end)
                                        : mbsr_inertia_planar(mass, end, 0.0));
    run_force(m, mbsr_force_point_spring(left, origin, MBSR_GROUND, origin, 1.0, 0.0, L0));
    run_force(m, mbsr_force_point_spring(bar, end, line, end, 1.0, 0.0, L0));
    run_force(m, mbsr_force_gravity(0.0, -1.0, 0.0));
    return run_finish(m);
}

#endif
