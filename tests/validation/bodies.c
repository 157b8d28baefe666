/* Single bodies: a pendulum, a heavy top.
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

void sheet_bodies(sheet *out)
{
    pendulum(out);
    heavy_top(out);
}
