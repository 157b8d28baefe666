/* Problems in which no stiff spring closes a loop.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ordinary.h"

#include "bench.h"

#include <math.h>

static const mbsr_planar_frame here = {0.0, 0.0, 0.0};

static int add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    int id = MBSR_NONE;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    bench_check(mbsr_model_add_body(m, &body, &id), "body", mbsr_model_error(m)->text);
    return id;
}

static void force(mbsr_model *m, mbsr_force_def def)
{
    bench_check(mbsr_model_add_force(m, &def, NULL), "force", mbsr_model_error(m)->text);
}

/* ---- the pendulum on a bead and the two oscillators of bench_precision ---- */

static void bead(mbsr_model *m, double mass, double damping, double *q, double *u)
{
    const int b = add(m, MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_particle(mass));
    add(m, b, mbsr_joint_planar_revolute(here, (mbsr_planar_frame){0, 1, 0}),
        mbsr_inertia_particle(1.0));
    for (int axis = 0; axis < 2; ++axis)
        force(m, mbsr_force_axis_spring(b, MBSR_GROUND, axis, 100.0, damping, 0.0));
    force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    q[2] = 2.0, u[2] = 6.0;
}

static void bead_without_mass(mbsr_model *m, double *q, double *u)
{
    bead(m, 0.0, 5.0, q, u);
}

static void bead_of_a_gram(mbsr_model *m, double *q, double *u)
{
    bead(m, 1e-3, 5.0, q, u);
}

static void bead_undamped(mbsr_model *m, double *q, double *u)
{
    bead(m, 0.0, 0.0, q, u);
}

static int one_newton(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 1.0;
    return MBSR_OK;
}

static void oscillators(mbsr_model *m, double mass, double *q, double *u)
{
    const mbsr_joint joint = mbsr_joint_point(here, MBSR_X, 0, NULL, NULL);
    const int first = add(m, MBSR_GROUND, joint, mbsr_inertia_particle(mass));
    const int second = add(m, first, joint, mbsr_inertia_particle(1.0));
    force(m, mbsr_force_axis_spring(first, MBSR_GROUND, 0, 1.0, 1e-5, 0.0));
    force(m, mbsr_force_axis_spring(second, first, 0, 1.0, 1e-5, 0.0));
    force(m, mbsr_force_applied(first, one_newton, NULL));
    q[0] = mass > 0.0 ? 0.0 : 0.5, q[1] = -q[0];
    (void)u;
}

static void oscillators_without_mass(mbsr_model *m, double *q, double *u)
{
    oscillators(m, 0.0, q, u);
}

static void oscillators_with_mass(mbsr_model *m, double *q, double *u)
{
    oscillators(m, 1e-4, q, u);
}

/* ---- ten rods of 0.1 m and 0.1 kg, springs and dampers in the joints ---- */

static void chain(mbsr_model *m, double stiffness, double damping, double bend, double *q)
{
    const double com[2] = {0.05, 0.0};
    int before = MBSR_GROUND;
    for (int k = 0; k < 10; ++k) {
        const mbsr_planar_frame at = {k > 0 ? 0.1 : 0.0, 0.0, 0.0};
        before = add(m, before, mbsr_joint_planar_revolute(at, here),
                     mbsr_inertia_planar(0.1, com, 1e-4));
        q[k] = k == 0 ? 0.5 : bend;
        if (stiffness > 0.0 && (k > 0 || bend > 0.0))
            force(m, mbsr_force_joint_spring(before, 0, stiffness, damping, 0.0));
    }
    force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
}

static void chain_soft(mbsr_model *m, double *q, double *u)
{
    chain(m, 10.0, 0.01, 0.1, q);
    (void)u;
}

static void chain_stiff(mbsr_model *m, double *q, double *u)
{
    chain(m, 1e5, 1e2, 0.0, q);
    (void)u;
}

static void chain_stiff_lightly_damped(mbsr_model *m, double *q, double *u)
{
    chain(m, 100.0, 1e-2, 0.0, q);
    (void)u;
}

static void chain_loose(mbsr_model *m, double *q, double *u)
{
    chain(m, 0.0, 0.0, 0.0, q);
    (void)u;
}

/* Nine rods of 0.3 m, every third without mass, tied to the ground and, stiffer, to each other. */
static void tied_chain(mbsr_model *m, double *q, double *u)
{
    const double end[3] = {0.3, 0.0, 0.0};
    int body[9];
    for (int k = 0; k < 9; ++k) {
        const mbsr_planar_frame at = {k > 0 ? 0.3 : 0.0, 0.0, 0.0};
        const double anchor[3] = {0.3 * k, -0.5, 0.0};
        body[k] = add(m, k > 0 ? body[k - 1] : MBSR_GROUND, mbsr_joint_planar_revolute(at, here),
                      k % 3 == 2 ? mbsr_inertia_zero() : mbsr_inertia_planar(0.4, end, 0.002));
        force(m, mbsr_force_joint_spring(body[k], 0, 3.0, 0.2, 0.0));
        force(m, mbsr_force_point_spring(body[k], end, MBSR_GROUND, anchor, 20.0, 0.5, 0.4));
        if (k >= 3)
            force(m, mbsr_force_point_spring(body[k], end, body[k - 3], end, 3000.0, 20.0, 0.7));
    }
    force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    q[0] = 0.3, q[1] = -0.2, q[2] = 0.1, u[1] = 1.0, u[2] = -0.5;
}

/* ---- of the Test Set for IVP Solvers: the car axis, with relative angle ---- */

static int ground_angle(void *unused, double t, double *psi, double *rate, double *acceleration)
{
    (void)unused;
    const double x = 0.1 * sin(10.0 * t), v = cos(10.0 * t), root = sqrt(1.0 - x * x);
    *psi = asin(x);
    *rate = v / root;
    *acceleration = -100.0 * x / root + x * v * v / (root * root * root);
    return MBSR_OK;
}

static void car_axis(mbsr_model *m, double eps, double *q, double *u)
{
    const double mass = eps * eps * 5.0, origin[3] = {0}, end[3] = {1.0, 0.0, 0.0};
    const mbsr_planar_frame normal = {0.0, 0.0, acos(0.0)};
    const int line =
        add(m, MBSR_GROUND, mbsr_joint_planar(here, here, 0, MBSR_ANGLE, ground_angle, NULL),
            mbsr_inertia_zero());
    const int left =
        add(m, line, mbsr_joint_planar_prismatic(normal, normal), mbsr_inertia_particle(mass));
    const int bar =
        add(m, left, mbsr_joint_planar_revolute(here, here), mbsr_inertia_planar(mass, end, 0.0));
    force(m, mbsr_force_point_spring(left, origin, MBSR_GROUND, origin, 1.0, 0.0, 0.5));
    force(m, mbsr_force_point_spring(bar, end, line, end, 1.0, 0.0, 0.5));
    force(m, mbsr_force_gravity(0.0, -1.0, 0.0));
    q[0] = 0.5, u[1] = -1.0;
}

static void car_axis_with_mass(mbsr_model *m, double *q, double *u)
{
    car_axis(m, 1e-2, q, u);
}

static void car_axis_without_mass(mbsr_model *m, double *q, double *u)
{
    car_axis(m, 0.0, q, u);
}

/* ---- in space ---- */

/* Six bodies on ball joints, a swinging cable with massless links between. */
static void ball_chain(mbsr_model *m, double *q, double *u)
{
    const double com[3] = {0.0, 0.0, -0.2}, tensor[6] = {0.01, 0.01, 0.002};
    const mbsr_frame below = mbsr_frame_at(0.0, 0.0, -0.4);
    int before = MBSR_GROUND;
    for (int k = 0; k < 6; ++k) {
        before = add(m, before, mbsr_joint_spherical(k ? &below : NULL, NULL),
                     mbsr_inertia_rigid(0.5, com, tensor));
        const double angle = k == 0 ? 1.0 : 0.1;
        q[4 * k] = cos(0.5 * angle), q[4 * k + 1 + k % 2] = sin(0.5 * angle);
        u[3 * k + 2] = 0.5;
    }
    force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
}

/* A flyball governor with massless crosses, sideways on springs. */
static void governor(mbsr_model *m, double *q, double *u)
{
    const double end[3] = {0.0, 0.0, -1.0}, opening[3] = {0.0, -1.0, 0.0}, x[3] = {1, 0, 0},
                 z[3] = {0, 0, 1};
    const int shaft = add(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                          mbsr_inertia_cylinder(7800.0, 0.15, 0.1));
    int ball[2];
    for (int k = 0; k < 2; ++k) {
        const double place[3] = {k ? -0.1 : 0.1, 0.0, 0.0};
        const mbsr_frame hinge = mbsr_frame_rotated(place, z, k ? acos(-1.0) : 0.0);
        const int cross =
            add(m, shaft, mbsr_joint_revolute(&hinge, NULL, opening), mbsr_inertia_zero());
        ball[k] =
            add(m, cross, mbsr_joint_revolute(NULL, NULL, x), mbsr_inertia_point_mass(5.0, end));
        force(m, mbsr_force_joint_spring(ball[k], 0, 500.0, 0.0, 0.0));
    }
    force(m, mbsr_force_point_spring(ball[0], end, ball[1], end, 400.0, 0.0, 0.8));
    force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    q[1] = 0.5, q[2] = 0.02, q[3] = 0.6, u[0] = 9.0, u[2] = 0.3, u[3] = 0.5;
}

const ordinary ordinary_problems[] = {
    {"bead_without_mass", bead_without_mass, 10.0},
    {"bead_of_a_gram", bead_of_a_gram, 10.0},
    {"bead_undamped", bead_undamped, 10.0},
    {"oscillators_without_mass", oscillators_without_mass, 2.0},
    {"oscillators_with_mass", oscillators_with_mass, 2.0},
    {"chain_soft", chain_soft, 3.0},
    {"chain_stiff", chain_stiff, 3.0},
    {"chain_stiff_lightly_damped", chain_stiff_lightly_damped, 0.5},
    {"chain_loose", chain_loose, 2.0},
    {"tied_chain", tied_chain, 2.0},
    {"car_axis", car_axis_with_mass, 3.0},
    {"car_axis_without_mass", car_axis_without_mass, 3.0},
    {"ball_chain", ball_chain, 2.0},
    {"governor", governor, 3.0},
    {NULL, NULL, 0.0}};
