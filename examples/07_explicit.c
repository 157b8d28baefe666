/* A real-time loop: explicit fixed steps on the reduced ODE (q, p), no implicit solver outside.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A pendulum hangs on a bead without mass, held by springs and dampers. The library finds the
 * velocity of the bead from the forces in every evaluation, so that q' and p' are explicit: here in
 * the classical Runge-Kutta method of order 4. The error falls by 16 when the step is halved. */
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 6 }; /* q: x, y of the bead, angle; p: their momenta */

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static mbsr_model *pendulum_on_bead(void)
{
    mbsr_model *m;
    check(mbsr_model_create(NULL, &m, NULL), mbsr_model_error(NULL));
    mbsr_body_def body = mbsr_default_body_def(); /* the bead: no mass */
    body.joint = mbsr_joint_point_free();
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.parent = 0; /* a particle of 1 kg, 1 m from its pivot */
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0}, (mbsr_planar_frame){0, 1, 0});
    body.inertia = mbsr_inertia_particle(1.0);
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def forces[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 100.0, 5.0, 0.0),
                                     mbsr_force_axis_spring(0, MBSR_GROUND, 1, 100.0, 5.0, 0.0),
                                     mbsr_force_gravity(0.0, -9.81, 0.0)};
    for (int k = 0; k < 3; ++k) {
        check(mbsr_model_add_force(m, &forces[k], NULL), mbsr_model_error(m));
    }
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void step(mbsr_ode *ode, const mbsr_data *d, double t, double h, double *x)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double slope[SIZE] = {0.0}, sum[SIZE] = {0.0}, y[SIZE];
    for (int stage = 0; stage < 4; ++stage) {
        for (int k = 0; k < SIZE; ++k) y[k] = x[k] + at[stage] * h * slope[k];
        check(mbsr_ode_rhs(ode, t + at[stage] * h, y, slope), mbsr_data_error(d));
        for (int k = 0; k < SIZE; ++k) sum[k] += weight[stage] * slope[k];
    }
    for (int k = 0; k < SIZE; ++k) x[k] += h / 6.0 * sum[k];
}

int main(void)
{
    mbsr_model *m = pendulum_on_bead();
    mbsr_data *d;
    mbsr_ode *ode;
    check(mbsr_data_create(m, &d, NULL), mbsr_data_error(NULL));
    const double q[3] = {0.0, 0.0, 2.0}, u[3] = {0.0, 0.0, 6.0};
    check(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
    double error = 0.0;
    for (int steps = 1000; steps <= 4000; steps *= 2) {
        double x[SIZE];
        check(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
        for (int k = 0; k < steps; ++k) step(ode, d, 10.0 * k / steps, 10.0 / steps, x);
        const double before = error;
        error = fabs(x[2] - 7.0972129298); /* published value of the angle at t = 10 */
        printf("%4d steps: angle %.9f, error %.1e", steps, x[2], error);
        if (steps > 1000) printf(" (%.1f times smaller)", before / error);
        printf("\n");
    }
    mbsr_ode_destroy(ode);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return error < 1e-6 ? 0 : 1;
}
