/* Friction between two bodies whose contact is not modelled: of a point that slides under a given
 * load, and of a bearing.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the velocity w of a relative to b (of a point, or angular), its part s against which there
 * is friction and the rest r, the force or moment on a is
 *
 *   -(Coulomb / sqrt(|s|^2 + slip^2 + creep^2 |r|^2) + viscous) s
 *
 * where s is all of w, what is normal to a direction fixed to b, or what is along a direction fixed
 * to a (of a point) or b (of a bearing). */
#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/slopes.h"
#include "forces/stock.h"
#include "tables/table.h"

#include <math.h>
#include <string.h>

enum { DIRECTION, COULOMB = 3, VISCOUS, SLIP, CREEP, POINT, LOAD = POINT + 3 };
/* option[0], of the direction; option[1] is the body that carries it. */
enum { ALL, ACROSS, ALONG, BOTH };

static const double zero3[3] = {0.0, 0.0, 0.0};

typedef struct rub {
    mbsri_marker a, b;                /* the points of both bodies that rub; of a bearing zero */
    double direction[3], velocity[3]; /* w, along the world axes, as all here */
    double sliding[3], rest[3], speed, drag; /* s, r, the root; force or moment = -drag s */
    double coulomb;                          /* without the factor 1 / speed */
} rub;

static bool is_bearing(const mbsr_force_args *args);

/* Coefficient times load, or the torque. */
static int coulomb(const mbsr_force_args *args, double *value)
{
    const mbsr_force_def *def = args->force;
    const bool turning = is_bearing(args);
    double load = turning ? def->param[COULOMB] : def->param[LOAD];
    const int status = def->function ? def->function(def->user, args->t, 1, &load) : MBSR_OK;
    *value = load < 0.0 ? 0.0 : turning ? load : def->param[COULOMB] * load;
    return status;
}

static int find_sliding(const mbsr_force_args *args, rub *w)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param;
    const int part = args->force->option[0];
    double R[9];
    memset(w, 0, sizeof *w);
    if (is_bearing(args)) {
        double spin[3];
        mbsri_body_spin(a, w->velocity);
        mbsri_body_spin(b, spin);
        mbsri_add3(-1.0, spin, w->velocity);
    } else {
        mbsri_marker_on(a, param + POINT, &w->a);
        mbsri_marker_at(b, w->a.x, &w->b);
        for (int k = 0; k < 3; ++k) w->velocity[k] = w->a.v[k] - w->b.v[k];
    }
    mbsri_body_axes(args->body + args->force->option[1], R);
    mbsri_rotate3(R, param + DIRECTION, w->direction);
    const double along = mbsri_dot3(w->direction, w->velocity);
    if (part != ALONG) memcpy(w->sliding, w->velocity, sizeof w->sliding);
    if (part != ALL) mbsri_add3(part == ALONG ? along : -along, w->direction, w->sliding);
    for (int k = 0; k < 3 && part == ALONG; ++k) w->rest[k] = w->velocity[k] - w->sliding[k];
    w->speed =
        hypot(hypot(mbsri_norm3(w->sliding), param[SLIP]), param[CREEP] * mbsri_norm3(w->rest));
    const int status = coulomb(args, &w->coulomb);
    w->drag = w->coulomb / w->speed + param[VISCOUS];
    return status;
}

/* Force and moment on a, at the point. */
static void exert(const mbsr_force_args *args, const rub *w, double force[3], double moment[3])
{
    double *at = is_bearing(args) ? moment : force;
    memset(force, 0, 3 * sizeof *force);
    memset(moment, 0, 3 * sizeof *moment);
    mbsri_add3(-w->drag, w->sliding, at);
}

static int evaluate(const mbsr_force_args *args)
{
    double force[3], moment[3];
    rub w;
    const int status = find_sliding(args, &w);
    if (status) return status;
    exert(args, &w, force, moment);
    mbsri_push(args->body, &w.a, 1.0, force, moment);
    mbsri_push(args->body + 1, &w.b, -1.0, force, moment);
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    rub w;
    const int status = find_sliding(args, &w);
    if (!status) *power += w.drag * mbsri_dot3(w.sliding, w.sliding);
    return status;
}

/* ---- derivatives ---- */

typedef struct rub_slopes {
    mbsri_vector velocity[MBSRI_MAX_COLUMNS], direction[MBSRI_MAX_COLUMNS];
    mbsri_vector arm_a[MBSRI_MAX_COLUMNS], arm_b[MBSRI_MAX_COLUMNS];
} rub_slopes;

static void locate_slopes(const mbsr_force_args *args, const mbsri_columns *c, const rub *w,
                          rub_slopes *d)
{
    memset(d, 0, sizeof *d);
    mbsri_add_turn(c, args->force->option[1], MBSRI_POSE, 1.0, w->direction, d->direction);
    if (is_bearing(args)) {
        mbsri_add_spin(c, 0, MBSRI_RATE, 1.0, d->velocity);
        mbsri_add_spin(c, 1, MBSRI_RATE, -1.0, d->velocity);
        return;
    }
    mbsri_add_turn(c, 0, MBSRI_POSE, 1.0, w->a.arm, d->arm_a);
    memcpy(d->arm_b, d->arm_a, sizeof d->arm_b);
    mbsri_add_shift(c, 0, MBSRI_POSE, 1.0, d->arm_b);
    mbsri_add_shift(c, 1, MBSRI_POSE, -1.0, d->arm_b);
    mbsri_add_velocity(c, 0, 1.0, w->a.arm, d->arm_a, d->velocity);
    mbsri_add_velocity(c, 1, -1.0, w->b.arm, d->arm_b, d->velocity);
}

/* The derivative of -drag s, by that of w and of the direction n: with s = w, w - (n . w) n or (n .
 * w) n. */
static void drag_slope(const mbsr_force_args *args, const rub *w, const double dw[3],
                       const double dn[3], double dforce[3])
{
    const int part = args->force->option[0];
    const double creep = args->force->param[CREEP], sign = part == ALONG ? 1.0 : -1.0;
    double ds[3], dr[3];
    memcpy(ds, part == ALONG ? zero3 : dw, sizeof ds);
    if (part != ALL) {
        mbsri_add3(sign * (mbsri_dot3(dn, w->velocity) + mbsri_dot3(w->direction, dw)),
                   w->direction, ds);
        mbsri_add3(sign * mbsri_dot3(w->direction, w->velocity), dn, ds);
    }
    for (int k = 0; k < 3; ++k) dr[k] = dw[k] - ds[k];
    const double dspeed =
        (mbsri_dot3(w->sliding, ds) + creep * creep * mbsri_dot3(w->rest, dr)) / w->speed;
    mbsri_add3(w->coulomb / w->speed * (dspeed / w->speed), w->sliding, dforce);
    mbsri_add3(-w->drag, ds, dforce);
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    mbsri_vector dpush[2][MBSRI_MAX_COLUMNS]; /* of the force and of the moment */
    double force[3], moment[3];
    rub_slopes d;
    rub w;
    const int status = find_sliding(args, &w), at = is_bearing(args);
    if (status) return status;
    locate_slopes(args, &c, &w, &d);
    exert(args, &w, force, moment);
    memset(dpush, 0, sizeof dpush);
    for (int l = 0; l < c.count; ++l)
        drag_slope(args, &w, d.velocity[l].x, d.direction[l].x, dpush[at][l].x);
    mbsri_push_slopes(&c, 0, 1.0, w.a.arm, force, d.arm_a, dpush[0], dpush[1]);
    mbsri_push_slopes(&c, 1, -1.0, w.b.arm, force, d.arm_b, dpush[0], dpush[1]);
    return MBSR_OK;
}

/* ---- refusals ---- */

static int check_slip(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    const int status = mbsri_check_not_negative(args, COULOMB, 2, text);
    if (status) return status;
    if (!(param[SLIP] > 0.0)) return mbsri_refuse_parameter(text, args, SLIP, "not positive");
    if (args->force->function == mbsr_table_force && mbsri_table_columns(args->force->user) != 1)
        return mbsri_table_refuse(args->force->user, 1, text);
    return mbsri_check_not_negative(args, CREEP, 1, text);
}

static int point_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    int status = mbsri_check_marker(args, 0, param + POINT, "point", text);
    if (!status) status = mbsri_check_marker(args, 1, zero3, "", text);
    if (!status) status = mbsri_check_ends(args, text);
    if (!status) status = check_slip(args, text);
    if (!status) status = mbsri_check_not_negative(args, LOAD, 1, text);
    if (!status && param[CREEP] > 0.0 && args->force->option[0] != ALONG)
        status = mbsri_refuse_parameter(text, args, CREEP, "but there is no axle");
    return status;
}

static int bearing_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_PLANAR || body->space == MBSR_SPACE_SPATIAL ||
            body->space == MBSR_SPACE_FIXED)
            continue;
        return mbsri_refuse(text, MBSR_ERR_SPACE, "body %d is not in PLANAR or SPATIAL space",
                            body->id);
    }
    const int status = mbsri_check_ends(args, text);
    return status ? status : check_slip(args, text);
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int part = def->option[0], status = mbsri_check_shape(def, 2, 2, text);
    if (status) return status;
    if (part == BOTH) return mbsri_refuse(text, MBSR_ERR_VALUE, "it has a normal and an axle");
    if (part < ALL || part > ALONG)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "option[0] is %d, must be 0 .. 2", part);
    if (def->option[1] != 0 && def->option[1] != 1)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "option[1] is %d, must be 0 or 1",
                            def->option[1]);
    const double length = mbsri_norm3(def->param + DIRECTION);
    if (part == ALL || fabs(length - 1.0) < 1e-9) return MBSR_OK;
    if (length == 0.0) return mbsri_refuse(text, MBSR_ERR_VALUE, "direction is (0, 0, 0)");
    return mbsri_refuse(text, MBSR_ERR_VALUE, "direction has length %g, must be 1", length);
}

static const char *point_parameter(int k)
{
    static const char *const names[] = {" (direction[0])", " (direction[1])", " (direction[2])",
                                        " (coefficient)",  " (viscous)",      " (slip)",
                                        " (creep)",        " (point[0])",     " (point[1])",
                                        " (point[2])",     " (load)"};
    return MBSRI_PARAMETER(names, k);
}

static const char *bearing_parameter(int k)
{
    static const char *const names[] = {" (axis[0])", " (axis[1])", " (axis[2])",
                                        " (torque)",  " (viscous)", " (slip)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table point_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "point friction",
    .evaluate = evaluate,
    .dissipation = dissipation,
    .check = point_check,
    .check_fields = check_fields,
    .parameter = point_parameter,
    .derivatives = derivatives,
};

static const mbsr_force_table bearing_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "bearing friction",
    .evaluate = evaluate,
    .dissipation = dissipation,
    .check = bearing_check,
    .check_fields = check_fields,
    .parameter = bearing_parameter,
    .derivatives = derivatives,
};

static bool is_bearing(const mbsr_force_args *args)
{
    return args->force->table == &bearing_table;
}

/* ---- constructors ---- */

static bool is_given(const double direction[3])
{
    return direction[0] != 0.0 || direction[1] != 0.0 || direction[2] != 0.0;
}

mbsr_force_def mbsr_force_point_friction(int a, const double point[3], int b,
                                         const mbsr_friction *friction)
{
    mbsr_force_def def = mbsri_stock_force(&point_table, 2, a, b);
    if (!friction) return mbsri_given_null(def);
    mbsri_store_point(point, def.param + POINT);
    def.param[COULOMB] = friction->coefficient;
    def.param[VISCOUS] = friction->viscous;
    def.param[SLIP] = friction->slip;
    def.param[CREEP] = friction->creep;
    def.param[LOAD] = friction->load;
    if (is_given(friction->normal)) {
        def.option[0] = is_given(friction->axle) ? BOTH : ACROSS;
        def.option[1] = 1;
        mbsri_direction3(friction->normal, def.param + DIRECTION);
    } else if (is_given(friction->axle)) {
        def.option[0] = ALONG;
        mbsri_direction3(friction->axle, def.param + DIRECTION);
    }
    def.function = friction->table ? mbsr_table_force : friction->function;
    def.user = friction->table ? friction->table : friction->user;
    return def;
}

mbsr_force_def mbsr_force_bearing_friction(int a, int b, const mbsr_bearing *bearing)
{
    mbsr_force_def def = mbsri_stock_force(&bearing_table, 2, a, b);
    if (!bearing) return mbsri_given_null(def);
    def.param[COULOMB] = bearing->torque;
    def.param[VISCOUS] = bearing->viscous;
    def.param[SLIP] = bearing->slip;
    if (is_given(bearing->axis)) {
        def.option[0] = ALONG;
        def.option[1] = 1;
        mbsri_direction3(bearing->axis, def.param + DIRECTION);
    }
    def.function = bearing->table ? mbsr_table_force : bearing->function;
    def.user = bearing->table ? bearing->table : bearing->user;
    return def;
}
