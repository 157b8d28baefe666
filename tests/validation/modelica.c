/* Runs of the Modelica Standard Library's multibody examples, models written by hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

static const double g = 9.80665, steel = 7700.0, x_axis[3] = {1.0, 0.0, 0.0},
                    y_axis[3] = {0.0, 1.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};

/* Dymola's tolerance is 1e-6; what its runs differ from exact ones is some 1e-5. */
static const double allowed = 1e-4;

static void begin(sheet *out, const char *problem)
{
    sheet_problem(out, problem,
                  "Dymola 2020x, tolerance 10⁻⁶, from modelica/MAP-LIB_ReferenceResults "
                  "(Modelica.Mechanics.MultiBody.Examples).");
}

static void run(mbsr_simulation *s, const double *q, const double *u, double t)
{
    sheet_start(s, 1e-9, q, u);
    sheet_run(s, t);
}

/* A body of the library: mass, centre of mass, three equal moments. */
static mbsr_inertia even(double mass, double x, double y, double moment)
{
    const double com[3] = {x, y, 0.0}, tensor[6] = {moment, moment, moment, 0.0, 0.0, 0.0};
    return mbsr_inertia_rigid(mass, com, tensor);
}

/* A bar of steel with a square section from the origin to (x, y), in the plane. */
static mbsr_inertia bar(double x, double y, double width)
{
    const double length = hypot(x, y), mass = steel * length * width * width,
                 com[2] = {0.5 * x, 0.5 * y};
    return mbsr_inertia_planar(mass, com, mass * (length * length + width * width) / 12.0);
}

/* A round rod of steel from the origin to `end`. */
static mbsr_inertia rod(const double end[3], double diameter)
{
    const double half[3] = {0.5 * end[0], 0.5 * end[1], 0.5 * end[2]};
    const mbsr_frame at = mbsr_frame_along(half, end);
    const double length = sqrt(end[0] * end[0] + end[1] * end[1] + end[2] * end[2]);
    return mbsr_inertia_in_frame(&at, mbsr_inertia_cylinder(steel, 0.5 * diameter, length));
}

static int hinge(mbsr_simulation *s, int parent, double x, double y, double angle,
                 mbsr_inertia inertia)
{
    return mbsr_simulation_add_body(s, NULL, parent,
                                    mbsr_joint_planar_revolute((mbsr_planar_frame){x, y, angle},
                                                               (mbsr_planar_frame){0.0, 0.0, 0.0}),
                                    inertia);
}

static void gravity_down(mbsr_simulation *s)
{
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, -g, 0.0));
}

/* Two springs meet a third, on which a body hangs, in a point without mass. */
static void three_springs(sheet *out)
{
    static const double bar1[3] = {0.3, 0.0, 0.0}, bar2[3] = {0.0, 0.0, 0.3},
                        q[10] = {0.2, -0.2, 0.1, 1.0, 0.0, 0.0, 0.0, 0.5, -0.3, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int junction = mbsr_simulation_add_body(
        &s, "junction", MBSR_GROUND, mbsr_joint_translational(NULL, NULL), mbsr_inertia_zero());
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                              even(0.8, 0.0, -0.2, 0.1));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, bar1, junction, NULL, 20.0, 0.0, 0.1));
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, bar2, junction, NULL, 20.0, 0.0, 0.1));
    mbsr_simulation_add_force(&s,
                              mbsr_force_point_spring(junction, NULL, body, NULL, 40.0, 0.0, 0.1));
    run(&s, q, NULL, 2.5);
    begin(out, "Three springs in series and parallel, junction without mass, at 2.5 s");
    sheet_add(out, "x, m", 0.3576958583, s.q[7], allowed);
    sheet_add(out, "y, m", -0.3365990136, s.q[8], allowed);
    sheet_add(out, "z, m", 0.09566996228, s.q[9], allowed);
    sheet_add(out, "y′, m/s", 1.31732724, s.u[7], allowed);
    mbsr_simulation_end(&s);
}

static void spring_damper_system(sheet *out)
{
    static const double bar1[3] = {0.3, 0.0, 0.0}, q[7] = {1.0, 0.0, 0.0, 0.0, 0.3, -0.2, 0.0},
                        u[6] = {0.0, 0.0, 0.03490658503988659, 0.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                              even(1.0, 0.0, -0.2, 0.1));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, bar1, body, NULL, 30.0, 2.0, 0.1));
    run(&s, q, u, 2.5);
    begin(out, "Body on a spring and a damper at 2.5 s");
    sheet_add(out, "x, m", 0.3016878744, s.q[4], allowed);
    sheet_add(out, "y, m", -0.4125474505, s.q[5], allowed);
    sheet_add(out, "ω, rad/s", -0.03393135777, s.u[2], allowed);
    mbsr_simulation_end(&s);
}

static void free_body(sheet *out)
{
    static const double far[3] = {0.8, 0.0, 0.0}, end[3] = {0.4, 0.0, 0.0};
    const double a = acos(-1.0) / 18.0; /* 10 degrees about x, then y, then z of the body */
    const mbsr_frame x = mbsr_frame_rotated(NULL, x_axis, a),
                     y = mbsr_frame_rotated(NULL, y_axis, a),
                     z = mbsr_frame_rotated(NULL, z_axis, a), xy = mbsr_frame_product(&x, &y),
                     start = mbsr_frame_product(&xy, &z);
    const double q[7] = {1.0, 0.0, 0.0, 0.0, 0.2, -0.5, 0.1};
    mbsr_frame turned = start;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    double pose[MBSR_POSE_SIZE] = {0.0};
    turned = mbsr_frame_inverse(&turned);
    const int body = mbsr_simulation_add_body(
        &s, "body", MBSR_GROUND, mbsr_joint_free(NULL, &turned), even(1.0, 0.2, 0.0, 1.0));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, NULL, body, NULL, 20.0, 0.0, 0.0));
    mbsr_simulation_add_force(&s,
                              mbsr_force_point_spring(MBSR_GROUND, far, body, end, 20.0, 0.0, 0.0));
    run(&s, q, NULL, 2.5);
    sheet_check(mbsr_body_pose(s.model, s.data, body, pose), &s.error);
    begin(out, "Free body between two springs at 2.5 s");
    sheet_add(out, "x, m", 0.2063911445, pose[MBSR_POSE_X], allowed);
    sheet_add(out, "y, m", -0.02131308126, pose[MBSR_POSE_X + 1], allowed);
    sheet_add(out, "z, m", -0.07906658611, pose[MBSR_POSE_X + 2], allowed);
    mbsr_simulation_end(&s);
}

static void pendulums(sheet *out)
{
    static const double com[2] = {0.5, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body = hinge(&s, MBSR_GROUND, 0.0, 0.0, 0.0, mbsr_inertia_planar(1.0, com, 0.001));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, 0.0, 0.1, 0.0));
    run(&s, NULL, NULL, 5.0);
    begin(out, "Damped pendulum at 5 s");
    sheet_add(out, "φ, rad", -1.679634642, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", -2.318147029, s.u[0], allowed);
    mbsr_simulation_end(&s);

    s = mbsr_simulation_begin(NULL);
    body = hinge(&s, MBSR_GROUND, 0.0, 0.0, 0.0, bar(0.5, 0.0, 0.06));
    hinge(&s, body, 0.5, 0.0, 0.0, bar(0.5, 0.0, 0.06));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, 0.0, 0.1, 0.0));
    run(&s, NULL, NULL, 1.5);
    begin(out, "Double pendulum at 1.5 s");
    sheet_add(out, "φ₁, rad", -1.48885217, s.q[0], allowed);
    sheet_add(out, "φ₂, rad", 1.364577394, s.q[1], allowed);
    sheet_add(out, "φ₁′, rad/s", 4.258107137, s.u[0], allowed);
    sheet_add(out, "φ₂′, rad/s", 4.843910521, s.u[1], allowed);
    mbsr_simulation_end(&s);
}

/* A slide that turns, without mass, and on it a body that a spring and a damper hold. */
static void pendulum_with_spring(sheet *out)
{
    static const double pivot[3] = {0.3, 0.0, 0.0}, q[2] = {0.0, 0.5};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int slide = hinge(&s, MBSR_GROUND, 0.3, 0.0, 0.0, mbsr_inertia_zero());
    const mbsr_planar_frame here = {0.0, 0.0, 0.0};
    const int body =
        mbsr_simulation_add_body(&s, "body", slide, mbsr_joint_planar_prismatic(here, here),
                                 mbsr_inertia_planar(1.0, NULL, 1.0));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, pivot, body, NULL, 20.0, 1.0, 0.2));
    run(&s, q, NULL, 2.5);
    begin(out, "Pendulum of changing length at 2.5 s");
    sheet_add(out, "s, m", 0.5882008173, s.q[1], allowed);
    sheet_add(out, "φ, rad", -2.153877415, s.q[0], allowed);
    sheet_add(out, "s′, m/s", 1.193809508, s.u[1], allowed);
    sheet_add(out, "φ′, rad/s", 0.6561081721, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* A mass of 0.5 kg is carried in the middle of the spring. */
static void spring_with_mass(sheet *out)
{
    static const double down[3] = {0.0, -1.0, 0.0}, q[2] = {0.3, 0.15}, ratio[2] = {0.5, -1.0};
    static const int coordinate[2] = {0, 0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body[2];
    for (int k = 0; k < 2; ++k)
        body[k] =
            mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, down),
                                     even(k == 0 ? 1.0 : 0.5, 0.0, 0.0, 0.0));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, NULL, body[0], NULL, 40.0, 0.0, 0.2));
    mbsr_simulation_add_closure(&s, mbsr_closure_coupling(2, body, coordinate, ratio, 0.0));
    run(&s, q, NULL, 1.25);
    begin(out, "Mass on a spring that has mass at 1.25 s");
    sheet_add(out, "y, m", -0.4259891607, -s.q[0], allowed);
    sheet_add(out, "y′, m/s", -1.133646067, -s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* A particle of 1 kg at the distance x from the centre of attraction. */
static int attraction(void *user, double x, double v, double *force, double *energy, double *power)
{
    const double mu = *(const double *)user;
    (void)v;
    (void)power;
    *force = mu / (x * x);
    if (energy) *energy = -mu / x;
    return MBSR_OK;
}

static void point_gravity(sheet *out)
{
    static const double q[14] = {1, 0, 0, 0, 0.0, 0.6, 0.0, 1, 0, 0, 0, 0.6, 0.6, 0.0},
                        u[12] = {0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0.6, 0, 0};
    double mu = 1.0;
    const mbsr_spring law = {.function = attraction, .user = &mu};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    for (int k = 0; k < 2; ++k) {
        const int body = mbsr_simulation_add_body(
            &s, NULL, MBSR_GROUND, mbsr_joint_free(NULL, NULL), even(1.0, 0.0, 0.0, 0.1));
        mbsr_simulation_add_force(&s, mbsr_force_spring(MBSR_GROUND, NULL, body, NULL, &law));
    }
    run(&s, q, u, 1.25);
    begin(out, "Two bodies about a centre of attraction at 1.25 s");
    sheet_add(out, "x₁, m", -0.3890160842, s.q[4], allowed);
    sheet_add(out, "y₁, m", 0.2308170236, s.q[5], allowed);
    sheet_add(out, "x₂, m", 0.5174182469, s.q[11], allowed);
    sheet_add(out, "y₂, m", 0.04950183525, s.q[12], allowed);
    mbsr_simulation_end(&s);
}

/* Particles on six spokes: the field turns the body. */
static void six_masses(sheet *out)
{
    static const double q[7] = {1, 0, 0, 0, 2, 0, 0}, u[6] = {0, 0, 0, 0, 0, -1.0},
                        tensor[6] = {4, 4, 4, 0, 0, 0}, com[3] = {0, 0, 0};
    double mu = 5.0;
    const mbsr_spring law = {.function = attraction, .user = &mu};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                              mbsr_inertia_rigid(6.0, com, tensor));
    for (int k = 0; k < 6; ++k) {
        double point[3] = {0.0, 0.0, 0.0};
        point[k / 2] = k % 2 ? -1.0 : 1.0;
        mbsr_simulation_add_force(&s, mbsr_force_spring(MBSR_GROUND, NULL, body, point, &law));
    }
    run(&s, q, u, 1.5);
    begin(out, "Six particles on spokes in a central field at 1.5 s");
    sheet_add(out, "x, m", 0.6407571566, s.q[4], allowed);
    sheet_add(out, "z, m", -0.5672493024, s.q[6], allowed);
    sheet_add(out, "ω, rad/s", 2.847881361, s.u[1], allowed);
    mbsr_simulation_end(&s);
}

/* A wheel on z = 0 about the y axis of its body. */
static void rolling_wheel(sheet *out)
{
    static const double q[7] = {1, 0, 0, 0, 0.2, 0.2, 0.3}, u[6] = {1.0, 5.0, 0.0, 1.5, -0.3, 0.0},
                        tensor[6] = {0.12, 0.06, 0.12, 0, 0, 0}, com[3] = {0, 0, 0};
    const mbsr_frame plane = mbsr_frame_along(NULL, y_axis), ground = mbsr_frame_identity();
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "wheel", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                              mbsr_inertia_rigid(2.0, com, tensor));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -g));
    mbsr_simulation_add_closure(&s,
                                mbsr_closure_rolling_disc(body, &plane, 0.3, MBSR_GROUND, &ground));
    run(&s, q, u, 1.0);
    begin(out, "Rolling wheel at 1 s");
    sheet_add(out, "x, m", 0.7005688915, s.q[4], allowed);
    sheet_add(out, "y, m", -0.7093622197, s.q[5], allowed);
    mbsr_simulation_end(&s);
}

/* A bar whose end a strut holds: two particles on the line between its ends, and a damper. */
static void strut(sheet *out)
{
    static const double tip[3] = {0.7, 0.0, 0.0}, first[2] = {0.2, 0.0}, second[2] = {-0.2, 0.0};
    const double q[3] = {0.0, 0.0, hypot(0.7, 1.2)};
    const mbsr_planar_frame here = {0.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int arm = hinge(&s, MBSR_GROUND, 0.0, 0.3, 0.0, bar(0.7, 0.0, 0.035)),
              tube = hinge(&s, MBSR_GROUND, 0.0, -0.9, atan2(1.2, 0.7),
                           mbsr_inertia_planar(1.0, first, 0.0)),
              piston = mbsr_simulation_add_body(&s, "piston", tube,
                                                mbsr_joint_planar_prismatic(here, here),
                                                mbsr_inertia_planar(1.0, second, 0.0));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(piston, 0, 0.0, 3.0, 0.0));
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(piston, NULL, arm, tip));
    run(&s, q, NULL, 1.5);
    begin(out, "Bar with a strut of two particles at 1.5 s");
    sheet_add(out, "φ, rad", -0.6831725482, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", 1.435828538, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

static void planar_four_bar(sheet *out)
{
    static const double end4[3] = {0.65, 0.1, 0.0}, end2[3] = {0.1, 1.1, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const double width = 0.05;
    const int body1 = hinge(&s, MBSR_GROUND, 0.0, 0.0, 0.0, bar(0.4, 0.0, width)),
              body2 = hinge(&s, body1, 0.4, 0.0, 0.0, bar(0.1, 1.1, width)),
              body4 = hinge(&s, MBSR_GROUND, -0.15, 1.0, 0.0, bar(0.65, 0.1, width));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body1, 0, 0.0, 0.1, 0.0));
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(body4, end4, body2, end2));
    run(&s, NULL, NULL, 0.3);
    begin(out, "Planar four-bar at 0.3 s");
    sheet_add(out, "φ, rad", -1.318242022, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", -10.0566051, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* Four bars in space: a hinge, a slide, a universal joint, and a ball that closes the loop. */
static void spatial_four_bar(sheet *out)
{
    static const double end1[3] = {0.0, 0.5, 0.1}, end2[3] = {0.0, 0.2, 0.0},
                        end3[3] = {-1.0, 0.3, 0.1}, q[4] = {0.0, -0.2, 0.0, 0.0};
    const mbsr_frame side = mbsr_frame_at(1.2, 0.0, 0.0), top = mbsr_frame_at(0.0, 0.2, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int b1 = mbsr_simulation_add_body(
                  &s, NULL, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, x_axis), rod(end1, 0.05)),
              b2 = mbsr_simulation_add_body(&s, NULL, MBSR_GROUND,
                                            mbsr_joint_prismatic(&side, NULL, x_axis),
                                            rod(end2, 0.05)),
              b3 = mbsr_simulation_add_body(
                  &s, NULL, b2, mbsr_joint_universal(&top, NULL, y_axis, z_axis), rod(end3, 0.05));
    gravity_down(&s);
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(b1, end1, b3, end3));
    mbsr_simulation_set_position(&s, b1, 0, 0.0);
    mbsr_simulation_set_rate(&s, b1, 0, 5.235987755982989);
    run(&s, q, NULL, 1.25);
    begin(out, "Four bars in space at 1.25 s");
    sheet_add(out, "φ, rad", 10.54641936, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", 9.664548711, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* The same with a rod without mass, which keeps the distance. */
static void distance_four_bar(sheet *out)
{
    static const double end1[3] = {0.0, 0.5, 0.1}, end2[3] = {0.0, 0.2, 0.0}, q[2] = {0.0, -0.2};
    const mbsr_frame side = mbsr_frame_at(1.2, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int b1 = mbsr_simulation_add_body(
                  &s, NULL, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, x_axis), rod(end1, 0.05)),
              b2 = mbsr_simulation_add_body(&s, NULL, MBSR_GROUND,
                                            mbsr_joint_prismatic(&side, NULL, x_axis),
                                            rod(end2, 0.05));
    gravity_down(&s);
    mbsr_simulation_add_closure(&s, mbsr_closure_distance(b1, end1, b2, end2, sqrt(1.1)));
    mbsr_simulation_set_position(&s, b1, 0, 0.0);
    mbsr_simulation_set_rate(&s, b1, 0, 5.235987755983);
    run(&s, q, NULL, 0.5);
    begin(out, "Four bars in space, one without mass, at 0.5 s");
    sheet_add(out, "φ, rad", 4.526129337, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", 8.870761016, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* A box of steel about the middle of its edge along y, from (x, y, 0). */
static mbsr_inertia web_of_crank(double x, double y, double length, double height)
{
    const double edges[3] = {0.02, fabs(length), height};
    const mbsr_frame at = mbsr_frame_at(x, y + 0.5 * length, 0.0);
    return mbsr_inertia_in_frame(&at, mbsr_inertia_box(steel, edges));
}

static mbsr_inertia shaft(double x, double y, double diameter)
{
    static const double along[3] = {0.1, 0.0, 0.0};
    const mbsr_frame at = mbsr_frame_at(x, y, 0.0);
    return mbsr_inertia_in_frame(&at, rod(along, diameter));
}

static void engine(sheet *out)
{
    static const double flywheel[6] = {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}, down[3] = {0.0, -1.0, 0.0},
                        piston_end[3] = {0.0, -0.1, 0.0}, rod_end[3] = {0.0, -0.2, 0.0},
                        pin[3] = {0.15, 0.1, 0.0}, row[6] = {0, 1, 0, 0, 0, 1},
                        q[3] = {0.0, 0.05, 0.0};
    const mbsr_frame top = mbsr_frame_at(0.15, 0.45, 0.0), end = mbsr_frame_at(0.0, -0.1, 0.0);
    const mbsr_inertia parts[4] = {shaft(0.0, 0.0, 0.05), web_of_crank(0.1, 0.0, 0.1, 0.05),
                                   shaft(0.1, 0.1, 0.03), web_of_crank(0.2, 0.1, -0.1, 0.05)};
    mbsr_inertia crank = mbsr_inertia_rigid(0.0, NULL, flywheel);
    for (int k = 0; k < 4; ++k) crank = mbsr_inertia_sum(crank, parts[k]);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "crank", MBSR_GROUND,
                                              mbsr_joint_revolute(NULL, NULL, x_axis), crank),
              piston = mbsr_simulation_add_body(&s, "piston", MBSR_GROUND,
                                                mbsr_joint_prismatic(&top, NULL, down),
                                                rod(piston_end, 0.1)),
              link = mbsr_simulation_add_body(&s, "rod", piston,
                                              mbsr_joint_revolute(&end, NULL, x_axis),
                                              web_of_crank(0.0, 0.0, -0.2, 0.06));
    gravity_down(&s);
    mbsr_simulation_add_closure(&s, mbsr_closure_rows(link, rod_end, body, pin, 2, row));
    mbsr_simulation_set_position(&s, body, 0, 0.0);
    mbsr_simulation_set_rate(&s, body, 0, 10.0);
    run(&s, q, NULL, 1.25);
    begin(out, "Engine of one cylinder at 1.25 s");
    sheet_add(out, "φ, rad", 13.3024948, s.q[0], allowed);
    sheet_add(out, "φ′, rad/s", 10.0023301, s.u[0], allowed);
    mbsr_simulation_end(&s);
}

/* A rotor at 45 degrees on an arm that a ball joint holds. */
static void gyroscope(sheet *out)
{
    static const double arm[3] = {0.25, 0.0, 0.0}, rotor[3] = {0.2, 0.0, 0.0},
                        u[4] = {0.0, 0.0, 0.0, 10.0};
    const mbsr_frame tilted = mbsr_frame_rotated(arm, y_axis, 0.25 * acos(-1.0)),
                     back = mbsr_frame_at(-0.1, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "arm", MBSR_GROUND,
                                              mbsr_joint_spherical(NULL, NULL), rod(arm, 0.05));
    mbsr_simulation_add_body(&s, "rotor", body, mbsr_joint_revolute(&tilted, NULL, x_axis),
                             mbsr_inertia_in_frame(&back, rod(rotor, 0.1)));
    gravity_down(&s);
    run(&s, NULL, u, 1.25);
    begin(out, "Rotor on an arm at 1.25 s");
    sheet_add(out, "φ, rad", 6.35932716, s.q[4], allowed);
    sheet_add(out, "φ′, rad/s", 1.12993461, s.u[3], allowed);
    mbsr_simulation_end(&s);
}

static void universal_joint(sheet *out)
{
    static const double place[3] = {0.2, -0.3, 0.2}, hook[3] = {0.8, 0.0, 0.3},
                        eye[3] = {0.5, 0.15, 0.2};
    const double degree = acos(-1.0) / 180.0;
    const mbsr_frame x = mbsr_frame_rotated(place, x_axis, 10.0 * degree),
                     y = mbsr_frame_rotated(NULL, y_axis, 55.0 * degree),
                     z = mbsr_frame_rotated(NULL, z_axis, 68.0 * degree),
                     xy = mbsr_frame_product(&x, &y), at = mbsr_frame_product(&xy, &z);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "body", MBSR_GROUND,
                                              mbsr_joint_universal(&at, NULL, z_axis, x_axis),
                                              even(1.0, 0.2, 0.0, 1.0));
    gravity_down(&s);
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, hook, body, eye, 20.0, 0.0, 0.0));
    run(&s, NULL, NULL, 2.5);
    begin(out, "Body on a universal joint and a spring at 2.5 s");
    sheet_add(out, "φ, rad", -1.17794275, s.q[0], allowed);
    sheet_add(out, "ψ, rad", -0.454818281, s.q[1], allowed);
    mbsr_simulation_end(&s);
}

/* A constant torque and force along axes that are turned by 30 degrees. */
static int constant_wrench(void *user, double t, int n, double *value)
{
    const double c = cos(acos(-1.0) / 6.0), d = 0.5;
    (void)user;
    (void)t;
    (void)n;
    value[0] = -100.0 * c - 100.0 * d;
    value[1] = -100.0 * d + 100.0 * c;
    value[3] = -1000.0 * d;
    value[4] = 1000.0 * c;
    value[2] = value[5] = 0.0;
    return MBSR_OK;
}

static void force_and_torque(sheet *out)
{
    static const double end[3] = {1.0, 0.0, 0.0};
    const mbsr_frame at = mbsr_frame_at(0.0, -0.5, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(
        &s, "body", MBSR_GROUND, mbsr_joint_universal(&at, NULL, z_axis, y_axis), rod(end, 0.05));
    gravity_down(&s);
    mbsr_simulation_add_force(&s, mbsr_force_wrench(body, end, 0, constant_wrench, NULL));
    run(&s, NULL, NULL, 0.2525);
    begin(out, "Body under a force and a torque at 0.2525 s");
    sheet_add(out, "φ, rad", 3.890643085, s.q[0], allowed);
    sheet_add(out, "ψ, rad", -0.0903338143, s.q[1], allowed);
    mbsr_simulation_end(&s);
}

void sheet_modelica(sheet *out)
{
    three_springs(out);
    spring_damper_system(out);
    free_body(out);
    pendulums(out);
    pendulum_with_spring(out);
    spring_with_mass(out);
    point_gravity(out);
    six_masses(out);
    rolling_wheel(out);
    strut(out);
    planar_four_bar(out);
    spatial_four_bar(out);
    distance_four_bar(out);
    engine(out);
    gyroscope(out);
    universal_joint(out);
    force_and_torque(out);
}
