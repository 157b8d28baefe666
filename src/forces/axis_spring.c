/* Linear spring-damper and friction along a coordinate axis.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   e = p_a[axis] - p_b[axis],
 *       force on a: -(c (e - rest) + d e'), -force e' / sqrt(e'^2 + slip^2) */
#include "forces/columns.h"
#include "forces/springs.h"
#include "forces/stock.h"

#include <math.h>

enum { STIFFNESS, DAMPING, REST };

static double stretch(const mbsr_force_args *args)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const int axis = args->force->option[0];
    return mbsri_entry(a, a->p, axis) - mbsri_entry(b, b->p, axis) - args->force->param[REST];
}

static double stretch_rate(const mbsr_force_args *args)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const int axis = args->force->option[0];
    return mbsri_entry(a, a->V, axis) - mbsri_entry(b, b->V, axis);
}

/* Adds a force on a and its reaction. */
static int push_along_axis(const mbsr_force_args *args, double force)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const int axis = args->force->option[0];
    if (a->space != MBSR_SPACE_FIXED) a->f[axis] += force;
    if (b->space != MBSR_SPACE_FIXED) b->f[axis] -= force;
    return MBSR_OK;
}

static int evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    return push_along_axis(args,
                           -param[STIFFNESS] * stretch(args) - param[DAMPING] * stretch_rate(args));
}

/* On body k by body l: sign -(c, d), plus on itself. */
static int push_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out,
                       double stiffness, double damping)
{
    const int axis = args->force->option[0];
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 2; ++l) {
            if (out->row[k] < 0 || out->row[l] < 0) continue;
            const double sign = k == l ? -1.0 : 1.0;
            const int row = out->row[k] + axis, column = out->column[l];
            mbsri_add_slope(out, row, column + axis, sign * stiffness);
            mbsri_add_slope(out, row, mbsri_V_column(args->body + l, column) + axis,
                            sign * damping);
        }
    }
    return MBSR_OK;
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param;
    return push_slopes(args, out, param[STIFFNESS], param[DAMPING]);
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    const double e = stretch(args);
    *energy_out += 0.5 * args->force->param[STIFFNESS] * e * e;
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    const double rate = stretch_rate(args);
    *power += args->force->param[DAMPING] * rate * rate;
    return MBSR_OK;
}

static int check_axis(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int axis = args->force->option[0];
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_FIXED) continue;
        if (body->space == MBSR_SPACE_SPATIAL || body->space == MBSR_SPACE_FLEXIBLE) {
            return mbsri_refuse(text, MBSR_ERR_SPACE, "body %d is in %s space, where V is not p'",
                                body->id,
                                body->space == MBSR_SPACE_SPATIAL ? "SPATIAL" : "FLEXIBLE");
        }
        const int axes = body->d < body->np ? body->d : body->np;
        if (axis < 0 || axis >= axes) {
            return mbsri_refuse(text, MBSR_ERR_VALUE, "axis is %d, body %d has the axes 0 .. %d",
                                axis, body->id, axes - 1);
        }
    }
    return mbsri_check_ends(args, text);
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_axis(args, text);
    return status ? status : mbsri_check_not_negative(args, STIFFNESS, 2, text);
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 2, 1, text);
}

static const char *parameter(int k)
{
    static const char *const names[] = {" (stiffness)", " (damping)", " (rest)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table axis_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "axis spring-damper",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
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

bool mbsri_read_axis_spring(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &axis_table) return false;
    spring->kind = MBSRI_AXIS_SPRING;
    spring->coordinate[0] = def->option[0];
    spring->stiffness[0] = def->param[STIFFNESS];
    spring->damping[0] = def->param[DAMPING];
    spring->rest = def->param[REST];
    return true;
}

/* ---- friction ---- */

enum { FRICTION_FORCE, SLIP };

static double friction(const mbsr_force_args *args, double *rate, double *speed)
{
    const double *param = args->force->param;
    *rate = stretch_rate(args);
    *speed = hypot(*rate, param[SLIP]);
    return param[FRICTION_FORCE] * *rate / *speed;
}

static int friction_evaluate(const mbsr_force_args *args)
{
    double rate, speed;
    return push_along_axis(args, -friction(args, &rate, &speed));
}

/* force slip^2 / (e'^2 + slip^2)^(3/2) */
static int friction_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param;
    double rate, speed;
    friction(args, &rate, &speed);
    const double ratio = param[SLIP] / speed;
    return push_slopes(args, out, 0.0, param[FRICTION_FORCE] * ratio * ratio / speed);
}

static int friction_dissipation(const mbsr_force_args *args, double *power)
{
    double rate, speed;
    const double force = friction(args, &rate, &speed);
    *power += force * rate;
    return MBSR_OK;
}

static int friction_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_axis(args, text);
    return status ? status : mbsri_check_friction(args, FRICTION_FORCE, SLIP, text);
}

static const char *friction_parameter(int k)
{
    static const char *const names[] = {" (force)", " (slip)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table friction_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "axis friction",
    .evaluate = friction_evaluate,
    .dissipation = friction_dissipation,
    .check = friction_check,
    .check_fields = check_fields,
    .parameter = friction_parameter,
    .derivatives = friction_derivatives,
};

mbsr_force_def mbsr_force_axis_friction(int a, int b, int axis, double force, double slip)
{
    mbsr_force_def def = mbsri_stock_force(&friction_table, 2, a, b);
    def.option[0] = axis;
    def.param[FRICTION_FORCE] = force;
    def.param[SLIP] = slip;
    return def;
}
