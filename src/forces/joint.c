/* Elements on one coordinate of a joint: spring-damper, stops, friction.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/columns.h"
#include "forces/stock.h"

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
static void add_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out, double by_q,
                       double by_u)
{
    const mbsr_force_body *body = args->body;
    const int k = args->force->option[0], row = mbsri_tau_row(body, out->row[0]) + k,
              column = out->column[0];
    mbsri_add_slope(out, row, mbsri_q_column(body, column) + k, by_q);
    mbsri_add_slope(out, row, mbsri_u_column(body, column) + k, by_u);
}

/* ---- spring-damper: with e = q - rest, tau = -(c e + c3 e^3 + d u) ---- */

enum { SPRING_STIFFNESS, SPRING_DAMPING, REST, CUBIC };

static int spring_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    const double *param = args->force->param;
    const int k = args->force->option[0];
    const double e = body->q[k] - param[REST];
    body->tau[k] -=
        (param[SPRING_STIFFNESS] + param[CUBIC] * e * e) * e + param[SPRING_DAMPING] * body->u[k];
    return MBSR_OK;
}

static int spring_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param;
    const double e = args->body->q[args->force->option[0]] - param[REST];
    add_slopes(args, out, -param[SPRING_STIFFNESS] - 3.0 * param[CUBIC] * e * e,
               -param[SPRING_DAMPING]);
    return MBSR_OK;
}

static int spring_energy(const mbsr_force_args *args, double *energy)
{
    const double *param = args->force->param;
    const double e = args->body->q[args->force->option[0]] - param[REST];
    *energy += (0.5 * param[SPRING_STIFFNESS] + 0.25 * param[CUBIC] * e * e) * e * e;
    return MBSR_OK;
}

static int spring_dissipation(const mbsr_force_args *args, double *power)
{
    const double u = args->body->u[args->force->option[0]];
    *power += args->force->param[SPRING_DAMPING] * u * u;
    return MBSR_OK;
}

static int spring_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_position(args, text);
    if (status) return status;
    if (args->force->param[CUBIC] < 0.0)
        return mbsri_refuse_parameter(text, args, CUBIC, "negative");
    return mbsri_check_not_negative(args, SPRING_STIFFNESS, 2, text);
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
    def.param[CUBIC] = cubic;
    def.option[0] = coordinate;
    def.param[SPRING_STIFFNESS] = stiffness;
    def.param[SPRING_DAMPING] = damping;
    def.param[REST] = rest;
    return def;
}

/* ---- stops ---- */

enum { LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING };
enum { HAS_LOWER = 1, HAS_UPPER = 2 }; /* bits of option[1]: an infinite stop is none */

/* Depth beyond the stop that is passed, 0 between the two; q grows into the stop for *side = 1, out
 * of it for -1. */
static double depth(const mbsr_force_args *args, double *side)
{
    const double *param = args->force->param, q = args->body->q[args->force->option[0]];
    const int stops = args->force->option[1];
    *side = 1.0;
    if ((stops & HAS_UPPER) && q > param[UPPER]) return q - param[UPPER];
    *side = -1.0;
    if ((stops & HAS_LOWER) && q < param[LOWER]) return param[LOWER] - q;
    return 0.0;
}

static int stop_evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    const int k = args->force->option[0];
    double side;
    const double elastic = param[STOP_STIFFNESS] * depth(args, &side);
    args->body->tau[k] -=
        side * mbsri_one_sided(elastic, param[STOP_DAMPING] * side * args->body->u[k]);
    return MBSR_OK;
}

/* None between the stops. */
static int stop_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param;
    double side, by_elastic, by_damping;
    const double elastic = param[STOP_STIFFNESS] * depth(args, &side);
    if (!(elastic > 0.0)) return MBSR_OK;
    mbsri_one_sided_slopes(elastic,
                           param[STOP_DAMPING] * side * args->body->u[args->force->option[0]],
                           &by_elastic, &by_damping);
    add_slopes(args, out, -by_elastic * param[STOP_STIFFNESS], -by_damping * param[STOP_DAMPING]);
    return MBSR_OK;
}

static int stop_energy(const mbsr_force_args *args, double *energy)
{
    double side;
    const double x = depth(args, &side);
    *energy += 0.5 * args->force->param[STOP_STIFFNESS] * x * x;
    return MBSR_OK;
}

static int stop_dissipation(const mbsr_force_args *args, double *power)
{
    const double *param = args->force->param;
    double side;
    const double elastic = param[STOP_STIFFNESS] * depth(args, &side),
                 rate = side * args->body->u[args->force->option[0]];
    *power += (mbsri_one_sided(elastic, param[STOP_DAMPING] * rate) - elastic) * rate;
    return MBSR_OK;
}

static int stop_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    int status = check_position(args, text);
    if (status) return status;
    if (args->force->option[1] == (HAS_LOWER | HAS_UPPER) && !(param[LOWER] < param[UPPER])) {
        return mbsri_refuse(text, MBSR_ERR_VALUE, "lower is %g, not below upper, %g", param[LOWER],
                            param[UPPER]);
    }
    status = mbsri_check_not_negative(args, STOP_STIFFNESS, 2, text);
    if (!status && param[STOP_DAMPING] > 0.0 && param[STOP_STIFFNESS] == 0.0) {
        return mbsri_refuse_parameter(text, args, STOP_DAMPING,
                                      "but a stop without stiffness has no force");
    }
    return status;
}

static int stop_check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 1, 2, text), stops = def->option[1];
    if (status || (stops & ~(HAS_LOWER | HAS_UPPER)) == 0) return status;
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
};

mbsr_force_def mbsr_force_joint_stop(int body, int coordinate, double lower, double upper,
                                     double stiffness, double damping)
{
    mbsr_force_def def = mbsri_stock_force(&stop_table, 1, body, MBSR_GROUND);
    def.option[0] = coordinate;
    if (lower != -INFINITY) {
        def.param[LOWER] = lower;
        def.option[1] |= HAS_LOWER;
    }
    if (upper != INFINITY) {
        def.param[UPPER] = upper;
        def.option[1] |= HAS_UPPER;
    }
    def.param[STOP_STIFFNESS] = stiffness;
    def.param[STOP_DAMPING] = damping;
    return def;
}

/* ---- friction: tau = -force u / sqrt(u^2 + slip^2) ---- */

enum { FORCE, SLIP };

static double friction(const mbsr_force_args *args)
{
    const double *param = args->force->param, u = args->body->u[args->force->option[0]];
    return param[FORCE] * u / hypot(u, param[SLIP]);
}

static int friction_evaluate(const mbsr_force_args *args)
{
    args->body->tau[args->force->option[0]] -= friction(args);
    return MBSR_OK;
}

/* force slip^2 / (u^2 + slip^2)^(3/2) */
static int friction_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param;
    const double speed = hypot(args->body->u[args->force->option[0]], param[SLIP]),
                 ratio = param[SLIP] / speed;
    add_slopes(args, out, 0.0, -param[FORCE] * ratio * ratio / speed);
    return MBSR_OK;
}

static int friction_dissipation(const mbsr_force_args *args, double *power)
{
    *power += friction(args) * args->body->u[args->force->option[0]];
    return MBSR_OK;
}

static int friction_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_coordinate(args, text);
    return status ? status : mbsri_check_friction(args, FORCE, SLIP, text);
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
    def.param[FORCE] = force;
    def.param[SLIP] = slip;
    return def;
}
