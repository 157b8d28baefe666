/* More runs of the Modelica Standard Library, of its examples and of its tests; models written by
 * hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

static const double pi = 3.14159265358979323846, g = 9.80665, here[3] = {0.0, 0.0, 0.0},
                    x_axis[3] = {1.0, 0.0, 0.0}, y_axis[3] = {0.0, 1.0, 0.0},
                    z_axis[3] = {0.0, 0.0, 1.0};

/* Dymola's tolerance is 1e-6; what its runs differ from exact ones is some 1e-5. */
static const double allowed = 1e-4;

#define DYMOLA "Dymola 2020x, tolerance 10⁻⁶, from modelica/MAP-LIB_ReferenceResults: "

static void run(mbsr_simulation *s, const double *q, const double *u, double t)
{
    sheet_start(s, 1e-9, q, u);
    sheet_run(s, t);
}

static void gravity_down(mbsr_simulation *s)
{
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, -g, 0.0));
}

/* A body in turned axes that a spring pulls; the joint says how it may move. */
static mbsr_simulation on_a_spring(mbsr_joint (*joint)(const mbsr_frame *at))
{
    static const double place[3] = {0.2, -0.3, 0.2}, hook[3] = {0.8, 0.0, 0.3},
                        eye[3] = {0.4, 0.0, 0.0}, com[3] = {0.2, 0.0, 0.0},
                        tensor[6] = {1.0, 1.0, 1.0};
    const double degree = pi / 180.0;
    const mbsr_frame x = mbsr_frame_rotated(place, x_axis, 10.0 * degree),
                     y = mbsr_frame_rotated(NULL, y_axis, 55.0 * degree),
                     z = mbsr_frame_rotated(NULL, z_axis, 68.0 * degree),
                     xy = mbsr_frame_product(&x, &y), at = mbsr_frame_product(&xy, &z);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND, joint(&at),
                                              mbsr_inertia_rigid(1.0, com, tensor));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, hook, body, eye, 20.0, 0.0, 0.0));
    run(&s, NULL, NULL, 1.0);
    return s;
}

static mbsr_joint hinge_about_y(const mbsr_frame *at)
{
    return mbsr_joint_revolute(at, NULL, y_axis);
}

static mbsr_joint two_slides(const mbsr_frame *at)
{
    static const mbsr_axis axes[2] = {{.kind = MBSR_AXIS_TRANSLATION, .direction = {1, 0, 0}},
                                      {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 1, 0}}};
    return mbsr_joint_compound(at, NULL, 2, axes, NULL, NULL);
}

static mbsr_joint ball(const mbsr_frame *at)
{
    return mbsr_joint_spherical(at, NULL);
}

static void constraints(sheet *out)
{
    double twist[6] = {0.0}, pose[MBSR_POSE_SIZE] = {0.0}, w[3] = {0.0};
    mbsr_simulation s = on_a_spring(hinge_about_y);
    sheet_problem(out, "Body on a hinge and a spring at 1 s", DYMOLA "RevoluteConstraint.");
    sheet_add(out, "φ, rad", -1.6715127053912715, s.q[0], allowed);
    sheet_add(out, "ω, rad/s", -2.3373470242202958, s.u[0], allowed);
    mbsr_simulation_end(&s);

    s = on_a_spring(two_slides);
    sheet_problem(out, "Body on two slides and a spring at 1 s", DYMOLA "PrismaticConstraint.");
    sheet_add(out, "s₁, m", -0.58076440932587958, s.q[0], allowed);
    sheet_add(out, "s₂, m", -0.35021485798525254, s.q[1], allowed);
    sheet_add(out, "s₁′, m/s", 2.0377809214020841, s.u[0], allowed);
    sheet_add(out, "s₂′, m/s", 1.2288307350346259, s.u[1], allowed);
    mbsr_simulation_end(&s);

    s = on_a_spring(ball);
    sheet_check(mbsr_body_twist(s.model, s.data, 0, twist), &s.error);
    sheet_check(mbsr_body_pose(s.model, s.data, 0, pose), &s.error);
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) w[k] += pose[MBSR_POSE_R + l + 3 * k] * twist[l];
    sheet_problem(out, "Body on a ball joint and a spring at 1 s", DYMOLA "SphericalConstraint.");
    sheet_add(out, "ω about y of the body, rad/s", -2.2109596366475746, w[1], allowed);
    sheet_add(out, "ω about z of the body, rad/s", -0.91610104438173701, w[2], allowed);
    mbsr_simulation_end(&s);
}

static void spring_and_mass(sheet *out)
{
    static const double down[3] = {0.0, -1.0, 0.0}, start = 0.1, com[2] = {1.0, 0.0};
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body =
        mbsr_simulation_add_body(&s, "mass", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, down),
                                 mbsr_inertia_point_mass(1.0, here));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, 30.0, 0.0, 0.1));
    run(&s, &start, NULL, 1.0);
    sheet_problem(out, "Mass on a slide and a spring at 1 s", DYMOLA "SpringMassSystem.");
    sheet_add(out, "s, m", 0.20054364245848472, s.q[0], allowed);
    sheet_add(out, "s′, m/s", -1.2917998749849831, s.u[0], allowed);
    mbsr_simulation_end(&s);

    s = mbsr_simulation_begin(NULL);
    body = mbsr_simulation_add_body(&s, "pendulum", MBSR_GROUND,
                                    mbsr_joint_planar_revolute(origin, origin),
                                    mbsr_inertia_planar(5.0, com, 0.0));
    gravity_down(&s);
    run(&s, NULL, NULL, 0.49984);
    sheet_problem(out, "Pendulum of a point mass at 0.49984 s", DYMOLA "PointMass (ModelicaTest).");
    sheet_add(out, "φ, rad", -1.1679698799259213, s.q[body], allowed);
    sheet_add(out, "φ′, rad/s", -4.2477519921787552, s.u[body], allowed);
    mbsr_simulation_end(&s);
}

static int attraction(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    (void)v;
    (void)power;
    *force = 1.0 / (x * x);
    if (energy) *energy = -1.0 / x;
    return MBSR_OK;
}

/* Two particles that a spring ties, about a centre of attraction. */
static void tied_particles(sheet *out)
{
    static const double q[6] = {0.0, 0.8, 0.0, 0.3, 0.8, 0.0}, u[6] = {0.6, 0, 0, 0.6, 0, 0};
    const mbsr_spring law = {.function = attraction};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body[2];
    for (int k = 0; k < 2; ++k) {
        body[k] =
            mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_translational(NULL, NULL),
                                     mbsr_inertia_particle(1.0));
        mbsr_simulation_add_force(&s, mbsr_force_spring(MBSR_GROUND, NULL, body[k], NULL, &law));
    }
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(body[0], NULL, body[1], NULL, 10.0, 0.0, 0.0));
    run(&s, q, u, 0.5);
    sheet_problem(out, "Two particles on a spring in a central field at 0.5 s",
                  DYMOLA "PointGravityWithPointMasses.");
    sheet_add(out, "x₁, m", 0.49674013280939544, s.q[0], allowed);
    sheet_add(out, "y₁, m", 0.61390510088955708, s.q[1], allowed);
    sheet_add(out, "x₂, m", 0.29470872837007822, s.q[3], allowed);
    sheet_add(out, "y₂, m", 0.63158388125439213, s.q[4], allowed);
    mbsr_simulation_end(&s);
}

/* 2 N m sin(2 pi t + phase) on a joint; user: the phase, and minus one where it is reversed. */
static int sine(void *user, double t, int n, double *value)
{
    const double *p = user;
    (void)n;
    value[0] = p[1] * 2.0 * sin(2.0 * pi * t + p[0]);
    return MBSR_OK;
}

static void gear(sheet *out)
{
    static const double ratio[2] = {1.0, -10.0};
    static const int coordinate[2] = {0, 0};
    static double forward[2] = {0.0, 1.0};
    const mbsr_frame middle = mbsr_frame_along((const double[3]){0.2, 0.0, 0.0}, x_axis);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body[2];
    for (int k = 0; k < 2; ++k)
        body[k] = mbsr_simulation_add_body(
            &s, NULL, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, x_axis),
            mbsr_inertia_in_frame(&middle,
                                  mbsr_inertia_cylinder(7700.0, k == 0 ? 0.05 : 0.1, 0.4)));
    mbsr_simulation_add_closure(&s, mbsr_closure_coupling(2, body, coordinate, ratio, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_joint_applied(body[0], sine, forward));
    run(&s, NULL, NULL, 0.5);
    sheet_problem(out, "Gear between two shafts at 0.5 s", DYMOLA "GearConstraint.");
    sheet_add(out, "φ, rad", 0.45374774813224678, s.q[1], allowed);
    sheet_add(out, "φ′, rad/s", 1.814978298099357, s.u[1], allowed);
    mbsr_simulation_end(&s);
}

/* A damper and a spring in series, whose node is without mass, beside a spring. In space. */
static void series_in_space(sheet *out)
{
    const double q[4] = {0.0, 0.25 * pi, 0.1, 0.0}, u[4] = {0.0, 0.0, 0.1, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int arm = mbsr_simulation_add_body(&s, "arm", MBSR_GROUND,
                                             mbsr_joint_universal(NULL, NULL, x_axis, y_axis),
                                             mbsr_inertia_zero()),
              mass = mbsr_simulation_add_body(&s, "mass", arm,
                                              mbsr_joint_prismatic(NULL, NULL, x_axis),
                                              mbsr_inertia_point_mass(1.0, here)),
              node = mbsr_simulation_add_body(
                  &s, "node", arm, mbsr_joint_prismatic(NULL, NULL, x_axis), mbsr_inertia_zero());
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(mass, 0, 10.0, 0.0, 0.1));
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(node, 0, 0.0, 10.0, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_point_spring(node, NULL, mass, NULL, 10.0, 0.0, 0.1));
    run(&s, q, u, 0.5);
    sheet_problem(out, "Damper and spring in series beside a spring at 0.5 s",
                  DYMOLA "SpringDamperSeries (ModelicaTest).");
    sheet_add(out, "φ₁, rad", -1.5314440343081384, s.q[0], allowed);
    sheet_add(out, "φ₂, rad", 1.5314748631627451, s.q[1], allowed);
    sheet_add(out, "s, m", 0.91755960098322153, s.q[2], allowed);
    sheet_add(out, "s of the damper, m", 0.12759761946177398, s.q[3], allowed);
    mbsr_simulation_end(&s);
}

/* The same on a body in the plane. */
static void series_in_the_plane(sheet *out)
{
    static const double com[2] = {0.0, -0.2};
    const double q[4] = {-0.5 * pi, 0.2, 0.5 * pi, 0.0}, u[4] = {0.0, 0.0, 0.034906585039887, 0.0};
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0}, place = {0.9, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int arm = mbsr_simulation_add_body(&s, "arm", MBSR_GROUND,
                                             mbsr_joint_planar_revolute(place, origin),
                                             mbsr_inertia_zero()),
              tip = mbsr_simulation_add_body(
                  &s, "tip", arm, mbsr_joint_planar_prismatic(origin, origin), mbsr_inertia_zero());
    mbsr_simulation_add_body(&s, "body", tip, mbsr_joint_planar_revolute(origin, origin),
                             mbsr_inertia_planar(1.0, com, 0.1));
    const int node = mbsr_simulation_add_body(
        &s, "node", arm, mbsr_joint_planar_prismatic(origin, origin), mbsr_inertia_zero());
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(tip, 0, 30.0, 0.0, 0.2));
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(node, 0, 0.0, 2.0, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_point_spring(node, NULL, tip, NULL, 30.0, 0.0, 0.1));
    run(&s, q, u, 0.501);
    sheet_problem(out, "Body on a spring, and on a damper and a spring in series, at 0.501 s",
                  DYMOLA "HeatLosses, body 3.");
    sheet_add(out, "x, m", 0.9015827888715473, 0.9 + s.q[1] * cos(s.q[0]), allowed);
    sheet_add(out, "y, m", -0.69094620352518477, s.q[1] * sin(s.q[0]), allowed);
    mbsr_simulation_end(&s);
}

/* A constant torque of 1000 N m. */
static int thousand(void *user, double t, int n, double *value)
{
    (void)user;
    (void)t;
    (void)n;
    value[0] = 1000.0;
    return MBSR_OK;
}

/* A square of four rods on an axis that turns; one row of the pin that closes it is not needed. */
static void square(sheet *out)
{
    static const double end[3] = {1.0, 0.0, 0.0}, far[3] = {-1.0, 0.0, 0.0};
    const double q[4] = {0.0, 0.5 * pi, 0.5 * pi, 0.5 * pi}, u[4] = {2.0 * pi, 0.0, 0.0, 0.0};
    const mbsr_frame y = mbsr_frame_rotated(NULL, y_axis, 0.5 * pi),
                     z = mbsr_frame_rotated(NULL, z_axis, 0.25 * pi),
                     both = mbsr_frame_product(&y, &z), back = mbsr_frame_inverse(&both),
                     tip = mbsr_frame_at(1.0, 0.0, 0.0),
                     before = mbsr_frame_along((const double[3]){-0.5, 0.0, 0.0}, x_axis),
                     behind = mbsr_frame_along((const double[3]){0.5, 0.0, 0.0}, x_axis);
    const mbsr_inertia rod = mbsr_inertia_cylinder(7700.0, 0.1, 1.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int base =
        mbsr_simulation_add_body(&s, "base", MBSR_GROUND, mbsr_joint_revolute(NULL, &back, x_axis),
                                 mbsr_inertia_in_frame(&before, rod));
    int body = base;
    for (int k = 0; k < 3; ++k) {
        body = mbsr_simulation_add_body(&s, NULL, body,
                                        mbsr_joint_revolute(k == 0 ? NULL : &tip, NULL, y_axis),
                                        mbsr_inertia_in_frame(&behind, rod));
        if (k == 0) mbsr_simulation_add_force(&s, mbsr_force_joint_applied(body, thousand, NULL));
    }
    gravity_down(&s);
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(body, end, base, far));
    run(&s, q, u, 0.5);
    sheet_problem(out, "Square of four rods on an axis at 0.5 s",
                  DYMOLA "RevolutePlanarLoopConstraint (ModelicaTest).");
    sheet_add(out, "φ of the axis, rad", 1.6680492534644344, s.q[0], allowed);
    sheet_add(out, "φ′ of the axis, rad/s", 2.7809383985143095, s.u[0], allowed);
    sheet_add(out, "φ of the first rod, rad", 4.5263086089602727, s.q[1], allowed);
    sheet_add(out, "φ′ of the first rod, rad/s", 6.7561222298869978, s.u[1], allowed);
    mbsr_simulation_end(&s);
}

static int pull(void *user, double t, int n, double *value)
{
    (void)user;
    (void)t;
    for (int k = 0; k < n; ++k) value[k] = k == 3 ? 1.0 : 0.0;
    return MBSR_OK;
}

/* Two wheels on an axle that stays level; a body of 0.01 kg ahead of it. Rows are redundant. */
static mbsr_simulation wheel_set(int driven, double t)
{
    static const double ahead[3] = {0.2, 0.0, 0.0}, small[6] = {0.001, 0.001, 0.001},
                        centre[3] = {0.0, 0.0, 0.0}, tensor[6] = {0.02, 0.01, 0.02};
    static double drive[2][2] = {{0.0, -1.0}, {1.5707963267949, -1.0}};
    const mbsr_frame start = mbsr_frame_at(0.1, 0.1, 0.1), ground = mbsr_frame_identity(),
                     disc = mbsr_frame_along(NULL, y_axis);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int axle =
        mbsr_simulation_add_body(&s, "axle", MBSR_GROUND, mbsr_joint_in_plane(&start, NULL),
                                 mbsr_inertia_rigid_unchecked(0.01, ahead, small));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -g));
    for (int k = 0; k < 2; ++k) {
        const mbsr_frame end = mbsr_frame_at(0.0, k == 0 ? 0.25 : -0.25, 0.0);
        const int wheel =
            mbsr_simulation_add_body(&s, NULL, axle, mbsr_joint_revolute(&end, NULL, y_axis),
                                     mbsr_inertia_rigid(0.5, centre, tensor));
        mbsr_simulation_add_closure(
            &s, mbsr_closure_rolling_disc(wheel, &disc, 0.1, MBSR_GROUND, &ground));
        if (driven) mbsr_simulation_add_force(&s, mbsr_force_joint_applied(wheel, sine, drive[k]));
    }
    if (!driven) mbsr_simulation_add_force(&s, mbsr_force_wrench(axle, ahead, 0, pull, NULL));
    run(&s, NULL, NULL, t);
    return s;
}

static void wheel_sets(sheet *out)
{
    double pose[MBSR_POSE_SIZE] = {0.0};
    mbsr_simulation s = wheel_set(1, 0.501);
    sheet_check(mbsr_body_pose(s.model, s.data, 0, pose), &s.error);
    sheet_problem(out, "Wheels on an axle, driven, at 0.501 s", DYMOLA "RollingWheelSetDriving.");
    sheet_add(out, "x, m", -0.74288147274115235, pose[MBSR_POSE_X], allowed);
    sheet_add(out, "y, m", 0.11980246357463133, pose[MBSR_POSE_X + 1], allowed);
    sheet_add(out, "φ of the first wheel, rad", -10.270894779212181, s.q[3], allowed);
    sheet_add(out, "φ of the second wheel, rad", -7.0739465011935581, s.q[4], allowed);
    mbsr_simulation_end(&s);

    s = wheel_set(0, 0.501);
    sheet_check(mbsr_body_pose(s.model, s.data, 0, pose), &s.error);
    sheet_problem(out, "Wheels on an axle, pulled, at 0.501 s", DYMOLA "RollingWheelSetPulling.");
    sheet_add(out, "x, m", 0.14169451827315327, pose[MBSR_POSE_X], allowed);
    sheet_add(out, "φ of the first wheel, rad", 0.4169451827315323, s.q[3], allowed);
    mbsr_simulation_end(&s);
}

void sheet_modelica_more(sheet *out)
{
    constraints(out);
    spring_and_mass(out);
    tied_particles(out);
    gear(out);
    series_in_space(out);
    series_in_the_plane(out);
    square(out);
    wheel_sets(out);
}
