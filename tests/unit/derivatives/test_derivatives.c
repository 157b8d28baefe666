/* Derivatives of a pendulum, of a top, of a point on a circle; and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <math.h>
#include <string.h>

static const double mass = 2.0, length = 1.5, gravity = 9.81, inertia = 0.3;

static mbsr_model *model_with(const mbsr_body_def *bodies, int count,
                              const mbsr_closure_def *closure)
{
    mbsr_model *m;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, &error), &error);
    for (int k = 0; k < count; ++k)
        assert_ok(mbsr_model_add_body(m, bodies + k, NULL), mbsr_model_error(m));
    const mbsr_force_def down = mbsr_force_gravity(0.0, -gravity, 0.0);
    assert_ok(mbsr_model_add_force(m, &down, NULL), mbsr_model_error(m));
    if (closure) assert_ok(mbsr_model_add_closure(m, closure, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static mbsr_derivatives *derivatives_of(const mbsr_model *m)
{
    mbsr_derivatives *d;
    mbsr_error error;
    assert_ok(mbsr_derivatives_create(m, &d, &error), &error);
    return d;
}

/* Hanging at angle 0, the mass in the distance below. */
static mbsr_body_def pendulum(double m)
{
    mbsr_body_def b = mbsr_default_body_def();
    b.name = "pendulum";
    b.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    b.inertia = mbsr_inertia_planar(m, (const double[2]){0.0, -length}, m > 0.0 ? inertia : 0.0);
    return b;
}

/* (m l^2 + I) u' + m g l sin q = tau */
static void a_pendulum(void **state)
{
    (void)state;
    const mbsr_body_def body = pendulum(mass);
    mbsr_model *m = model_with(&body, 1, NULL);
    mbsr_derivatives *d = derivatives_of(m);
    const double q = 0.7, u = 1.3, tau = 0.4, one = 1.0, J = mass * length * length + inertia,
                 by_angle = mass * gravity * length * cos(q);
    double udot, out, by_q, by_u, by_load;
    assert_ok(mbsr_derivatives_forward(d, 0.0, &q, &u, &tau, &udot, NULL),
              mbsr_derivatives_error(d));
    assert_close(udot, (tau - mass * gravity * length * sin(q)) / J, 1e-14);
    assert_ok(mbsr_derivatives_tangent(d, &one, NULL, NULL, &out, NULL), NULL);
    assert_close(out, -by_angle / J, 1e-13);
    assert_ok(mbsr_derivatives_tangent(d, NULL, NULL, &one, &out, NULL), NULL);
    assert_close(out, 1.0 / J, 1e-15);
    assert_ok(mbsr_derivatives_adjoint(d, &one, NULL, &by_q, &by_u, &by_load), NULL);
    assert_close(by_q, -by_angle / J, 1e-13);
    assert_close(by_u, 0.0, 1e-14);
    assert_close(by_load, 1.0 / J, 1e-15);
    double torque;
    assert_ok(mbsr_derivatives_inverse(d, 0.0, &q, &u, &udot, &torque), mbsr_derivatives_error(d));
    assert_close(torque, tau, 1e-13);
    assert_ok(mbsr_derivatives_tangent(d, &one, &one, &one, &out, NULL), NULL);
    assert_close(out, by_angle + J, 1e-13);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

/* With a spring-damper at its hinge, on a slider that has one, too. */
static void springs_at_joints(void **state)
{
    (void)state;
    mbsr_body_def cart = mbsr_default_body_def(), rod = pendulum(mass);
    cart.joint = mbsr_joint_planar_prismatic((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    cart.inertia = mbsr_inertia_planar(1.0, (const double[2]){0.0, 0.0}, 0.0);
    rod.parent = 0;
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_ok(mbsr_model_add_body(m, &cart, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_body(m, &rod, NULL), mbsr_model_error(m));
    const mbsr_force_def spring[] = {mbsr_force_joint_spring(0, 0, 3.0, 0.4, 0.2),
                                     mbsr_force_joint_spring(1, 0, 5.0, 0.7, -0.3)};
    for (int k = 0; k < 2; ++k)
        assert_ok(mbsr_model_add_force(m, spring + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_derivatives *d = derivatives_of(m);
    const double q[2] = {0.4, 0.7}, u[2] = {-0.3, 1.3}, udot[2] = {0.2, 0.9}, l = mass * length,
                 e[2][2] = {{1.0, 0.0}, {0.0, 1.0}};
    /* (m + 1) x'' + l (a'' cos a - a'^2 sin a) and l x'' cos a + J a'', less the springs */
    double tau[2], out[2], by_q[2], by_u[2];
    assert_ok(mbsr_derivatives_inverse(d, 0.0, q, u, udot, tau), mbsr_derivatives_error(d));
    assert_ok(mbsr_derivatives_tangent(d, e[0], NULL, NULL, out, NULL), NULL);
    assert_close(out[0], 3.0, 1e-13);
    assert_close(out[1], 0.0, 1e-13);
    assert_ok(mbsr_derivatives_tangent(d, e[1], NULL, NULL, out, NULL), NULL);
    assert_close(out[0], l * (-udot[1] * sin(q[1]) - u[1] * u[1] * cos(q[1])), 1e-13);
    assert_close(out[1], 5.0 - l * udot[0] * sin(q[1]), 1e-13);
    assert_ok(mbsr_derivatives_adjoint(d, e[0], NULL, by_q, by_u, NULL), NULL);
    assert_close(by_q[0], 3.0, 1e-13);
    assert_close(by_q[1], l * (-udot[1] * sin(q[1]) - u[1] * u[1] * cos(q[1])), 1e-13);
    assert_close(by_u[0], 0.4, 1e-13);
    assert_close(by_u[1], -2.0 * l * u[1] * sin(q[1]), 1e-13);
    assert_ok(mbsr_derivatives_adjoint(d, e[1], NULL, by_q, by_u, NULL), NULL);
    assert_close(by_u[1], 0.7, 1e-13);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

static void cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* A top on a ball joint without gravity, turned as a whole with its velocity and torque: so turns
 * its acceleration. */
static void a_top(void **state)
{
    (void)state;
    const double tensor[6] = {1.0, 2.0, 2.5, 0.1, 0.2, 0.3}, turn[3] = {0.4, -0.9, 0.2},
                 q[4] = {0.5, -0.5, 0.5, 0.5}, u[3] = {0.3, -0.7, 1.1}, tau[3] = {0.1, 0.2, -0.3};
    mbsr_body_def b = mbsr_default_body_def();
    b.joint = mbsr_joint_spherical(NULL, NULL);
    b.inertia = mbsr_inertia_rigid(1.0, NULL, tensor);
    mbsr_model *m = model_with(&b, 1, NULL);
    mbsr_derivatives *d = derivatives_of(m);
    double udot[3], du[3], dtau[3], out[3], expected[3], back[3];
    assert_ok(mbsr_derivatives_forward(d, 0.0, q, u, tau, udot, NULL), mbsr_derivatives_error(d));
    cross(turn, u, du);
    cross(turn, tau, dtau);
    cross(turn, udot, expected);
    assert_ok(mbsr_derivatives_tangent(d, turn, du, dtau, out, NULL), NULL);
    for (int k = 0; k < 3; ++k) assert_close(out[k], expected[k], 1e-14);
    assert_ok(mbsr_derivatives_inverse(d, 0.0, q, u, udot, back), mbsr_derivatives_error(d));
    assert_ok(mbsr_derivatives_tangent(d, turn, du, expected, back, NULL), NULL);
    for (int k = 0; k < 3; ++k) assert_close(back[k], dtau[k], 1e-14);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

/* A point that a rod holds on a circle, at angle a and speed v: along the circle u' = -g sin(a) t -
 * v^2/l n and the force of the rod -m (v^2/l + g cos(a)) change as they do with a. */
static void a_point_on_a_circle(void **state)
{
    (void)state;
    const double a = 0.6, v = 1.7, n[2] = {sin(a), -cos(a)}, t[2] = {cos(a), sin(a)},
                 q[2] = {length * n[0], length * n[1]}, u[2] = {v * t[0], v * t[1]},
                 du[2] = {-v / length * n[0], -v / length * n[1]};
    mbsr_body_def b = mbsr_default_body_def();
    b.joint = mbsr_joint_point_free();
    b.inertia = mbsr_inertia_particle(mass);
    const mbsr_closure_def rod = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, length);
    mbsr_model *m = model_with(&b, 1, &rod);
    mbsr_derivatives *d = derivatives_of(m);
    double udot[2], lambda, out[2], dlambda, by_q[2], by_u[2];
    assert_ok(mbsr_derivatives_forward(d, 0.0, q, u, NULL, udot, &lambda),
              mbsr_derivatives_error(d));
    assert_close(lambda, -mass * (v * v / length + gravity * cos(a)), 1e-13);
    assert_ok(mbsr_derivatives_tangent(d, t, du, NULL, out, &dlambda), mbsr_derivatives_error(d));
    assert_close(dlambda, mass * gravity * sin(a) / length, 1e-11);
    for (int k = 0; k < 2; ++k) {
        assert_close(udot[k], -gravity * sin(a) * t[k] - v * v / length * n[k], 1e-13);
        const double by_angle =
            -gravity * cos(a) * t[k] + gravity * sin(a) * n[k] - v * v / length * t[k];
        assert_close(out[k], by_angle / length, 1e-11);
    }
    const double one = 1.0;
    assert_ok(mbsr_derivatives_adjoint(d, NULL, &one, by_q, by_u, NULL), NULL);
    assert_close(by_q[0] * t[0] + by_q[1] * t[1] + by_u[0] * du[0] + by_u[1] * du[1], dlambda,
                 1e-12);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

static void what_is_wrong_is_refused(void **state)
{
    (void)state;
    const mbsr_body_def heavy = pendulum(mass), light = pendulum(0.0);
    mbsr_model *m = model_with(&heavy, 1, NULL), *none = model_with(&light, 1, NULL), *unfinished;
    mbsr_derivatives *d = NULL;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &unfinished, NULL), NULL);
    assert_refused(mbsr_derivatives_create(NULL, &d, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "mbsr_derivatives_create|model is NULL");
    assert_refused(mbsr_derivatives_create(m, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "derivatives is NULL");
    assert_refused(mbsr_derivatives_create(unfinished, &d, &error), &error, MBSR_ERR_UNFINISHED,
                   MBSR_NONE, MBSR_NONE, "not finished");
    assert_null(d);
    assert_int_equal(mbsr_derivatives_forward(NULL, 0.0, NULL, NULL, NULL, NULL, NULL),
                     MBSR_ERR_NULL);
    assert_null(mbsr_derivatives_data(NULL));

    const double q = 0.7, u = 1.3, wrong = NAN;
    double out = 17.0, lambda;
    d = derivatives_of(m);
    const mbsr_error *why = mbsr_derivatives_error(d);
    assert_refused(mbsr_derivatives_tangent(d, &q, &q, &q, &out, NULL), why, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_derivatives_inverse");
    assert_refused(mbsr_derivatives_adjoint(d, &q, NULL, &out, NULL, NULL), why, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_derivatives_forward");
    assert_refused(mbsr_derivatives_forward(d, 0.0, NULL, &u, NULL, NULL, NULL), why, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "NULL");
    assert_int_equal(mbsr_derivatives_forward(d, 0.0, &wrong, &u, NULL, NULL, NULL),
                     MBSR_NOT_FINITE);
    assert_int_equal(mbsr_derivatives_inverse(d, 0.0, &q, &u, &wrong, NULL), MBSR_NOT_FINITE);
    assert_ok(mbsr_derivatives_inverse(d, 0.0, &q, &u, &u, NULL), why);
    assert_refused(mbsr_derivatives_tangent(d, &q, NULL, NULL, &out, &lambda), why, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "no loop forces");
    assert_refused(mbsr_derivatives_tangent(d, &q, NULL, NULL, NULL, NULL), why, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "out is NULL");
    assert_refused(mbsr_derivatives_tangent(d, &wrong, NULL, NULL, &out, NULL), why,
                   MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "not finite");
    assert_true(out == 17.0);
    mbsr_derivatives_destroy(d);

    d = derivatives_of(none);
    assert_int_equal(mbsr_derivatives_forward(d, 0.0, &q, &u, NULL, NULL, NULL), MBSR_UNDETERMINED);
    assert_contains(mbsr_derivatives_error(d)->text, "pendulum");
    assert_ok(mbsr_derivatives_inverse(d, 0.0, &q, &u, &u, &out), mbsr_derivatives_error(d));
    assert_close(out, 0.0, 0.0);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
    mbsr_model_destroy(none);
    mbsr_model_destroy(unfinished);
}

/* (m l^2 + I) u' + m g l sin q = tau, in m, l and I; g; what has no derivatives, and what is wrong.
 */
static void in_parameters(void **state)
{
    (void)state;
    const mbsr_body_def body = pendulum(mass);
    mbsr_model *m = model_with(&body, 1, NULL);
    mbsr_derivatives *d = derivatives_of(m);
    mbsr_parameters *list;
    assert_ok(mbsr_parameters_create(m, &list, NULL), NULL);
    static const char *const names[] = {"bodies.pendulum.mass", "bodies.pendulum.com[2]",
                                        "bodies.pendulum.I", "forces.force0.gy"};
    int which[4];
    for (int k = 0; k < 4; ++k) which[k] = mbsr_parameters_find(list, names[k]);
    const double q = 0.7, u = 1.3, tau = 0.4, one = 1.0, J = mass * length * length + inertia,
                 sine = sin(q), udot = (tau - mass * gravity * length * sine) / J;
    double by[4], out;
    assert_int_equal(mbsr_derivatives_parameter_adjoint(d, &one, NULL, by), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_derivatives_parameters(d, list, 4, which), mbsr_derivatives_error(d));
    assert_int_equal(mbsr_derivatives_parameter_tangent(d, by, &out, NULL), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_derivatives_forward(d, 0.0, &q, &u, &tau, NULL, NULL), NULL);
    assert_ok(mbsr_derivatives_parameter_adjoint(d, &one, NULL, by), mbsr_derivatives_error(d));
    assert_close(by[0], -(length * gravity * sine + length * length * udot) / J, 1e-13);
    assert_close(by[1], (mass * gravity * sine + 2.0 * mass * length * udot) / J, 1e-13);
    assert_close(by[2], -udot / J, 1e-14);
    assert_close(by[3], mass * length * sine / J, 1e-12);
    for (int k = 0; k < 4; ++k) {
        const double along[4] = {k == 0, k == 1, k == 2, k == 3};
        assert_ok(mbsr_derivatives_parameter_tangent(d, along, &out, NULL), NULL);
        assert_close(out, by[k], 1e-14);
    }
    const double bad[4] = {NAN, 0.0, 0.0, 0.0};
    assert_int_equal(mbsr_derivatives_parameter_tangent(d, bad, &out, NULL), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_derivatives_parameter_tangent(d, bad, NULL, NULL), MBSR_ERR_NULL);
    which[1] = 1000;
    assert_int_equal(mbsr_derivatives_parameters(d, list, 2, which), MBSR_ERR_ID);
    assert_non_null(strstr(mbsr_derivatives_error(d)->text, "which[1]"));
    assert_int_equal(mbsr_derivatives_parameters(d, NULL, 2, which), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_parameters(d, list, -1, which), MBSR_ERR_VALUE);
    assert_ok(mbsr_derivatives_parameter_adjoint(d, &one, NULL, by), NULL); /* as it was */
    const mbsr_body_def two[2] = {body, body};
    mbsr_model *other = model_with(two, 2, NULL);
    mbsr_derivatives *wrong = derivatives_of(other);
    assert_int_equal(mbsr_derivatives_parameters(wrong, list, 1, which), MBSR_ERR_VALUE);
    mbsr_derivatives_destroy(wrong);
    mbsr_model_destroy(other);
    assert_ok(mbsr_derivatives_parameters(d, NULL, 0, NULL), NULL);
    assert_int_equal(mbsr_derivatives_parameter_adjoint(d, &one, NULL, by), MBSR_ERR_SEQUENCE);
    mbsr_parameters_destroy(list);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

/* F = (q' - u, p' + m g l sin q, J u - p), J = m l^2 + I, in q and u, in y' and in m, l, I. */
static void of_the_residual(void **state)
{
    (void)state;
    const mbsr_body_def body = pendulum(mass);
    mbsr_model *m = model_with(&body, 1, NULL);
    mbsr_derivatives *d = derivatives_of(m);
    const mbsr_error *why = mbsr_derivatives_error(d);
    mbsr_parameters *list;
    assert_ok(mbsr_parameters_create(m, &list, NULL), NULL);
    const int which[3] = {mbsr_parameters_find(list, "bodies.pendulum.mass"),
                          mbsr_parameters_find(list, "bodies.pendulum.com[2]"),
                          mbsr_parameters_find(list, "bodies.pendulum.I")};
    const double u = 1.3, J = mass * length * length + inertia, y[3] = {0.7, J * u, u},
                 yp[3] = {u, 0.2, 0.0}, w[3] = {1.0, 10.0, 100.0}, sine = gravity * sin(y[0]),
                 bad[3] = {NAN, 0.0, 0.0};
    double F[3] = {0.0}, by[3], by_yp[3], by_theta[3];
    assert_refused(mbsr_derivatives_residual_tangent(d, y, NULL, NULL, F), why, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_derivatives_residual");
    assert_ok(mbsr_derivatives_residual(d, 0.0, y, yp, F), why);
    assert_close(F[1], 0.2 + mass * length * sine, 1e-13);
    assert_refused(mbsr_derivatives_residual_tangent(d, NULL, NULL, y, F), why, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_derivatives_parameters");
    assert_refused(mbsr_derivatives_tangent(d, y, NULL, NULL, F, NULL), why, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_derivatives_inverse");
    assert_ok(mbsr_derivatives_parameters(d, list, 3, which), why);
    assert_int_equal(mbsr_derivatives_residual_adjoint(d, w, by, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_derivatives_residual(d, 0.0, bad, yp, F), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_derivatives_residual(d, 0.0, NULL, yp, F), MBSR_ERR_NULL);
    assert_ok(mbsr_derivatives_residual(d, 0.0, y, yp, NULL), why);
    assert_ok(mbsr_derivatives_residual_adjoint(d, w, by, by_yp, by_theta), why);
    assert_close(by[0], w[1] * mass * gravity * length * cos(y[0]), 1e-11);
    assert_close(by[1], -w[2], 0.0);
    assert_close(by[2], w[2] * J - w[0], 1e-12);
    assert_close(by_yp[0], w[0], 0.0);
    assert_close(by_yp[1], w[1], 0.0);
    assert_close(by_yp[2], 0.0, 0.0);
    assert_close(by_theta[0], w[1] * length * sine + w[2] * length * length * u, 1e-11);
    assert_close(by_theta[1], -(w[1] * mass * sine + w[2] * 2.0 * mass * length * u), 1e-11);
    assert_close(by_theta[2], w[2] * u, 1e-12);
    assert_int_equal(mbsr_derivatives_residual_tangent(d, bad, NULL, NULL, F), MBSR_NOT_FINITE);
    assert_int_equal(mbsr_derivatives_residual_tangent(d, NULL, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_residual_adjoint(d, bad, by, NULL, NULL), MBSR_NOT_FINITE);
    mbsr_parameters_destroy(list);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

/* A spring that is a closure. */
static void parameters_without_derivatives(void **state)
{
    (void)state;
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = pendulum(mass);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 3.0, 0.1, 0.0);
    spring.name = "torsion";
    spring.as_closure = MBSR_SPRING_LOOSE;
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_derivatives *d = derivatives_of(m);
    mbsr_parameters *list;
    assert_ok(mbsr_parameters_create(m, &list, NULL), NULL);
    const int which = mbsr_parameters_find(list, "forces.torsion.stiffness");
    assert_true(which >= 0);
    assert_int_equal(mbsr_derivatives_parameters(d, list, 1, &which), MBSR_ERR_SPACE);
    assert_non_null(strstr(mbsr_derivatives_error(d)->text, "forces.torsion.stiffness"));
    mbsr_parameters_destroy(list);
    mbsr_derivatives_destroy(d);
    mbsr_model_destroy(m);
}

/* A trunk with legs, added leg by leg, so that coordinates stand as their places in the tree do:
 * matrices are the products with unit vectors, also of more than 200 coordinates. */
static void matrices_of_legs(void **state)
{
    static const int legs[] = {2, 3, 4, 5, 68}; /* 7, 10, 13, 16, 205 coordinates */
    enum { MOST = 205, BODIES = 2 + 3 * 68 };
    static mbsr_body_def body[BODIES];
    static double q[MOST], u[MOST], tau[MOST], udot[MOST], by[3][MOST * MOST], x[MOST], y[MOST];
    const double one[3] = {0.2, 0.9, 0.1}, other[3] = {0.1, -0.2, 1.0}, com[3] = {0.1, 0.2, -0.3},
                 tensor[6] = {0.2, 0.3, 0.25, 0.01, -0.02, 0.03};
    (void)state;
    for (size_t k = 0; k < sizeof legs / sizeof *legs; ++k) {
        int count = 0;
        for (int b = 0; b < 1 + 3 * legs[k]; ++b) {
            const mbsr_frame at = mbsr_frame_at(0.3, b % 3 ? 0.0 : 0.1 * b, -0.2);
            body[b] = mbsr_default_body_def();
            body[b].parent = b % 3 == 1 ? 0 : b - 1;
            body[b].joint = mbsr_joint_revolute(&at, NULL, b % 2 ? one : other);
            body[b].inertia = mbsr_inertia_rigid(1.0 + 0.1 * (b % 5), com, tensor);
            count = b + 1;
        }
        mbsr_model *m = model_with(body, count, NULL);
        mbsr_derivatives *d = derivatives_of(m);
        const int nu = mbsr_model_nu(m);
        for (int l = 0; l < nu; ++l)
            q[l] = sin(1.0 + l), u[l] = cos(3.0 * l), tau[l] = sin(5.0 * l);
        assert_ok(mbsr_derivatives_forward(d, 0.0, q, u, tau, udot, NULL),
                  mbsr_derivatives_error(d));
        assert_ok(mbsr_derivatives_matrices(d, by[0], by[1], by[2]), mbsr_derivatives_error(d));
        for (int way = 0; way < 3; ++way) {
            double largest = 0.0;
            for (int l = 0; l < nu * nu; ++l) largest = fmax(largest, fabs(by[way][l]));
            for (int c = 0; c<nu; c += nu> 20 ? 17 : 1) {
                memset(x, 0, sizeof x);
                x[c] = 1.0;
                assert_ok(mbsr_derivatives_tangent(d, way == 0 ? x : NULL, way == 1 ? x : NULL,
                                                   way == 2 ? x : NULL, y, NULL),
                          mbsr_derivatives_error(d));
                for (int r = 0; r < nu; ++r)
                    assert_close(by[way][c * nu + r], y[r], 1e-10 * largest);
            }
        }
        mbsr_derivatives_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* How the angle of a rod is accelerated by the point, straight above, that a spring holds it from:
 * along the first coordinate of that, which is 0, times the size of the rod. */
static double by_a_point(double size)
{
    const double com[3] = {0.2 * size, 0.0, 0.0}, tip[3] = {0.3 * size, 0.0, 0.0},
                 above[3] = {0.0, 0.5 * size, 0.0}, z[3] = {0.0, 0.0, 1.0}, q = 0.4, u = 0.0,
                 one = 1.0;
    double udot, change;
    mbsr_model *m = NULL;
    mbsr_derivatives *derivatives;
    mbsr_parameters *list;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def rod = mbsr_default_body_def();
    rod.joint = mbsr_joint_revolute(NULL, NULL, z);
    rod.inertia = mbsr_inertia_point_mass(2.0, com);
    assert_ok(mbsr_model_add_body(m, &rod, NULL), mbsr_model_error(m));
    mbsr_force_def spring =
        mbsr_force_point_spring(0, tip, MBSR_GROUND, above, 400.0, 0.0, 0.1 * size);
    spring.name = "spring";
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    const int which = mbsr_parameters_find(list, "forces.spring.point_b[1]");
    assert_true(which >= 0);
    assert_ok(mbsr_derivatives_create(m, &derivatives, &error), &error);
    assert_ok(mbsr_derivatives_parameters(derivatives, list, 1, &which),
              mbsr_derivatives_error(derivatives));
    assert_ok(mbsr_derivatives_forward(derivatives, 0.0, &q, &u, NULL, &udot, NULL),
              mbsr_derivatives_error(derivatives));
    assert_ok(mbsr_derivatives_parameter_tangent(derivatives, &one, &change, NULL),
              mbsr_derivatives_error(derivatives));
    mbsr_derivatives_destroy(derivatives);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
    return change * size;
}

static void points_in_models_of_all_sizes(void **state)
{
    (void)state;
    const double expected = by_a_point(1.0);
    assert_true(fabs(expected) > 10.0);
    for (double size = 1e-5; size < 1e6; size *= 10.0)
        assert_close(by_a_point(size) / expected, 1.0, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_pendulum),
                                       cmocka_unit_test(springs_at_joints),
                                       cmocka_unit_test(a_top),
                                       cmocka_unit_test(a_point_on_a_circle),
                                       cmocka_unit_test(what_is_wrong_is_refused),
                                       cmocka_unit_test(matrices_of_legs),
                                       cmocka_unit_test(in_parameters),
                                       cmocka_unit_test(of_the_residual),
                                       cmocka_unit_test(parameters_without_derivatives),
                                       cmocka_unit_test(points_in_models_of_all_sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
