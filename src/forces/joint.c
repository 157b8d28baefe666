/* Elements on one coordinate of a joint: spring-damper, stops, friction.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/columns.h"
#include "forces/coordinate_laws.h"
#include "forces/springs.h"

#include <math.h>

/* option[0] of all of them is the coordinate. */
static int check_coordinate(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body;
    const int k = args->force->option[0];
    if (k >= 0 && k < body->n) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "coordinate is %d, the joint of body %d has %d", k,
                        body->id, body->n);
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 1, 1, text);
}

/* q[coordinate] belongs to u[coordinate]. */
static int check_position(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body;
    const int status = check_coordinate(args, text);
    if (status || body->nq == body->n) return status;
    return mbsri_refuse(text, MBSR_ERR_SPACE,
                        "the joint of body %d has nq = %d, n = %d; they must be equal", body->id,
                        body->nq, body->n);
}

/* Derivatives of tau of the coordinate with respect to its q and u; nq = n or by_q = 0. */
static void add_law_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out,
                           mbsri_law_slopes slopes)
{
    const mbsr_force_body *body = args->body;
    const int k = args->force->option[0], row = mbsri_tau_row(body, out->row[0]) + k,
              column = out->column[0];
    mbsri_add_slope(out, row, mbsri_q_column(body, column) + k, slopes.by_q);
    mbsri_add_slope(out, row, mbsri_u_column(body, column) + k, slopes.by_u);
}

/* ---- spring-damper ---- */

static int spring_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    const int k = args->force->option[0];
    body->tau[k] += mbsri_spring_force(args->force->param, body->q[k], body->u[k]);
    return MBSR_OK;
}

static int spring_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double q = args->body->q[args->force->option[0]];
    add_law_slopes(args, out, mbsri_spring_slopes(args->force->param, q));
    return MBSR_OK;
}

static int spring_energy(const mbsr_force_args *args, double *energy)
{
    const double *param = args->force->param;
    const double e = args->body->q[args->force->option[0]] - param[MBSRI_SPRING_REST];
    *energy +=
        (0.5 * param[MBSRI_SPRING_STIFFNESS] + 0.25 * param[MBSRI_SPRING_CUBIC] * e * e) * e * e;
    return MBSR_OK;
}

static int spring_dissipation(const mbsr_force_args *args, double *power)
{
    const double u = args->body->u[args->force->option[0]];
    *power += args->force->param[MBSRI_SPRING_DAMPING] * u * u;
    return MBSR_OK;
}

static int spring_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_position(args, text);
    if (status) return status;
    if (args->force->param[MBSRI_SPRING_CUBIC] < 0.0)
        return mbsri_refuse_parameter(text, args, MBSRI_SPRING_CUBIC, "negative");
    return mbsri_check_not_negative(args, MBSRI_SPRING_STIFFNESS, 2, text);
}

static const char *spring_parameter(int k)
{
    static const char *const names[] = {" (stiffness)", " (damping)", " (rest)", " (cubic)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table spring_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint spring-damper",
    .evaluate = spring_evaluate,
    .energy = spring_energy,
    .dissipation = spring_dissipation,
    .check = spring_check,
    .check_fields = check_fields,
    .parameter = spring_parameter,
    .derivatives = spring_derivatives,
};

mbsr_force_def mbsr_force_joint_spring(int body, int coordinate, double stiffness, double damping,
                                       double rest)
{
    return mbsr_force_joint_cubic_spring(body, coordinate, stiffness, 0.0, damping, rest);
}

mbsr_force_def mbsr_force_joint_cubic_spring(int body, int coordinate, double stiffness,
                                             double cubic, double damping, double rest)
{
    mbsr_force_def def = mbsri_stock_force(&spring_table, 1, body, MBSR_GROUND);
    def.param[MBSRI_SPRING_CUBIC] = cubic;
    def.option[0] = coordinate;
    def.param[MBSRI_SPRING_STIFFNESS] = stiffness;
    def.param[MBSRI_SPRING_DAMPING] = damping;
    def.param[MBSRI_SPRING_REST] = rest;
    return def;
}

bool mbsri_read_joint_spring(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &spring_table) return false;
    spring->kind = MBSRI_JOINT_SPRING;
    spring->coordinate[0] = def->option[0];
    spring->stiffness[0] = def->param[MBSRI_SPRING_STIFFNESS];
    spring->damping[0] = def->param[MBSRI_SPRING_DAMPING];
    spring->rest = def->param[MBSRI_SPRING_REST];
    spring->beyond = def->param[MBSRI_SPRING_CUBIC] != 0.0 ? "it has a cubic term" : NULL;
    return true;
}

/* ---- stops ---- */

static double depth(const mbsr_force_args *args, double *side)
{
    const mbsr_force_def *def = args->force;
    return mbsri_stop_depth(def->param, def->option[1], args->body->q[def->option[0]], side);
}

static int stop_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_def *def = args->force;
    const mbsr_force_body *body = args->body;
    const int k = def->option[0];
    body->tau[k] += mbsri_stop_force(def->param, def->option[1], body->q[k], body->u[k]);
    return MBSR_OK;
}

static int stop_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_force_def *def = args->force;
    const mbsr_force_body *body = args->body;
    const int k = def->option[0];
    add_law_slopes(args, out,
                   mbsri_stop_slopes(def->param, def->option[1], body->q[k], body->u[k]));
    return MBSR_OK;
}

static int stop_energy(const mbsr_force_args *args, double *energy)
{
    double side;
    const double x = depth(args, &side);
    *energy += 0.5 * args->force->param[MBSRI_STOP_STIFFNESS] * x * x;
    return MBSR_OK;
}

static int stop_dissipation(const mbsr_force_args *args, double *power)
{
    const double *param = args->force->param;
    double side;
    const double elastic = param[MBSRI_STOP_STIFFNESS] * depth(args, &side),
                 rate = side * args->body->u[args->force->option[0]];
    *power += (mbsri_one_sided(elastic, param[MBSRI_STOP_DAMPING] * rate) - elastic) * rate;
    return MBSR_OK;
}

/* Negative at the lower stop. */
static double stop_side(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    double side;
    const double elastic = param[MBSRI_STOP_STIFFNESS] * depth(args, &side),
                 rate = side * args->body->u[args->force->option[0]];
    return side * mbsri_one_sided_branch(elastic, param[MBSRI_STOP_DAMPING] * rate);
}

static int stop_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    int status = check_position(args, text);
    if (status) return status;
    if (args->force->option[1] == (MBSRI_HAS_LOWER | MBSRI_HAS_UPPER) &&
        !(param[MBSRI_STOP_LOWER] < param[MBSRI_STOP_UPPER])) {
        return mbsri_refuse(text, MBSR_ERR_VALUE, "lower is %g, not below upper, %g",
                            param[MBSRI_STOP_LOWER], param[MBSRI_STOP_UPPER]);
    }
    status = mbsri_check_not_negative(args, MBSRI_STOP_STIFFNESS, 2, text);
    if (!status && param[MBSRI_STOP_DAMPING] > 0.0 && param[MBSRI_STOP_STIFFNESS] == 0.0) {
        return mbsri_refuse_parameter(text, args, MBSRI_STOP_DAMPING,
                                      "but a stop without stiffness has no force");
    }
    return status;
}

static int stop_check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 1, 2, text), stops = def->option[1];
    if (status || (stops & ~(MBSRI_HAS_LOWER | MBSRI_HAS_UPPER)) == 0) return status;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "option[1] is %d, must be 0 .. 3", stops);
}

static const char *stop_parameter(int k)
{
    static const char *const names[] = {" (lower)", " (upper)", " (stiffness)", " (damping)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table stop_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint stop",
    .evaluate = stop_evaluate,
    .energy = stop_energy,
    .dissipation = stop_dissipation,
    .check = stop_check,
    .check_fields = stop_check_fields,
    .parameter = stop_parameter,
    .derivatives = stop_derivatives,
    .side = stop_side,
};

mbsr_force_def mbsr_force_joint_stop(int body, int coordinate, double lower, double upper,
                                     double stiffness, double damping)
{
    mbsr_force_def def = mbsri_stock_force(&stop_table, 1, body, MBSR_GROUND);
    def.option[0] = coordinate;
    if (lower != -INFINITY) {
        def.param[MBSRI_STOP_LOWER] = lower;
        def.option[1] |= MBSRI_HAS_LOWER;
    }
    if (upper != INFINITY) {
        def.param[MBSRI_STOP_UPPER] = upper;
        def.option[1] |= MBSRI_HAS_UPPER;
    }
    def.param[MBSRI_STOP_STIFFNESS] = stiffness;
    def.param[MBSRI_STOP_DAMPING] = damping;
    return def;
}

/* ---- friction ---- */

static int friction_evaluate(const mbsr_force_args *args)
{
    const int k = args->force->option[0];
    args->body->tau[k] += mbsri_friction_force(args->force->param, args->body->u[k]);
    return MBSR_OK;
}

static int friction_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double u = args->body->u[args->force->option[0]];
    add_law_slopes(args, out, mbsri_friction_slopes(args->force->param, u));
    return MBSR_OK;
}

static int friction_dissipation(const mbsr_force_args *args, double *power)
{
    const double u = args->body->u[args->force->option[0]];
    *power -= mbsri_friction_force(args->force->param, u) * u;
    return MBSR_OK;
}

static int friction_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_coordinate(args, text);
    return status ? status
                  : mbsri_check_friction(args, MBSRI_FRICTION_FORCE, MBSRI_FRICTION_SLIP, text);
}

static const char *friction_parameter(int k)
{
    static const char *const names[] = {" (force)", " (slip)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table friction_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint friction",
    .evaluate = friction_evaluate,
    .dissipation = friction_dissipation,
    .check = friction_check,
    .check_fields = check_fields,
    .parameter = friction_parameter,
    .derivatives = friction_derivatives,
};

mbsr_force_def mbsr_force_joint_friction(int body, int coordinate, double force, double slip)
{
    mbsr_force_def def = mbsri_stock_force(&friction_table, 1, body, MBSR_GROUND);
    def.option[0] = coordinate;
    def.param[MBSRI_FRICTION_FORCE] = force;
    def.param[MBSRI_FRICTION_SLIP] = slip;
    return def;
}

mbsri_law mbsri_law_of(const mbsr_force_def *def)
{
    return def->table == &spring_table     ? MBSRI_LAW_SPRING
           : def->table == &stop_table     ? MBSRI_LAW_STOP
           : def->table == &friction_table ? MBSRI_LAW_FRICTION
                                           : MBSRI_LAW_NONE;
}
