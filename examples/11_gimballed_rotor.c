/* A rotor in two gimbal rings without mass, which the rotor gives their inertia.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   ground -- outer ring, turns about z by phi -- inner ring, about x by theta -- rotor, about its
 *   own axis by psi; moments of inertia A, A, C; a motor of torque tau between the rings
 *
 * The rotor goes round at constant theta with the rate of precession w when
 *
 *   tau = (C s - A w cos theta) w sin theta,   with the spin s = psi' + w cos theta,
 *
 * which has a slow and a fast solution. Started with either the motion must stay: after one second
 * phi = w and theta is what it was. At theta = 0 outer ring and rotor turn about the same line
 * (gimbal lock) and nothing with mass resists the rings' turning against the rotor: the library
 * says so. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

static const double A = 0.012, C = 0.02, s = 30.0, tau = 0.3; /* kg m^2, rad/s, N m */

static int motor(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = tau;
    return MBSR_OK;
}

static mbsr_model *gimbals(void)
{
    const double x[3] = {1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, origin[3] = {0.0};
    const double moments[6] = {A, A, C, 0.0, 0.0, 0.0};
    const mbsr_inertia none = mbsr_inertia_zero(), wheel = mbsr_inertia_rigid(5.0, origin, moments);
    mbsr_model *m = new_model();
    const int outer =
        add_body(m, "outer ring", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z), none);
    const int inner = add_body(m, "inner ring", outer, mbsr_joint_revolute(NULL, NULL, x), none);
    add_body(m, "rotor", inner, mbsr_joint_revolute(NULL, NULL, z), wheel);
    add_force(m, mbsr_force_joint_applied(inner, motor, NULL));
    return m;
}

/* Precession at constant theta, the fast one or the slow one; returns the error after a second. */
static double precession(double theta, int fast)
{
    const double c = cos(theta), root = sqrt(C * C * s * s - 4.0 * A * c * tau / sin(theta));
    const double w =
        fast ? (C * s + root) / (2.0 * A * c) : 2.0 * tau / sin(theta) / (C * s + root);
    const double q[3] = {0.0, theta, 0.0}, u[3] = {w, 0.0, s - w * c};
    mbsr_simulation r = run_start(gimbals(), q, u, 1e-9);
    run_to(&r, 1.0);
    const double error = fmax(fabs(r.q[0] - w), fabs(r.q[1] - theta));
    printf("%8.0f deg   %12.6f   %12.6f   %10.1e\n", theta * 180.0 / acos(-1.0), w, r.q[0],
           r.q[1] - theta);
    mbsr_simulation_end(&r);
    return error;
}

/* Released at rest with its axis level the rotor nods: with psi' + phi' cos theta = s, the angular
 * momentum about z and the energy constant it goes down by x, tan(x)^2 = 2 A tau x / (C s)^2.
 * Returns the error of that. */
static double nodding(void)
{
    const double level = 0.5 * acos(-1.0), q[3] = {0.0, level, 0.0}, u[3] = {0.0, 0.0, s};
    double x = 2.0 * A * tau / (C * C * s * s), lowest = level;
    for (int k = 0; k < 20; ++k) x = atan(sqrt(2.0 * A * tau * x) / (C * s));
    mbsr_simulation r = run_start(gimbals(), q, u, 1e-9);
    for (int k = 1; k <= 4000; ++k) {
        run_to(&r, 1e-4 * k);
        lowest = fmax(lowest, r.q[1]);
    }
    printf("released at rest it nods by %.9f rad; from momentum and energy %.9f\n", lowest - level,
           x);
    printf("directions without mass: %d; steps: %ld\n", r.start.null_directions, run_steps(&r));
    mbsr_simulation_end(&r);
    return fabs(lowest - level - x);
}

/* What the library says at theta = 0; returns its status. */
static int gimbal_lock(void)
{
    const double q[3] = {0.0, 0.0, 0.0}, u[3] = {0.0, 0.0, s};
    double udot[3];
    mbsr_model *m = gimbals();
    mbsr_data *d;
    mbsr_error error;
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);
    const int status = mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot);
    printf("theta = 0: %s, %s\n", mbsr_status_name(status), mbsr_data_error(d)->text);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return status;
}

int main(void)
{
    const double degree = acos(-1.0) / 180.0;
    double worst = 0.0;
    printf("inclination   precession w [rad/s]       phi(1 s)   theta drift\n");
    for (int fast = 0; fast < 2; ++fast) {
        for (int k = 1; k <= 5; ++k) {
            if (fast && k == 3) continue; /* at 90 degrees there is only the slow one */
            worst = fmax(worst, precession(30.0 * degree * k, fast));
        }
    }
    worst = fmax(worst, nodding());
    return gimbal_lock() == MBSR_UNDETERMINED && worst < 2e-8 ? 0 : 1;
}
