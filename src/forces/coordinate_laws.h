/* Forces along one joint coordinate, from its q and u: the laws of the elements in joint.c, for one
 * and for many at once.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COORDINATE_LAWS_H
#define MBSRI_COORDINATE_LAWS_H

#include "forces/stock.h"

#include <stdbool.h>
#include <stddef.h>

/* MBSRI_LAW_NONE: an element of another kind. */
typedef enum mbsri_law {
    MBSRI_LAW_NONE,
    MBSRI_LAW_SPRING,
    MBSRI_LAW_STOP,
    MBSRI_LAW_FRICTION,
    MBSRI_LAWS
} mbsri_law;

mbsri_law mbsri_law_of(const mbsr_force_def *def);

enum { MBSRI_LAW_PARAMS = 4 };

/* An element that has such a law. */
typedef struct mbsri_coordinate_element {
    double param[MBSRI_LAW_PARAMS];
    int option; /* option[1] of the element */
    int q, u;   /* places of the coordinate and of its rate */
} mbsri_coordinate_element;

/* With room for `count` elements: those of each law one after the other, the first of law k at
 * first[k]. */
typedef struct mbsri_coordinate_elements {
    mbsri_coordinate_element *element;
    size_t first[MBSRI_LAWS + 1];
} mbsri_coordinate_elements;

static inline size_t mbsri_coordinate_count(const mbsri_coordinate_elements *all)
{
    return all->first[MBSRI_LAWS];
}

/* Adds the forces of all elements that are not off (one flag an element) to tau. */
void mbsri_coordinate_forces(const mbsri_coordinate_elements *all, const bool *off, const double *q,
                             const double *u, double *tau);

/* Adds their derivatives by the coordinate and by its rate, at the place of the rate. */
void mbsri_coordinate_slopes(const mbsri_coordinate_elements *all, const bool *off, const double *q,
                             const double *u, double *by_q, double *by_u);

/* ---- the laws ---- */

/* Of a force over q and u. */
typedef struct mbsri_law_slopes {
    double by_q, by_u;
} mbsri_law_slopes;

/* Spring-damper: with e = q - rest, tau = -(c e + c3 e^3 + d u). */
enum { MBSRI_SPRING_STIFFNESS, MBSRI_SPRING_DAMPING, MBSRI_SPRING_REST, MBSRI_SPRING_CUBIC };

static inline double mbsri_spring_force(const double *param, double q, double u)
{
    const double e = q - param[MBSRI_SPRING_REST];
    return -((param[MBSRI_SPRING_STIFFNESS] + param[MBSRI_SPRING_CUBIC] * e * e) * e +
             param[MBSRI_SPRING_DAMPING] * u);
}

static inline mbsri_law_slopes mbsri_spring_slopes(const double *param, double q)
{
    const double e = q - param[MBSRI_SPRING_REST];
    return (mbsri_law_slopes){-param[MBSRI_SPRING_STIFFNESS] -
                                  3.0 * param[MBSRI_SPRING_CUBIC] * e * e,
                              -param[MBSRI_SPRING_DAMPING]};
}

/* Stops: one-sided spring-dampers beyond two positions. */
enum { MBSRI_STOP_LOWER, MBSRI_STOP_UPPER, MBSRI_STOP_STIFFNESS, MBSRI_STOP_DAMPING };
enum { MBSRI_HAS_LOWER = 1, MBSRI_HAS_UPPER = 2 }; /* an infinite stop is none */

/* Depth beyond the stop that is passed, 0 between the two; q grows into the stop for *side = 1, out
 * of it for -1. */
static inline double mbsri_stop_depth(const double *param, int stops, double q, double *side)
{
    *side = 1.0;
    if ((stops & MBSRI_HAS_UPPER) && q > param[MBSRI_STOP_UPPER])
        return q - param[MBSRI_STOP_UPPER];
    *side = -1.0;
    if ((stops & MBSRI_HAS_LOWER) && q < param[MBSRI_STOP_LOWER])
        return param[MBSRI_STOP_LOWER] - q;
    return 0.0;
}

static inline double mbsri_stop_force(const double *param, int stops, double q, double u)
{
    double side;
    const double elastic = param[MBSRI_STOP_STIFFNESS] * mbsri_stop_depth(param, stops, q, &side);
    return -side * mbsri_one_sided(elastic, param[MBSRI_STOP_DAMPING] * side * u);
}

/* None between the stops. */
static inline mbsri_law_slopes mbsri_stop_slopes(const double *param, int stops, double q, double u)
{
    double side, by_elastic, by_damping;
    const double elastic = param[MBSRI_STOP_STIFFNESS] * mbsri_stop_depth(param, stops, q, &side);
    if (!(elastic > 0.0)) return (mbsri_law_slopes){0.0, 0.0};
    mbsri_one_sided_slopes(elastic, param[MBSRI_STOP_DAMPING] * side * u, &by_elastic, &by_damping);
    return (mbsri_law_slopes){-by_elastic * param[MBSRI_STOP_STIFFNESS],
                              -by_damping * param[MBSRI_STOP_DAMPING]};
}

/* Friction: tau = -force u / sqrt(u^2 + slip^2). */
enum { MBSRI_FRICTION_FORCE, MBSRI_FRICTION_SLIP };

static inline double mbsri_friction_force(const double *param, double u)
{
    return -param[MBSRI_FRICTION_FORCE] * u / hypot(u, param[MBSRI_FRICTION_SLIP]);
}

/* force slip^2 / (u^2 + slip^2)^(3/2) */
static inline mbsri_law_slopes mbsri_friction_slopes(const double *param, double u)
{
    const double speed = hypot(u, param[MBSRI_FRICTION_SLIP]),
                 ratio = param[MBSRI_FRICTION_SLIP] / speed;
    return (mbsri_law_slopes){0.0, -param[MBSRI_FRICTION_FORCE] * ratio * ratio / speed};
}

#endif
