/* Mechanisms closed by stiff springs.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

#include <math.h>

static const mbsr_planar_frame here = {0.0, 0.0, 0.0};

/* ---- slider-crank: crank 0.2 m, 2 kg; rod 0.6 m, 1 kg; slider 1.5 kg on the x axis ---- */

static const double crank = 0.2, coupler = 0.6, phi = 1.0;

static double rod_angle(void)
{
    return -asin(crank * sin(phi) / coupler);
}

static double slide(void)
{
    return crank * cos(phi) + coupler * cos(rod_angle());
}

/* Cut at the pin of rod and slider. */
static void slider_crank(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(2, crank));
    const int b = part_body(m, "rod", a, mbsr_joint_planar_revolute(part_along(crank), here),
                            part_rod(1, coupler));
    const int c = part_body(m, "slider", MBSR_GROUND, mbsr_joint_planar_prismatic(here, here),
                            mbsr_inertia_particle(1.5));
    part_fall(m);
    part_pin(m, ties, b, coupler, c, 0.0);
    q[0] = phi, q[1] = rod_angle() - phi, q[2] = slide();
    (void)u;
}

/* Cut at the rail: the slider, a particle at the end of the rod, is held on the x axis. */
static void rail(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double up[3] = {0.0, 1.0, 0.0};
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(2, crank));
    const int b = part_body(m, "rod", a, mbsr_joint_planar_revolute(part_along(crank), here),
                            part_rod(1, coupler));
    const int c = part_body(m, "slider", b, mbsr_joint_point(part_along(coupler), 0, 0, NULL, NULL),
                            mbsr_inertia_particle(1.5));
    part_fall(m);
    if (ties->closures)
        part_close(m, ties, mbsr_closure_rows(c, NULL, MBSR_GROUND, NULL, 1, up), 1);
    else
        part_force(m,
                   mbsr_force_axis_spring(c, MBSR_GROUND, 1, ties->stiffness, ties->damping, 0.0));
    q[0] = phi, q[1] = rod_angle() - phi;
    (void)u;
}

/* Cut at the main bearing. */
static void main_bearing(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const int a = part_body(m, "slider", MBSR_GROUND, mbsr_joint_planar_prismatic(here, here),
                            mbsr_inertia_particle(1.5));
    const int b = part_body(m, "rod", a, mbsr_joint_planar_revolute(here, part_along(coupler)),
                            part_rod(1, coupler));
    const int c = part_body(m, "crank", b, mbsr_joint_planar_revolute(here, part_along(crank)),
                            part_rod(2, crank));
    part_fall(m);
    part_pin(m, ties, c, 0.0, MBSR_GROUND, 0.0);
    q[0] = slide(), q[1] = rod_angle(), q[2] = phi - rod_angle();
    (void)u;
}

/* All three pins are springs. */
static void all_pins(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const int a =
        part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_free(here, here), part_rod(2, crank));
    const int b =
        part_body(m, "rod", MBSR_GROUND, mbsr_joint_planar_free(here, here), part_rod(1, coupler));
    const int c = part_body(m, "slider", MBSR_GROUND, mbsr_joint_planar_prismatic(here, here),
                            mbsr_inertia_particle(1.5));
    part_fall(m);
    part_pin(m, ties, a, 0.0, MBSR_GROUND, 0.0);
    part_pin(m, ties, a, crank, b, 0.0);
    part_pin(m, ties, b, coupler, c, 0.0);
    q[2] = phi, q[5] = rod_angle(), q[6] = slide();
    q[3] = crank * cos(phi), q[4] = crank * sin(phi);
    (void)u;
}

/* ---- others ---- */

/* Crank 1 m, coupler 2.5 m, rocker 2 m, ground 2 m. */
static void four_bar(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double start = 1.2, dx = cos(start) - 2.0, dy = sin(start), d = hypot(dx, dy);
    const double rocker = atan2(dy, dx) - acos((4.0 + d * d - 6.25) / (4.0 * d));
    const double tip_x = 2.0 + 2.0 * cos(rocker), tip_y = 2.0 * sin(rocker);
    const int a =
        part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here), part_rod(1, 1));
    const int b = part_body(m, "coupler", a, mbsr_joint_planar_revolute(part_along(1), here),
                            part_rod(2.5, 2.5));
    const int c = part_body(m, "rocker", MBSR_GROUND,
                            mbsr_joint_planar_revolute(part_along(2), here), part_rod(2, 2));
    part_fall(m);
    part_pin(m, ties, b, 2.5, c, 2.0);
    q[0] = start, q[1] = atan2(tip_y - sin(start), tip_x - cos(start)) - start, q[2] = rocker;
    (void)u;
}

/* Eight particles of 0.1 kg at distances of 0.2 m swing down from a horizontal line. */
static void rope(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    enum { PARTICLES = 8 };
    const double length = 0.2;
    int before = MBSR_GROUND;
    for (int k = 0; k < PARTICLES; ++k) {
        const int next = part_body(m, "particle", MBSR_GROUND, mbsr_joint_point_free(),
                                   mbsr_inertia_particle(0.1));
        if (ties->closures)
            part_close(m, ties, mbsr_closure_distance(before, NULL, next, NULL, length), 1);
        else
            part_force(m, mbsr_force_point_spring(before, NULL, next, NULL, ties->stiffness,
                                                  ties->damping, length));
        q[2 * k] = length * (k + 1);
        before = next;
    }
    part_fall(m);
    (void)u;
}

static int turn(void *user, double t, double *s, double *rate, double *acceleration)
{
    (void)user;
    *s = 10.0 * t, *rate = 10.0, *acceleration = 0.0;
    return MBSR_OK;
}

/* Two shafts at an angle of 0.5 rad, of examples/13_universal_joint.c; the bearing of the second is
 * held. */
static void shaft(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, tilt = 0.5;
    const double s = ties->stiffness, d = ties->damping, moments[6] = {0.03, 0.03, 0.05};
    const double place[3] = {0, -0.4 * sin(tilt), 0.4 * cos(tilt)}, com[3] = {0, 0, 0};
    const double rubber[6] =
        {10, 10, 10, ties->closures ? 0 : s, ties->closures ? 0 : s, ties->closures ? 0 : s},
                 loss[6] = {0.1,
                            0.1,
                            0.1,
                            ties->closures ? 0 : d,
                            ties->closures ? 0 : d,
                            ties->closures ? 0 : d};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_frame on_shaft = mbsr_frame_at(0, 0, 0.4),
                     tilted = mbsr_frame_rotated(NULL, x, tilt),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    const int a =
        part_body(m, "shaft 1", MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL),
                  mbsr_inertia_zero());
    const int b = part_body(m, "shaft 2", a, mbsr_joint_universal(NULL, NULL, x, y),
                            mbsr_inertia_rigid(4.0, com, moments));
    const int c =
        part_body(m, "bearing", b, mbsr_joint_revolute(&on_shaft, NULL, z), mbsr_inertia_zero());
    part_force(m, mbsr_force_bushing(MBSR_GROUND, &on_ground, c, NULL, rubber, loss));
    /* along the shaft nothing can move: a row there would be redundant */
    const double across[6] = {1, 0, 0, 0, cos(tilt), sin(tilt)};
    if (ties->closures && ties->stiffness > 0.0) /* the start is closed */
        part_close(m, ties, mbsr_closure_rows(c, NULL, MBSR_GROUND, place, 2, across), 2);
    q[0] = tilt;
    u[1] = -10.0 * sin(tilt), u[2] = -10.0 * cos(tilt);
}

/* The suspension of examples/20_double_wishbone.c, falling onto its tyre: the upper ball joint is a
 * bushing, the tie rod a spring. */
static void wishbone(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double x[3] = {1.0, 0.05, 0.0}, slant[3] = {1.0, 0.0, 0.03}, none[3] = {0.0},
                 tensor[6] = {1.2, 1.8, 1.2, 0.0, 0.0, 0.0};
    const mbsr_frame lower_axis = mbsr_frame_at(0.0, 0.30, 0.20),
                     upper_axis = mbsr_frame_at(-0.02, 0.38, 0.46),
                     lower_ball = mbsr_frame_at(0.0, 0.40, 0.0),
                     below = mbsr_frame_at(0.01, -0.05, -0.10);
    const double end[3] = {0.0, 0.26, 0.0}, above[3] = {-0.01, -0.11, 0.16},
                 arm[3] = {-0.12, -0.06, -0.02}, rack[3] = {-0.13, 0.33, 0.28},
                 seat[3] = {0.0, 0.25, 0.02}, top[3] = {0.0, 0.48, 0.65},
                 road[3] = {0.0, 0.8, -3.0};
    const double s = ties->stiffness, d = ties->damping, rubber[6] = {0, 0, 0, s, s, s},
                 loss[6] = {0, 0, 0, d, d, d};
    const mbsr_frame on_upper = mbsr_frame_at(end[0], end[1], end[2]),
                     on_knuckle = mbsr_frame_at(above[0], above[1], above[2]);
    const int lower = part_body(m, "lower wishbone", MBSR_GROUND,
                                mbsr_joint_revolute(&lower_axis, NULL, x), mbsr_inertia_zero());
    const int upper = part_body(m, "upper wishbone", MBSR_GROUND,
                                mbsr_joint_revolute(&upper_axis, NULL, slant), mbsr_inertia_zero());
    const int knuckle = part_body(m, "knuckle", lower, mbsr_joint_spherical(&lower_ball, &below),
                                  mbsr_inertia_rigid(40.0, none, tensor));
    part_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    part_force(m, mbsr_force_point_spring(lower, seat, MBSR_GROUND, top, 4e4, 2.5e3, 0.55));
    part_force(m, mbsr_force_point_spring(knuckle, NULL, MBSR_GROUND, road, 2e5, 300.0, 3.25));
    if (ties->closures) {
        part_close(m, ties, mbsr_closure_ball(upper, end, knuckle, above), 3);
        part_close(m, ties, mbsr_closure_distance(knuckle, arm, MBSR_GROUND, rack, 0.36), 1);
    } else {
        part_force(m, mbsr_force_bushing(upper, &on_upper, knuckle, &on_knuckle, rubber, loss));
        part_force(m, mbsr_force_point_spring(knuckle, arm, MBSR_GROUND, rack, s, d, 0.36));
    }
    q[2] = 1.0;
    (void)u;
}

const mechanism mechanisms[] = {{"slider_crank", slider_crank, 3.0, 0.3, 1},
                                {"rail", rail, 3.0, 1.5, 1},
                                {"main_bearing", main_bearing, 3.0, 0.5, 1},
                                {"all_pins", all_pins, 3.0, 0.3, 1},
                                {"four_bar", four_bar, 2.0, 0.5, 1},
                                {"rope", rope, 0.8, 0.05, 1},
                                {"shaft", shaft, 1.0, 0.2, 0},
                                {"wishbone", wishbone, 1.0, 10.0, 0},
                                {NULL, NULL, 0.0, 0.0, 0}};
