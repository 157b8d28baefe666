/* A force element and a joint of one's own, with derivatives, and the tests that find their errors.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A bead on a parabolic wire y = a x^2 / 2 in air: the wire is the joint, with q = x, air drag
 * -k |v| v the force element. Their tables have all that the library can ask for: rates of the
 * joint's matrices and derivatives for the Newton solver, dissipation of the drag.
 *
 * mbsr_joint_verify and mbsr_force_verify hold such functions against differences: a right one
 * leaves about 1e-9. Here each is also shown one with a mistake, a sign in kII and a derivative
 * that was forgotten, and says where it is. Then the bead is let go; reference: the equation by
 * hand,
 *
 *   (1 + (a x)^2) (x'' + k / m |v| x') = -a x (g + a x'^2),   |v| = |x'| sqrt(1 + (a x)^2). */
#include <mbsrank/verify.h>
#include <mbsrank/simulation.h>

#include "rk4.h"

#include <math.h>
#include <stdio.h>

static const double a = 2.0, k = 0.3, mass = 0.2, g = 9.81; /* 1/m, N s^2/m^2, kg, m/s^2 */

/* ---- the joint ---- */

static int position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0];
    p[1] = 0.5 * a * args->q[0] * args->q[0];
    return MBSR_OK;
}

/* 0 = V + J u: what is not written is zero. K is the unit matrix, as the table says. */
static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K, (void)H, (void)kI;
    J[0] = -1.0;
    J[1] = -a * args->q[0];
    return MBSR_OK;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    kII[1] = -a * args->u[0] * args->u[0];
    return MBSR_OK;
}

static int wrong_bias(const mbsr_joint_args *args, double *kII)
{
    kII[1] = a * args->u[0] * args->u[0];
    return MBSR_OK;
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)Kdot, (void)Hdot;
    Jdot[1] = -a * args->u[0];
    return MBSR_OK;
}

/* Changes of position and jacobians along changes of q. */
static int tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp, double *dK,
                   double *dH, double *dJ, double *dkI)
{
    (void)dK, (void)dH, (void)dkI;
    dp[0] = by->q[0];
    dp[1] = a * args->q[0] * by->q[0];
    dJ[1] = -a * by->q[0];
    return MBSR_OK;
}

/* Changes of bias and rates. */
static int rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                        double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    (void)dKdot, (void)dHdot, (void)dqdot;
    dkII[1] = -2.0 * a * args->u[0] * by->u[0];
    dJdot[1] = -a * by->u[0];
    return MBSR_OK;
}

static const mbsr_joint_table wire = {.version = MBSR_JOINT_TABLE_VERSION,
                                      .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
                                      .name = "wire",
                                      .position = position,
                                      .jacobians = jacobians,
                                      .bias = bias,
                                      .rates = rates,
                                      .tangent = tangent,
                                      .rate_tangent = rate_tangent};

/* The body it carries is a point in the plane, so that weight, springs and the like know it. */
static mbsr_joint joint(const mbsr_joint_table *table)
{
    mbsr_joint of = mbsr_joint_custom(table, 2, 1, NULL);
    of.space = MBSR_SPACE_POINT;
    return of;
}

/* ---- the force element ---- */

static int drag(const mbsr_force_args *args)
{
    const double *v = args->body[0].V, speed = hypot(v[0], v[1]);
    for (int i = 0; i < 2; ++i) args->body[0].f[i] -= k * speed * v[i];
    return MBSR_OK;
}

static int heat(const mbsr_force_args *args, double *power)
{
    const double *v = args->body[0].V;
    *power = k * pow(hypot(v[0], v[1]), 3.0);
    return MBSR_OK;
}

/* -k (|v| 1 + v v^T / |v|), in the rows of f and the columns of V, which follow those of the pose;
 * without the second term if `whole` is 0. */
static int add_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out, int whole)
{
    const double *v = args->body[0].V, speed = hypot(v[0], v[1]);
    const int row = out->row[0], column = out->column[0] + 2;
    for (int j = 0; j < 2 && speed > 0.0; ++j) {
        double *entry = out->matrix + (size_t)(column + j) * (size_t)out->rows + row;
        entry[j] -= k * speed;
        for (int i = 0; i < 2; ++i) entry[i] -= whole * k * v[i] * v[j] / speed;
    }
    return MBSR_OK;
}

static int slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    return add_slopes(args, out, 1);
}

static int wrong_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    return add_slopes(args, out, 0);
}

/* What it does not read is not prepared for it. */
static const mbsr_force_table air = {.version = MBSR_FORCE_TABLE_VERSION,
                                     .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
                                     .name = "air",
                                     .evaluate = drag,
                                     .dissipation = heat,
                                     .derivatives = slopes};

/* ---- tests and a run ---- */

static double verify_joint(const char *what, const mbsr_joint_table *table)
{
    const double q = 0.3, u = 0.7; /* nothing zero by accident */
    const mbsr_joint of = joint(table);
    mbsr_joint_test at = mbsr_default_joint_test();
    mbsr_joint_errors errors;
    mbsr_error error;
    at.q = &q;
    at.u = &u;
    if (mbsr_joint_verify(&of, &at, &errors, &error)) {
        fprintf(stderr, "%s\n", error.text);
        return INFINITY;
    }
    printf("%-12s %.1e  %s\n", what, errors.largest, errors.largest > 1e-7 ? errors.text : "");
    return errors.largest;
}

static double verify_force(const char *what, mbsr_simulation *s, int force)
{
    mbsr_force_errors errors;
    if (mbsr_force_verify(s->model, s->data, force, &errors)) {
        fprintf(stderr, "%s\n", mbsr_data_error(s->data)->text);
        return INFINITY;
    }
    printf("%-12s %.1e  %s\n", what, errors.largest, errors.largest > 1e-7 ? errors.text : "");
    return errors.largest;
}

static void by_hand(void *user, double t, const double *x, double *xdot)
{
    const double slope = a * x[0], wide = 1.0 + slope * slope, speed = fabs(x[1]) * sqrt(wide);
    (void)user, (void)t;
    xdot[0] = x[1];
    xdot[1] = -slope * (g + a * x[1] * x[1]) / wide - k / mass * speed * x[1];
}

int main(void)
{
    mbsr_joint_table wrong_wire = wire;
    mbsr_force_table wrong_air = air;
    wrong_wire.bias = wrong_bias;
    wrong_air.derivatives = wrong_slopes;
    int wrong = verify_joint("wire", &wire) > 1e-7;
    wrong += verify_joint("wrong wire", &wrong_wire) < 1e-3;

    double x[2] = {0.5, 1.0}, worst = 0.0;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int bead = mbsr_simulation_add_body(&s, "bead", MBSR_GROUND, joint(&wire),
                                              mbsr_inertia_particle(mass));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -g, 0.0));
    const int right = mbsr_simulation_add_force(&s, mbsr_force_custom(&air, 1, &bead, NULL));
    const int other = mbsr_simulation_add_force(&s, mbsr_force_custom(&wrong_air, 1, &bead, NULL));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-8;
    mbsr_simulation_start(&s, &opt, 0.0, &x[0], &x[1]);
    if (s.status == MBSR_OK) {
        wrong += verify_force("air", &s, right) > 1e-7;
        wrong += verify_force("wrong air", &s, other) < 1e-3;
        mbsr_force_switch(s.model, s.data, other, 0);
    }
    mbsr_simulation_start(&s, &opt, 0.0, &x[0], &x[1]);
    for (int n = 1; n <= 20 && !mbsr_simulation_to(&s, 0.1 * n); ++n) {
        for (int i = 0; i < 100; ++i) rk4_step(by_hand, NULL, 2, 0.0, 1e-3, x);
        worst = fmax(worst, fabs(s.q[0] - x[0]));
        if (n % 5 == 0) printf("t = %.1f s: x = %+.6f m, by hand %+.6f m\n", s.t, s.q[0], x[0]);
    }
    if (s.status) fprintf(stderr, "%s\n", s.error.text);
    wrong += s.status != MBSR_OK || worst > 1e-6;
    mbsr_simulation_end(&s);
    return wrong;
}
