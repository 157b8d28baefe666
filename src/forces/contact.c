/* Contact of a sphere with a plane: normal force of Hunt and Crossley, smooth Coulomb friction.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/contact.h"

#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/slopes.h"
#include "forces/stock.h"

#include <math.h>
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
    SLIP,
    CREEP
};

typedef struct touch {
    double centre[3];      /* arm of the sphere's centre on a */
    mbsri_marker plane;    /* the point of the plane */
    mbsri_marker a, b;     /* the points of both bodies where the sphere is deepest */
    double normal[3];      /* along the world axes */
    double x, rate;        /* depth and its rate */
    double sliding[3];     /* velocity of a against b along the plane */
    double travel[3];      /* that of the centre, if there is creep */
    double elastic, force; /* parts of N: stiffness x^exponent; N itself */
    double speed, drag;    /* friction force = -drag sliding, drag = friction N / speed */
} touch;

/* The root of |sliding|^2 + slip^2 + creep^2 |travel|^2, where the centre of a has the velocity v.
 */
static void find_speed(const double *param, const double v[3], touch *w)
{
    w->speed = hypot(mbsri_norm3(w->sliding), param[SLIP]);
    if (!(param[CREEP] > 0.0)) return;
    for (int k = 0; k < 3; ++k) w->travel[k] = v[k] - w->b.v[k];
    mbsri_add3(-mbsri_dot3(w->normal, w->travel), w->normal, w->travel);
    w->speed = hypot(w->speed, param[CREEP] * mbsri_norm3(w->travel));
}

/* Whether there is contact; the rest only then. With the velocity v of a against b at the deepest
 * point, x' = -n . v. */
static bool find_contact(const mbsr_force_args *args, touch *w)
{
    const double *param = args->force->param;
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    double R[9], deepest[3], v[3];
    mbsri_marker_on(a, param + CENTRE, &w->a);
    mbsri_marker_on(b, param + POINT, &w->plane);
    memcpy(w->centre, w->a.arm, sizeof w->centre);
    memcpy(v, w->a.v, sizeof v);
    mbsri_body_axes(b, R);
    mbsri_rotate3(R, param + NORMAL, w->normal);
    double distance = 0.0;
    for (int k = 0; k < 3; ++k) distance += w->normal[k] * (w->a.x[k] - w->plane.x[k]);
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
    if (!(param[FRICTION] > 0.0)) return true;
    find_speed(param, v, w);
    w->drag = param[FRICTION] * w->force / w->speed;
    return true;
}

static int evaluate(const mbsr_force_args *args)
{
    touch w;
    if (!find_contact(args, &w)) return MBSR_OK;
    double force[3] = {0.0, 0.0, 0.0};
    mbsri_add3(w.force, w.normal, force);
    mbsri_add3(-w.drag, w.sliding, force);
    mbsri_push(args->body, &w.a, 1.0, force, NULL);
    mbsri_push(args->body + 1, &w.b, -1.0, force, NULL);
    return MBSR_OK;
}

/* Derivatives of what locate finds. */
typedef struct touch_slopes {
    mbsri_vector normal[MBSRI_MAX_COLUMNS], sliding[MBSRI_MAX_COLUMNS], travel[MBSRI_MAX_COLUMNS];
    mbsri_vector arm_a[MBSRI_MAX_COLUMNS], arm_b[MBSRI_MAX_COLUMNS];
    double x[MBSRI_MAX_COLUMNS], rate[MBSRI_MAX_COLUMNS];
} touch_slopes;

/* The deepest point is x_c - radius n, the distance n . (x_c - x_p) with the centre x_c and a point
 * x_p of the plane. */
static void locate_slopes(const mbsri_columns *c, const double *param, const touch *w,
                          touch_slopes *d)
{
    const double radius = param[RADIUS], creep = param[CREEP];
    mbsri_vector dx[MBSRI_MAX_COLUMNS] = {{{0.0}}}, dplane[MBSRI_MAX_COLUMNS] = {{{0.0}}};
    double apart[3]; /* x_c - x_p = (distance) n + a vector along the plane */
    for (int r = 0; r < 3; ++r) apart[r] = w->a.x[r] + radius * w->normal[r] - w->plane.x[r];
    memset(d, 0, sizeof *d);
    mbsri_add_turn(c, 1, MBSRI_POSE, 1.0, w->normal, d->normal);
    mbsri_add_turn(c, 0, MBSRI_POSE, 1.0, w->centre, dx);
    if (creep > 0.0) mbsri_add_velocity(c, 0, 1.0, w->centre, dx, d->travel);
    mbsri_add_shift(c, 0, MBSRI_POSE, 1.0, dx);
    mbsri_add_turn(c, 1, MBSRI_POSE, 1.0, w->plane.arm, dplane);
    mbsri_add_shift(c, 1, MBSRI_POSE, 1.0, dplane);
    for (int l = 0; l < c->count; ++l) {
        d->x[l] = mbsri_dot3(w->normal, dplane[l].x) - mbsri_dot3(w->normal, dx[l].x) -
                  mbsri_dot3(d->normal[l].x, apart);
        mbsri_add3(-radius, d->normal[l].x, dx[l].x);
    }
    memcpy(d->arm_a, dx, sizeof dx);
    memcpy(d->arm_b, dx, sizeof dx);
    mbsri_add_shift(c, 0, MBSRI_POSE, -1.0, d->arm_a);
    mbsri_add_shift(c, 1, MBSRI_POSE, -1.0, d->arm_b);
    mbsri_add_velocity(c, 0, 1.0, w->a.arm, d->arm_a, d->sliding);
    mbsri_add_velocity(c, 1, -1.0, w->b.arm, d->arm_b, d->sliding);
    if (creep > 0.0) mbsri_add_velocity(c, 1, -1.0, w->b.arm, d->arm_b, d->travel);
    /* so far of v = sliding - x' n, and n . sliding = 0 */
    for (int l = 0; l < c->count; ++l) {
        d->rate[l] =
            -mbsri_dot3(w->normal, d->sliding[l].x) - mbsri_dot3(d->normal[l].x, w->sliding);
        mbsri_add3(d->rate[l], w->normal, d->sliding[l].x);
        mbsri_add3(w->rate, d->normal[l].x, d->sliding[l].x);
    }
}

/* That of speed. Of the velocity of the centre only what is along the plane matters: travel is
 * normal to n, and n . v of that velocity, which turns with n, is -x'. */
static double speed_slope(const touch *w, double creep, const mbsri_vector *dsliding,
                          const mbsri_vector *dtravel, const mbsri_vector *dnormal)
{
    double sum = mbsri_dot3(w->sliding, dsliding->x);
    if (creep > 0.0) {
        sum += creep * creep *
               (mbsri_dot3(w->travel, dtravel->x) + w->rate * mbsri_dot3(w->travel, dnormal->x));
    }
    return sum / w->speed;
}

/* N n - drag sliding with drag = friction N / speed */
static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    const double *param = args->force->param;
    mbsri_vector dforce[MBSRI_MAX_COLUMNS] = {{{0.0}}};
    double force[3] = {0.0, 0.0, 0.0};
    touch w;
    touch_slopes d;
    if (!find_contact(args, &w) || !(w.force > 0.0)) return MBSR_OK;
    locate_slopes(&c, param, &w, &d);
    mbsri_add3(w.force, w.normal, force);
    mbsri_add3(-w.drag, w.sliding, force);
    const double by_x = param[EXPONENT] * w.force / w.x, by_rate = w.elastic * param[DAMPING];
    for (int l = 0; l < c.count; ++l) {
        const double dN = by_x * d.x[l] + by_rate * d.rate[l];
        mbsri_add3(dN, w.normal, dforce[l].x);
        mbsri_add3(w.force, d.normal[l].x, dforce[l].x);
        if (!(param[FRICTION] > 0.0)) continue;
        const double ddrag =
            param[FRICTION] * dN / w.speed -
            w.drag / w.speed *
                speed_slope(&w, param[CREEP], d.sliding + l, d.travel + l, d.normal + l);
        mbsri_add3(-ddrag, w.sliding, dforce[l].x);
        mbsri_add3(-w.drag, d.sliding[l].x, dforce[l].x);
    }
    mbsri_push_slopes(&c, 0, 1.0, w.a.arm, force, d.arm_a, dforce, NULL);
    mbsri_push_slopes(&c, 1, -1.0, w.b.arm, force, d.arm_b, dforce, NULL);
    return MBSR_OK;
}

/* Of an exponent above 1 the derivatives are continuous where contact begins, theirs are not. */
static double touch_side(const mbsr_force_args *args)
{
    touch w;
    if (!find_contact(args, &w)) return 0.0;
    return w.force > 0.0 ? 1.0 : 2.0;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    touch w;
    if (find_contact(args, &w))
        *energy_out += w.elastic * w.x / (args->force->param[EXPONENT] + 1.0);
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    touch w;
    if (find_contact(args, &w)) {
        *power += (w.force - w.elastic) * w.rate + w.drag * mbsri_dot3(w.sliding, w.sliding);
    }
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    if (args->body->id == MBSR_GROUND)
        return mbsri_refuse(text, MBSR_ERR_ID, "the sphere is on the ground");
    int status = mbsri_check_marker(args, 0, param + CENTRE, "centre", text);
    if (!status) status = mbsri_check_marker(args, 1, param + POINT, "point", text);
    if (!status) status = mbsri_check_ends(args, text);
    if (!status) status = mbsri_check_not_negative(args, STIFFNESS, 3, text);
    if (!status) status = mbsri_check_not_negative(args, CREEP, 1, text);
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

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 2, 0, text);
    if (status) return status;
    const double length = mbsri_norm3(def->param + NORMAL);
    if (length == 0.0 || fabs(length - 1.0) < 1e-9) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "normal has length %g, must be 1", length);
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (centre[0])", " (centre[1])", " (centre[2])", " (point[0])",
        " (point[1])",  " (point[2])",  " (normal[0])", " (normal[1])",
        " (normal[2])", " (radius)",    " (stiffness)", " (damping)",
        " (friction)",  " (exponent)",  " (slip)",      " (creep)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table contact_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "contact",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
    .side = touch_side,
};

mbsr_force_def mbsr_force_contact(int a, int b, const mbsr_contact *contact)
{
    mbsr_force_def def = mbsri_stock_force(&contact_table, 2, a, b);
    if (!contact) return mbsri_given_null(def);
    memcpy(def.param + CENTRE, contact->centre, sizeof contact->centre);
    memcpy(def.param + POINT, contact->point, sizeof contact->point);
    mbsri_direction3(contact->normal, def.param + NORMAL);
    def.param[RADIUS] = contact->radius;
    def.param[STIFFNESS] = contact->stiffness;
    def.param[DAMPING] = contact->damping;
    def.param[FRICTION] = contact->friction;
    def.param[EXPONENT] = contact->exponent;
    def.param[SLIP] = contact->slip;
    def.param[CREEP] = contact->creep;
    return def;
}

bool mbsri_is_contact(const mbsr_force_def *def)
{
    return def->table == &contact_table;
}

void mbsri_contact_at(const mbsr_force_args *args, mbsr_contact_state *state)
{
    touch w;
    const bool touches = find_contact(args, &w);
    state->depth = w.x;
    if (!touches) return;
    state->rate = w.rate;
    state->normal_force = w.force;
    for (int k = 0; k < 3; ++k) {
        state->friction[k] = -w.drag * w.sliding[k];
        state->sliding[k] = w.sliding[k];
        state->normal[k] = w.normal[k];
        state->point[k] = w.a.x[k];
    }
}
