/* Contact of a sphere with a plane: normal force of Hunt and Crossley, smooth Coulomb friction.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

#include "../space3.h"
#include "marker.h"

#include <string.h>

enum {
    CENTRE,
    POINT = 3,
    NORMAL = 6, /* of unit length, unless what was given is zero or not finite */
    RADIUS = 9,
    STIFFNESS,
    DAMPING,
    FRICTION,
    EXPONENT,
    SLIP
};

typedef struct touch {
    mbsri_marker a, b;     /* the points of both bodies where the sphere is deepest */
    double normal[3];      /* along the world axes */
    double x, rate;        /* depth and its rate */
    double sliding[3];     /* velocity of a against b along the plane */
    double elastic, force; /* parts of N: stiffness x^exponent; N itself */
    double drag;           /* friction force = -drag sliding */
} touch;

/* Whether there is contact; the rest only then. With the velocity v of a against b at the deepest
 * point, x' = -n . v. */
static bool locate(const mbsr_force_args *args, touch *w)
{
    const double *param = args->force->param;
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    mbsri_marker plane;
    double R[9], deepest[3];
    mbsri_marker_on(a, param + CENTRE, &w->a);
    mbsri_marker_on(b, param + POINT, &plane);
    mbsri_body_axes(b, R);
    mbsri_rotate3(R, param + NORMAL, w->normal);
    double distance = 0.0;
    for (int k = 0; k < 3; ++k) distance += w->normal[k] * (w->a.x[k] - plane.x[k]);
    w->x = param[RADIUS] - distance;
    if (!(w->x > 0.0)) return false;
    for (int k = 0; k < 3; ++k) deepest[k] = w->a.x[k] - param[RADIUS] * w->normal[k];
    mbsri_marker_at(a, deepest, &w->a);
    mbsri_marker_at(b, deepest, &w->b);
    for (int k = 0; k < 3; ++k) w->sliding[k] = w->a.v[k] - w->b.v[k];
    w->rate = -mbsri_dot3(w->normal, w->sliding);
    mbsri_add3(w->rate, w->normal, w->sliding);
    w->elastic = param[STIFFNESS] * pow(w->x, param[EXPONENT]);
    w->force = w->elastic * fmax(0.0, 1.0 + param[DAMPING] * w->rate);
    w->drag = 0.0;
    if (param[FRICTION] > 0.0)
        w->drag = param[FRICTION] * w->force / hypot(mbsri_norm3(w->sliding), param[SLIP]);
    return true;
}

static int evaluate(const mbsr_force_args *args)
{
    touch w;
    if (!locate(args, &w)) return MBSR_OK;
    double force[3] = {0.0, 0.0, 0.0};
    mbsri_add3(w.force, w.normal, force);
    mbsri_add3(-w.drag, w.sliding, force);
    mbsri_push(args->body, &w.a, 1.0, force, NULL);
    mbsri_push(args->body + 1, &w.b, -1.0, force, NULL);
    return MBSR_OK;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    touch w;
    if (locate(args, &w)) *energy_out += w.elastic * w.x / (args->force->param[EXPONENT] + 1.0);
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    touch w;
    if (locate(args, &w)) {
        *power += (w.force - w.elastic) * w.rate + w.drag * mbsri_dot3(w.sliding, w.sliding);
    }
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    int status = mbsri_check_spatial(args, 0, 0, text);
    if (!status) status = mbsri_check_spatial(args, 1, 1, text);
    if (!status) status = mbsri_check_ends(args, text);
    if (!status) status = mbsri_check_not_negative(args, STIFFNESS, 3, text);
    if (status) return status;
    if (mbsri_norm3(param + NORMAL) == 0.0)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "normal is (0, 0, 0)");
    if (!(param[RADIUS] > 0.0)) return mbsri_refuse_parameter(text, args, RADIUS, "not positive");
    if (!(param[EXPONENT] >= 1.0))
        return mbsri_refuse_parameter(text, args, EXPONENT, "must be at least 1");
    if (param[FRICTION] > 0.0 && !(param[SLIP] > 0.0))
        return mbsri_refuse_parameter(text, args, SLIP, "not positive");
    return MBSR_OK;
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (centre[0])", " (centre[1])", " (centre[2])", " (point[0])",  " (point[1])",
        " (point[2])",  " (normal[0])", " (normal[1])", " (normal[2])", " (radius)",
        " (stiffness)", " (damping)",   " (friction)",  " (exponent)",  " (slip)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table contact_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS,
    .name = "contact",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .parameter = parameter,
};

/* Scaled by its largest entry first, so that no square overflows or vanishes. */
static void store_normal(const double normal[3], double unit[3])
{
    const double largest = mbsri_largest(3, normal);
    memcpy(unit, normal, 3 * sizeof *unit);
    if (!(largest > 0.0) || !isfinite(largest)) return;
    for (int k = 0; k < 3; ++k) unit[k] /= largest;
    const double length = mbsri_norm3(unit);
    for (int k = 0; k < 3; ++k) unit[k] /= length;
}

mbsr_force_def mbsr_force_contact(int a, int b, const mbsr_contact *contact)
{
    mbsr_force_def def = mbsri_stock_force(&contact_table, 2, a, b);
    memcpy(def.param + CENTRE, contact->centre, sizeof contact->centre);
    memcpy(def.param + POINT, contact->point, sizeof contact->point);
    store_normal(contact->normal, def.param + NORMAL);
    def.param[RADIUS] = contact->radius;
    def.param[STIFFNESS] = contact->stiffness;
    def.param[DAMPING] = contact->damping;
    def.param[FRICTION] = contact->friction;
    def.param[EXPONENT] = contact->exponent;
    def.param[SLIP] = contact->slip;
    return def;
}
