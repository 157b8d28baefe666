/* Linear spring-dampers: along a coordinate axis, along the line between two points, on a joint
 * coordinate.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

#include <math.h>

enum { STIFFNESS, DAMPING, REST, POINT_A_X, POINT_A_Y, POINT_B_X, POINT_B_Y };

/* ---- along a coordinate axis ----
 * e = p_a[axis] - p_b[axis], force on a: -(c (e - rest) + d e') */

static int axis_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param;
    const int axis = args->force->option[0];
    const double e = mbsri_entry(a, a->p, axis) - mbsri_entry(b, b->p, axis);
    const double rate = mbsri_entry(a, a->V, axis) - mbsri_entry(b, b->V, axis);
    const double force = -param[STIFFNESS] * (e - param[REST]) - param[DAMPING] * rate;
    if (a->space != MBSR_SPACE_FIXED) a->f[axis] += force;
    if (b->space != MBSR_SPACE_FIXED) b->f[axis] -= force;
    return MBSR_OK;
}

static int axis_energy(const mbsr_force_args *args, double *energy)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param;
    const int axis = args->force->option[0];
    const double e = mbsri_entry(a, a->p, axis) - mbsri_entry(b, b->p, axis) - param[REST];
    *energy += 0.5 * param[STIFFNESS] * e * e;
    return MBSR_OK;
}

static int axis_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int axis = args->force->option[0];
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_FIXED) continue;
        const int axes = body->d < body->np ? body->d : body->np;
        if (axis < 0 || axis >= axes) {
            return mbsri_refuse(text, MBSR_ERR_VALUE, "axis is %d, body %d has the axes 0 .. %d",
                                axis, body->id, axes - 1);
        }
    }
    if (args->body[0].id == args->body[1].id) {
        return mbsri_refuse(text, MBSR_ERR_ID, "both ends are on body %d", args->body[0].id);
    }
    return MBSR_OK;
}

static const mbsr_force_table axis_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "axis spring-damper",
    .evaluate = axis_evaluate,
    .energy = axis_energy,
    .check = axis_check,
};

mbsr_force_def mbsr_force_axis_spring(int a, int b, int axis, double stiffness, double damping,
                                      double rest)
{
    mbsr_force_def def = mbsri_stock_force(&axis_table, 2, a, b);
    def.option[0] = axis;
    def.param[STIFFNESS] = stiffness;
    def.param[DAMPING] = damping;
    def.param[REST] = rest;
    return def;
}

/* ---- between two points ---- */

typedef struct point {
    double arm[2]; /* from the body's origin, in the world */
    double x[2];
    double v[2]; /* zero while the energy is asked for */
} point;

static void locate(const mbsr_force_body *body, const double in_body[2], point *w)
{
    const bool turns = body->space == MBSR_SPACE_PLANAR;
    const double cosine = turns ? cos(body->p[2]) : 1.0, sine = turns ? sin(body->p[2]) : 0.0;
    const double omega = turns && body->V ? body->V[2] : 0.0;
    w->arm[0] = cosine * in_body[0] - sine * in_body[1];
    w->arm[1] = sine * in_body[0] + cosine * in_body[1];
    for (int k = 0; k < 2; ++k) {
        w->x[k] = mbsri_entry(body, body->p, k) + w->arm[k];
        w->v[k] = body->V ? mbsri_entry(body, body->V, k) : 0.0;
    }
    w->v[0] -= omega * w->arm[1];
    w->v[1] += omega * w->arm[0];
}

static void push(const mbsr_force_body *body, const point *w, double fx, double fy)
{
    if (body->space == MBSR_SPACE_FIXED) return;
    body->f[0] += fx;
    body->f[1] += fy;
    if (body->space == MBSR_SPACE_PLANAR) body->f[2] += w->arm[0] * fy - w->arm[1] * fx;
}

static int point_evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    point a, b;
    locate(args->body, param + POINT_A_X, &a);
    locate(args->body + 1, param + POINT_B_X, &b);
    const double e[2] = {a.x[0] - b.x[0], a.x[1] - b.x[1]},
                 v[2] = {a.v[0] - b.v[0], a.v[1] - b.v[1]};
    const double length = hypot(e[0], e[1]);
    double along = -param[STIFFNESS]; /* force on a = along e */
    if (param[REST] != 0.0 || param[DAMPING] != 0.0) {
        if (!(length > 0.0)) return MBSR_DEGENERATE_FORCE;
        const double rate = (e[0] * v[0] + e[1] * v[1]) / length;
        along = -(param[STIFFNESS] * (length - param[REST]) + param[DAMPING] * rate) / length;
    }
    push(args->body, &a, along * e[0], along * e[1]);
    push(args->body + 1, &b, -along * e[0], -along * e[1]);
    return MBSR_OK;
}

static int point_energy(const mbsr_force_args *args, double *energy)
{
    const double *param = args->force->param;
    point a, b;
    locate(args->body, param + POINT_A_X, &a);
    locate(args->body + 1, param + POINT_B_X, &b);
    const double e = hypot(a.x[0] - b.x[0], a.x[1] - b.x[1]) - param[REST];
    *energy += 0.5 * param[STIFFNESS] * e * e;
    return MBSR_OK;
}

static int point_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_GENERAL) {
            return mbsri_refuse(text, MBSR_ERR_SPACE,
                                "body %d is in GENERAL space, which has no points", body->id);
        }
        const double *in_body = param + POINT_A_X + 2 * k;
        if (body->space == MBSR_SPACE_POINT && (in_body[0] != 0.0 || in_body[1] != 0.0)) {
            return mbsri_refuse(text, MBSR_ERR_VALUE,
                                "point_%c is (%g, %g), but body %d is a POINT", k ? 'b' : 'a',
                                in_body[0], in_body[1], body->id);
        }
    }
    if (param[REST] < 0.0)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "free_length is %g, negative", param[REST]);
    if (args->body[0].id == args->body[1].id) {
        return mbsri_refuse(text, MBSR_ERR_ID, "both ends are on body %d", args->body[0].id);
    }
    return MBSR_OK;
}

static const mbsr_force_table point_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "point spring-damper",
    .evaluate = point_evaluate,
    .energy = point_energy,
    .check = point_check,
};

mbsr_force_def mbsr_force_point_spring(int a, const double point_a[2], int b,
                                       const double point_b[2], double stiffness, double damping,
                                       double free_length)
{
    mbsr_force_def def = mbsri_stock_force(&point_table, 2, a, b);
    def.param[STIFFNESS] = stiffness;
    def.param[DAMPING] = damping;
    def.param[REST] = free_length;
    for (int k = 0; k < 2; ++k) {
        def.param[POINT_A_X + k] = point_a[k];
        def.param[POINT_B_X + k] = point_b[k];
    }
    return def;
}

/* ---- on a joint coordinate ---- */

static int joint_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    const double *param = args->force->param;
    const int k = args->force->option[0];
    body->tau[k] -= param[STIFFNESS] * (body->q[k] - param[REST]) + param[DAMPING] * body->u[k];
    return MBSR_OK;
}

static int joint_energy(const mbsr_force_args *args, double *energy)
{
    const double *param = args->force->param;
    const double e = args->body->q[args->force->option[0]] - param[REST];
    *energy += 0.5 * param[STIFFNESS] * e * e;
    return MBSR_OK;
}

static int joint_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body;
    const int k = args->force->option[0];
    if (k < 0 || k >= body->n) {
        return mbsri_refuse(text, MBSR_ERR_VALUE, "coordinate is %d, the joint of body %d has %d",
                            k, body->id, body->n);
    }
    if (body->nq != body->n) {
        return mbsri_refuse(text, MBSR_ERR_SPACE,
                            "the joint of body %d has nq = %d, n = %d; they must be equal",
                            body->id, body->nq, body->n);
    }
    return MBSR_OK;
}

static const mbsr_force_table joint_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "joint spring-damper",
    .evaluate = joint_evaluate,
    .energy = joint_energy,
    .check = joint_check,
};

mbsr_force_def mbsr_force_joint_spring(int body, int coordinate, double stiffness, double damping,
                                       double rest)
{
    mbsr_force_def def = mbsri_stock_force(&joint_table, 1, body, MBSR_GROUND);
    def.option[0] = coordinate;
    def.param[STIFFNESS] = stiffness;
    def.param[DAMPING] = damping;
    def.param[REST] = rest;
    return def;
}
