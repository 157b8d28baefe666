/* Single bodies: a pendulum, a heavy top, joints against ADAMS.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* A quarter of the period from rest in the horizontal is K(1/sqrt 2) sqrt(l/g). */
static void pendulum(sheet *out)
{
    static const double K = 1.85407467730137192, here[2] = {1.0, 0.0};
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, "rod", MBSR_GROUND, mbsr_joint_planar_revolute(origin, origin),
                             mbsr_inertia_planar(1.0, here, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    sheet_start(&s, 1e-10, NULL, NULL);
    sheet_run(&s, 41.0 * K / sqrt(9.81)); /* ten periods and a quarter */
    sheet_problem(
        out, "Simple pendulum",
        "Benchmark A01 of IFToMM, from rest in the horizontal; exact by the elliptic integral "
        "K(1/√2) = 1.854074677.");
    sheet_add(out, "angle after ten periods and a quarter, rad", -0.5 * pi, s.q[0], 1e-6);
    mbsr_simulation_end(&s);
}

static void heavy_top(sheet *out)
{
    static const double theirs[4] = {-0.70828, 0.43878, 0.54573, 0.0894}, com[3] = {0.0, 1.0, 0.0},
                        tensor[6] = {0.234375, 0.46875, 0.234375, 0.0, 0.0, 0.0},
                        q[4] = {1.0, 0.0, 0.0, 0.0}, u[3] = {0.0, 150.0, -4.61538};
    static const char *const name[4] = {"e₀", "e₁", "e₂", "e₃"};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, "top", MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                             mbsr_inertia_rigid(15.0, com, tensor));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    sheet_start(&s, 1e-10, q, u);
    sheet_run(&s, 0.2);
    sheet_problem(
        out, "Heavy top at 0.2 s",
        "Quaternion, from a Runge–Kutta solution noted with Exudyn's test heavyTop.py, five "
        "digits; data of Terze, Müller and Zlatar, Multibody Syst. Dyn. 38, 2016.");
    for (int k = 0; k < 4; ++k) sheet_add(out, name[k], theirs[k], s.q[k], 1e-4);
    mbsr_simulation_end(&s);
}

/* One body of 1 kg, its centre of mass 2 m from its joint, and where that has come after a time. */
typedef struct adams {
    const char *name;
    mbsr_joint joint;
    double com[3], tensor[6], q[7];
    int distance; /* 1: an end of it stays 2 m from the joint's place */
    double t, theirs[3], allowed[3];
} adams;

static void adams_case(sheet *out, const adams *c)
{
    static const char *const axis[3] = {"x, m", "y, m", "z, m"};
    static const double pivot[3] = {1.0, 2.0, 3.0}, end[3] = {2.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    double pose[MBSR_POSE_SIZE] = {0.0};
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND, c->joint,
                                              mbsr_inertia_rigid(1.0, c->com, c->tensor));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.80665));
    if (c->distance)
        mbsr_simulation_add_closure(&s, mbsr_closure_distance(body, end, MBSR_GROUND, pivot, 2.0));
    sheet_start(&s, 1e-10, c->q, NULL);
    sheet_run(&s, c->t);
    sheet_check(mbsr_body_pose(s.model, s.data, body, pose), &s.error);
    sheet_problem(out, c->name,
                  "Centre of mass, from rest; ADAMS's own run, six or seven digits, from the joint "
                  "tests of Project Chrono (data/testing/joints).");
    for (int k = 0; k < 3; ++k) {
        double x = pose[MBSR_POSE_X + k];
        for (int l = 0; l < 3; ++l) x += pose[MBSR_POSE_R + k + 3 * l] * c->com[l];
        sheet_add(out, axis[k], c->theirs[k], x, c->allowed[k]);
    }
    mbsr_simulation_end(&s);
}

void sheet_bodies(sheet *out)
{
    static const double tilted[3] = {0.0, 1.0, 1.0}, about[3] = {1.0, -1.0, 0.0},
                        x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    const mbsr_frame at = mbsr_frame_at(1.0, 2.0, 3.0), beside = mbsr_frame_at(-1.0, 4.0, 3.0),
                     turned = mbsr_frame_rotated(NULL, about, 0.5 * pi);
    const adams cases[] = {{.name = "Revolute joint, case 2, at 5 s",
                            .joint = mbsr_joint_revolute(&at, NULL, tilted),
                            .com = {2.0, 0.0, 0.0},
                            .tensor = {0.04, 0.1, 0.1},
                            .t = 5.0,
                            .theirs = {1.20996, 3.40640, 1.59360},
                            .allowed = {1e-5, 1e-5, 1e-5}},
                           {.name = "Spherical joint, case 2, at 5 s",
                            .joint = mbsr_joint_spherical(&at, NULL),
                            .com = {2.0, 0.0, 0.0},
                            .tensor = {0.04, 0.1, 0.1},
                            .q = {1.0},
                            .t = 5.0,
                            .theirs = {-0.999684, 2.0, 2.96444},
                            .allowed = {1e-5, 1e-5, 1e-5}},
                           {.name = "Distance constraint, case 2, at 5 s",
                            .joint = mbsr_joint_free(&beside, NULL),
                            .tensor = {0.04, 0.1, 0.1},
                            .q = {1.0},
                            .distance = 1,
                            .t = 5.0,
                            .theirs = {0.3652558, 2.664910, -0.7909707},
                            .allowed = {1e-4, 1e-4, 1e-4}},
                           {.name = "Cylindrical joint, case 3, at 2.5 s",
                            .joint = mbsr_joint_cylindrical(&at, NULL, tilted),
                            .com = {2.0, 0.0, 0.0},
                            .tensor = {0.04, 0.1, 0.1},
                            .t = 2.5,
                            .theirs = {-0.846888, -12.7802, -12.8656},
                            .allowed = {1e-5, 1e-4, 1e-4}},
                           {.name = "Universal joint, case 3, at 1 s",
                            .joint = mbsr_joint_universal(&turned, NULL, x, y),
                            .com = {0.0, 0.0, -2.0},
                            .tensor = {0.1, 0.1, 0.04},
                            .t = 1.0,
                            .theirs = {-0.636240, -0.614073, -1.79391},
                            .allowed = {1e-5, 1e-5, 1e-5}}};
    pendulum(out);
    heavy_top(out);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) adams_case(out, cases + k);
}
