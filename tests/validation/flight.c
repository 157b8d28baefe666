/* Free bodies above a turning Earth: NASA's check cases of flight simulation.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

static const double foot = 0.3048, slug = 14.59390294, equator = 6378137.0,
                    degree = 3.14159265358979323846 / 180.0;

/* WGS 84 with its second harmonic, in the plane of the equator: N for 1 slug at r. */
static int gravitation(void *user, double r, double v, double *force, double *energy, double *power)
{
    const double mu = 3.986004418e14, j2 = 1.08262982e-3, mass = *(const double *)user,
                 s = equator / r;
    (void)v;
    (void)power;
    *force = mass * mu / (r * r) * (1.0 + 1.5 * j2 * s * s);
    if (energy) *energy = -mass * mu / r * (1.0 + 0.5 * j2 * s * s);
    return MBSR_OK;
}

/* Axes of the body along north, east and down where it is, as the Euler angles count from. */
static mbsr_frame north_east_down(double x, double y)
{
    const double r = hypot(x, y), c = x / r, s = y / r;
    return (mbsr_frame){{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0, -s, c, 0.0, -c, -s, 0.0}};
}

/* 30 000 ft above the equator, at rest beside the air; turning at `rate` along its axes, rad/s. */
static void drop(double mass, const double tensor[6], const double rate[3], double t,
                 double pose[MBSR_POSE_SIZE], double turning[3])
{
    const double r = equator + 30000.0 * foot, earth = 7.292115e-5, com[3] = {0.0, 0.0, 0.0},
                 q[7] = {1.0, 0.0, 0.0, 0.0, r, 0.0, 0.0};
    const mbsr_spring law = {.function = gravitation, .user = &mass};
    const mbsr_frame start = north_east_down(r, 0.0), axes = mbsr_frame_inverse(&start);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND, mbsr_joint_free(NULL, &axes),
                                              mbsr_inertia_rigid(mass, com, tensor));
    mbsr_simulation_add_force(&s, mbsr_force_spring(MBSR_GROUND, NULL, body, NULL, &law));
    double u[6] = {0.0, 0.0, 0.0, 0.0, earth * r, 0.0};
    for (int k = 0; k < 9; ++k) u[k % 3] += start.R[k] * rate[k / 3];
    sheet_start(&s, 1e-12, q, u);
    sheet_run(&s, t);
    sheet_check(mbsr_body_pose(s.model, s.data, body, pose), &s.error);
    for (int k = 0; k < 3; ++k) {
        const double *axis = pose + MBSR_POSE_R + 3 * k;
        turning[k] = axis[0] * s.u[0] + axis[1] * s.u[1] + axis[2] * s.u[2];
    }
    mbsr_simulation_end(&s);
}

static double altitude(const double *pose)
{
    return (hypot(pose[MBSR_POSE_X], pose[MBSR_POSE_X + 1]) - equator) / foot;
}

static void sphere(sheet *out)
{
    const double i = 3.6 * slug * foot * foot, tensor[6] = {i, i, i, 0.0, 0.0, 0.0},
                 rate[3] = {0.0, 0.0, 0.0};
    double pose[MBSR_POSE_SIZE] = {0.0}, turning[3];
    drop(slug, tensor, rate, 30.0, pose, turning);
    sheet_problem(out, "Sphere without drag at 30 s",
                  "NASA/TM-2015-218675, NESC atmospheric check case 1, simulation 4.");
    sheet_add(out, "altitude, ft", 15598.9043522, altitude(pose), 1e-3);
    sheet_add(out, "inertial y, ft", 45832.753467, pose[MBSR_POSE_X + 1] / foot, 1e-3);
}

static void brick(sheet *out)
{
    static const double theirs[3] = {-2.41890222177, -23.5525695195, 28.12859263},
                        angles[3] = {-4.32133636889, 3.74133747365, -66.0190032425},
                        rate[3] = {10.0 * degree, 20.0 * degree, 30.0 * degree};
    static const char *const name[3] = {"roll rate, °/s", "pitch rate, °/s", "yaw rate, °/s"};
    const double unit = slug * foot * foot,
                 tensor[6] = {0.001894220 * unit, 0.006211019 * unit, 0.007194665 * unit, 0, 0, 0};
    double pose[MBSR_POSE_SIZE] = {0.0}, turning[3], R[9] = {0.0};
    drop(0.155404754 * slug, tensor, rate, 10.0, pose, turning);
    const mbsr_frame local = north_east_down(pose[MBSR_POSE_X], pose[MBSR_POSE_X + 1]);
    for (int k = 0; k < 27; ++k)
        R[k / 9 + 3 * (k / 3 % 3)] +=
            local.R[3 * (k / 9) + k % 3] * pose[MBSR_POSE_R + 3 * (k / 3 % 3) + k % 3];
    sheet_problem(out, "Tumbling brick without drag at 10 s",
                  "NASA/TM-2015-218675, NESC atmospheric check case 2, simulation 4. Rates are "
                  "inertial, along the body's axes; angles against north, east and down.");
    for (int k = 0; k < 3; ++k) sheet_add(out, name[k], theirs[k], turning[k] / degree, 1e-6);
    sheet_add(out, "yaw, °", angles[0], atan2(R[1], R[0]) / degree, 1e-5);
    sheet_add(out, "pitch, °", angles[1], -asin(R[2]) / degree, 1e-5);
    sheet_add(out, "roll, °", angles[2], atan2(R[5], R[8]) / degree, 1e-5);
    sheet_add(out, "altitude, ft", 28400.2040727, altitude(pose), 1e-3);
}

void sheet_flight(sheet *out)
{
    sphere(out);
    brick(out);
}
