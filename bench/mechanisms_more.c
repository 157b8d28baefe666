/* More mechanisms closed by stiff springs: bushings in the plane and in space, springs in series
 * and as rods, stops, and the end of a chain.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

#include <math.h>

static const mbsr_planar_frame here = {0.0, 0.0, 0.0};

/* ---- in the plane ---- */

/* Crank 1 m, coupler 2.5 m, rocker 2 m, ground 2 m: angles of rocker and coupler at one of the
 * crank. */
static double rocker_angle(double crank)
{
    const double dx = cos(crank) - 2.0, dy = sin(crank), d = hypot(dx, dy);
    return atan2(dy, dx) - acos((4.0 + d * d - 6.25) / (4.0 * d));
}

static double coupler_angle(double crank)
{
    const double rocker = rocker_angle(crank);
    return atan2(2.0 * sin(rocker) - sin(crank), 2.0 + 2.0 * cos(rocker) - cos(crank));
}

static const double start = 1.2;

/* The pin of coupler and rocker is a bushing, twice as stiff one way as the other. */
static void bushed_four_bar(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double s = ties->stiffness, d = ties->damping,
                 rubber[9] = {s, 0.25 * s, 0.0, 0.25 * s, 0.5 * s, 0.0, 0.0, 0.0, 0.0},
                 loss[9] = {d, 0.25 * d, 0.0, 0.25 * d, 0.5 * d, 0.0, 0.0, 0.0, 0.0};
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(1.0, 1.0));
    const int b = part_body(m, "coupler", a, mbsr_joint_planar_revolute(part_along(1.0), here),
                            part_rod(2.5, 2.5));
    const int c = part_body(m, "rocker", MBSR_GROUND,
                            mbsr_joint_planar_revolute(part_along(2.0), here), part_rod(2.0, 2.0));
    part_fall(m);
    part_tie(m, ties,
             mbsr_force_planar_bushing(b, part_along(2.5), c, part_along(2.0), rubber, loss));
    q[0] = start, q[1] = coupler_angle(start) - start, q[2] = rocker_angle(start);
    (void)u;
}

/* The coupler is a spring without mass. */
static void strut(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double end_a[3] = {1.0, 0.0, 0.0}, end_b[3] = {2.0, 0.0, 0.0};
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(1.0, 1.0));
    const int b = part_body(m, "rocker", MBSR_GROUND,
                            mbsr_joint_planar_revolute(part_along(2.0), here), part_rod(2.0, 2.0));
    part_fall(m);
    part_tie(m, ties,
             mbsr_force_point_spring(a, end_a, b, end_b, ties->stiffness, ties->damping, 2.5));
    q[0] = start, q[1] = rocker_angle(start);
    (void)u;
}

/* A slider-crank whose rod and slider are tied to a point without mass between them. */
static void series(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double crank = 0.2, rod = 0.6, phi = 1.0, beta = -asin(crank * sin(phi) / rod);
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(2.0, crank));
    const int b = part_body(m, "rod", a, mbsr_joint_planar_revolute(part_along(crank), here),
                            part_rod(1.0, rod));
    const int c = part_body(m, "slider", MBSR_GROUND, mbsr_joint_planar_prismatic(here, here),
                            mbsr_inertia_particle(1.5));
    const mbsr_joint point = mbsr_joint_point(part_along(rod), 0, 0, NULL, NULL),
                     pin = mbsr_joint_point(here, 0, 0, NULL, NULL);
    const int tip = part_body(m, "tip", b, point, mbsr_inertia_zero()),
              end = part_body(m, "end", c, pin, mbsr_inertia_zero()),
              between = part_body(m, "between", MBSR_GROUND, mbsr_joint_point_free(),
                                  mbsr_inertia_zero());
    part_fall(m);
    for (int i = 0; i < 2; ++i) {
        const double s = ties->stiffness, d = ties->damping;
        part_tie(m, ties, mbsr_force_axis_spring(tip, between, i, s, d, 0.0));
        part_tie(m, ties, mbsr_force_axis_spring(between, end, i, 0.7 * s, 0.7 * d, 0.0));
    }
    q[0] = phi, q[1] = beta - phi, q[2] = crank * cos(phi) + rod * cos(beta);
    q[3] = q[2], q[4] = 0.0;
    (void)u;
}

/* Two rods fall from the horizontal; the knee bends by 1 rad one way and not the other. */
static void knee(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const int a = part_body(m, "thigh", MBSR_GROUND, mbsr_joint_planar_revolute(here, here),
                            part_rod(1.0, 0.5));
    const int b = part_body(m, "shank", a, mbsr_joint_planar_revolute(part_along(0.5), here),
                            part_rod(1.0, 0.5));
    part_fall(m);
    if (ties->stiffness > 0.0)
        part_force(m, mbsr_force_joint_stop(b, 0, -1.0, 0.0, ties->stiffness, ties->damping));
    q[1] = -0.5;
    (void)u;
}

enum { LINKS = 12 };

/* Twelve rods of 0.1 m in an arch over 0.8 m, the end pinned by springs. */
static void arch(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    double low = 1e-3, high = 0.5;
    int before = MBSR_GROUND;
    for (int k = 0; k < LINKS; ++k)
        before = part_body(m, "link", before,
                           mbsr_joint_planar_revolute(part_along(k > 0 ? 0.1 : 0.0), here),
                           part_rod(0.1, 0.1));
    part_fall(m);
    part_pin(m, ties, before, 0.1, MBSR_GROUND, 0.8);
    for (int k = 0; k < 60; ++k) {
        const double bend = 0.5 * (low + high);
        const double chord = 0.1 * sin(0.5 * LINKS * bend) / sin(0.5 * bend);
        *(chord > 0.8 ? &low : &high) = bend;
    }
    q[0] = 0.5 * (LINKS - 1) * low;
    for (int k = 1; k < LINKS; ++k) q[k] = -low;
    u[0] = 1e-3;
}

/* ---- in space ---- */

/* Two bars that hang off the vertical, on bushings: balls, or hinges where turns are stiff as well.
 */
static void hang(mbsr_model *m, const mechanism_ties *ties, double turn, double *q, double *u)
{
    const double s = ties->stiffness, d = ties->damping, tilt = -0.8,
                 rubber[6] = {turn * s, turn * s, 0.0, s, s, s},
                 loss[6] = {turn * d, turn * d, 0.0, d, d, d};
    const mbsr_frame end = mbsr_frame_at(0.5, 0.0, 0.0);
    const int a = part_body(m, "upper", MBSR_GROUND, mbsr_joint_free(NULL, NULL), part_bar(2, 0.5));
    const int b = part_body(m, "lower", MBSR_GROUND, mbsr_joint_free(NULL, NULL), part_bar(1, 0.4));
    part_fall(m);
    part_tie(m, ties, mbsr_force_bushing(MBSR_GROUND, NULL, a, NULL, rubber, loss));
    part_tie(m, ties, mbsr_force_bushing(a, &end, b, NULL, rubber, loss));
    for (int k = 0; k < 2; ++k) q[7 * k] = cos(0.5 * tilt), q[7 * k + 3] = sin(0.5 * tilt);
    q[11] = 0.5 * cos(tilt), q[12] = 0.5 * sin(tilt);
    if (turn > 0.0) return;
    u[1] = u[7] = 2.0; /* about the vertical */
    u[11] = -2.0 * q[11];
}

static void balls(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    hang(m, ties, 0.0, q, u);
}

static void hinges(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    hang(m, ties, 0.01, q, u);
}

/* Crank 0.2 m about z, rod 0.6 m, slider along x at z = 0.1 m; rod and slider held by a bushing. */
static void crank_in_space(mbsr_model *m, const mechanism_ties *ties, double *q, double *u)
{
    const double z[3] = {0.0, 0.0, 1.0}, x[3] = {1.0, 0.0, 0.0}, phi = 1.0, crank = 0.2, rod = 0.6,
                 beside = 0.1, up = crank * sin(phi), s = ties->stiffness, d = ties->damping,
                 ahead = sqrt(rod * rod - up * up - beside * beside),
                 rubber[6] = {0.0, 0.0, 0.0, s, s, s}, loss[6] = {0.0, 0.0, 0.0, d, d, d},
                 soft[6] = {0.01, 0.01, 0.01}, little[6] = {1e-3, 1e-3, 1e-3};
    const mbsr_frame tip = mbsr_frame_at(crank, 0.0, 0.0), end = mbsr_frame_at(rod, 0.0, 0.0),
                     rail = mbsr_frame_at(0.0, 0.0, beside);
    const int a = part_body(m, "crank", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                            part_bar(2.0, crank));
    const int b = part_body(m, "rod", a, mbsr_joint_spherical(&tip, NULL), part_bar(1.0, rod));
    const int c = part_body(m, "slider", MBSR_GROUND, mbsr_joint_prismatic(&rail, NULL, x),
                            part_bar(1.5, 0.1));
    part_fall(m);
    part_tie(m, ties, mbsr_force_bushing(b, &end, c, NULL, rubber, loss));
    part_force(m, mbsr_force_bushing(b, &end, c, NULL, soft, little));
    /* the rod in space turns x to (ahead, -up, beside) / rod */
    const double w = 1.0 + ahead / rod, j = -beside / rod, k = -up / rod,
                 n = sqrt(w * w + j * j + k * k), C = cos(0.5 * phi) / n, S = -sin(0.5 * phi) / n;
    q[0] = phi;
    q[1] = C * w - S * k, q[2] = -S * j, q[3] = C * j, q[4] = C * k + S * w;
    q[5] = crank * cos(phi) + ahead;
    (void)u;
}

const mechanism mechanisms_more[] = {{"bushed_four_bar", bushed_four_bar, 2.0, 0.5, 1},
                                     {"strut", strut, 2.0, 0.4, 1},
                                     {"series", series, 2.0, 0.3, 1},
                                     {"knee", knee, 1.0, 0.05, 1},
                                     {"arch", arch, 0.5, 0.05, 1},
                                     {"balls", balls, 1.5, 0.3, 1},
                                     {"hinges", hinges, 1.5, 0.3, 1},
                                     {"crank_in_space", crank_in_space, 2.0, 0.3, 1},
                                     {NULL, NULL, 0.0, 0.0, 0}};
