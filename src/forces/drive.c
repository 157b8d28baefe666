/* Drives of joint coordinates: towards a reference, by a characteristic, through a gear.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/drive.h"

#include "forces/columns.h"
#include "forces/coordinate_laws.h"
#include "forces/springs.h"
#include "forces/stock.h"
#include "tables/table.h"

#include <math.h>

/* Refuses a coordinate of body k that there is not; `position`: one whose q does not belong to u.
 */
static int check_coordinate(const mbsr_force_args *args, int k, int coordinate, bool position,
                            char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body + k;
    if (body->id == MBSR_GROUND) return mbsri_refuse(text, MBSR_ERR_ID, "it acts on the ground");
    if (coordinate < 0 || coordinate >= body->n) {
        return mbsri_refuse(text, MBSR_ERR_VALUE, "coordinate is %d, the joint of body %d has %d",
                            coordinate, body->id, body->n);
    }
    if (!position || body->nq == body->n) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_SPACE,
                        "the joint of body %d has nq = %d, n = %d; they must be equal", body->id,
                        body->nq, body->n);
}

/* d tau of coordinate i of body k with respect to q and u of coordinate j of body l */
static void add_coordinate_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out,
                                  int k, int i, int l, int j, double by_q, double by_u)
{
    const int row = mbsri_tau_row(args->body + k, out->row[k]) + i;
    if (by_q != 0.0)
        mbsri_add_slope(out, row, mbsri_q_column(args->body + l, out->column[l]) + j, by_q);
    mbsri_add_slope(out, row, mbsri_u_column(args->body + l, out->column[l]) + j, by_u);
}

/* ---- towards a reference: tau = kp (r - q) + kd (r' - u), at most `limit` ---- */

enum { KP, KD, REFERENCE, LIMIT };

static int reference(const mbsr_force_args *args, double r[2])
{
    const mbsr_force_def *def = args->force;
    r[0] = def->param[REFERENCE];
    r[1] = 0.0;
    if (def->function == mbsr_table_force)
        return mbsr_table_value(def->user, args->t, r, r + 1, NULL);
    return def->function ? def->function(def->user, args->t, 2, r) : MBSR_OK;
}

static int servo_effort(const mbsr_force_args *args, double *effort, bool *limited)
{
    const double *param = args->force->param;
    const int k = args->force->option[0];
    double r[2];
    const int status = reference(args, r);
    *effort = param[KP] * (r[0] - args->body->q[k]) + param[KD] * (r[1] - args->body->u[k]);
    *limited = param[LIMIT] > 0.0 && fabs(*effort) > param[LIMIT];
    if (*limited) *effort = copysign(param[LIMIT], *effort);
    return status;
}

static int servo_evaluate(const mbsr_force_args *args)
{
    double effort;
    bool limited;
    const int status = servo_effort(args, &effort, &limited);
    if (!status) args->body->tau[args->force->option[0]] += effort;
    return status;
}

static int servo_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    double effort;
    bool limited;
    const int status = servo_effort(args, &effort, &limited), k = args->force->option[0];
    if (!status && !limited)
        add_coordinate_slopes(args, out, 0, k, 0, k, -args->force->param[KP],
                              -args->force->param[KD]);
    return status;
}

static double servo_side(const mbsr_force_args *args)
{
    double effort;
    bool limited;
    return servo_effort(args, &effort, &limited) || !limited ? 0.0 : copysign(1.0, effort);
}

static int servo_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_def *def = args->force;
    int status = check_coordinate(args, 0, def->option[0], true, text);
    if (!status) status = mbsri_check_not_negative(args, KP, 2, text);
    if (!status && def->param[LIMIT] < 0.0)
        status = mbsri_refuse_parameter(text, args, LIMIT, "negative");
    if (!status && def->function == mbsr_table_force && mbsri_table_columns(def->user) != 1)
        status = mbsri_table_refuse(def->user, 1, text);
    return status;
}

static int one_body(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 1, 1, text);
}

static const char *servo_parameter(int k)
{
    static const char *const names[] = {" (kp)", " (kd)", " (reference)", " (limit)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table servo_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint servo",
    .evaluate = servo_evaluate,
    .check = servo_check,
    .check_fields = one_body,
    .parameter = servo_parameter,
    .derivatives = servo_derivatives,
    .side = servo_side,
};

mbsr_force_def mbsr_force_joint_servo(int body, int coordinate, const mbsr_servo *servo)
{
    mbsr_force_def def = mbsri_stock_force(&servo_table, 1, body, MBSR_GROUND);
    if (!servo) return mbsri_given_null(def);
    def.option[0] = coordinate;
    def.param[KP] = servo->kp;
    def.param[KD] = servo->kd;
    def.param[REFERENCE] = servo->reference;
    def.param[LIMIT] = servo->limit;
    def.function = servo->table ? mbsr_table_force : servo->function;
    def.user = servo->table ? servo->table : servo->user;
    return def;
}

int mbsri_table_lead(const mbsr_force_def *def)
{
    return def->table == &servo_table ? 0 : 1;
}

/* ---- by a characteristic: tau = table(u) ---- */

static int curve_at(const mbsr_force_args *args, double *torque, double *slope)
{
    return mbsr_table_value(args->force->user, args->body->u[args->force->option[0]], torque, slope,
                            NULL);
}

static int curve_evaluate(const mbsr_force_args *args)
{
    double torque = 0.0;
    const int status = curve_at(args, &torque, NULL);
    args->body->tau[args->force->option[0]] += torque;
    return status;
}

static int curve_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    double slope = 0.0;
    const int status = curve_at(args, NULL, &slope), k = args->force->option[0];
    if (!status) add_coordinate_slopes(args, out, 0, k, 0, k, 0.0, slope);
    return status;
}

/* The next kink. */
static double curve_side(const mbsr_force_args *args)
{
    double next = 0.0;
    int derivative;
    return mbsr_table_kink(args->force->user, args->body->u[args->force->option[0]], 1, &next,
                           &derivative) ||
                   derivative != 1
               ? 0.0
               : next;
}

static int curve_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    return check_coordinate(args, 0, args->force->option[0], false, text);
}

static int curve_check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = one_body(def, text);
    if (status || mbsri_table_columns(def->user) == 1) return status;
    return mbsri_table_refuse(def->user, 1, text);
}

static const mbsr_force_table curve_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint characteristic",
    .evaluate = curve_evaluate,
    .check = curve_check,
    .check_fields = curve_check_fields,
    .derivatives = curve_derivatives,
    .side = curve_side,
};

bool mbsri_reads_table(const mbsr_force_def *def)
{
    return def->function == mbsr_table_force || def->table == &curve_table;
}

mbsr_force_def mbsr_force_joint_curve(int body, int coordinate, mbsr_table *torque)
{
    mbsr_force_def def = mbsri_stock_force(&curve_table, 1, body, MBSR_GROUND);
    def.option[0] = coordinate;
    def.user = torque;
    return def;
}

/* ---- through a gear: e = q_a - ratio q_b - rest; x what of it is beyond the backlash,
 * T = one-sided(k |x|, d e'), tau_a -= T, tau_b += ratio T. A coordinate that is locked is -1, and
 * its part of e is in LOCKED. ---- */

enum { RATIO, STIFFNESS, DAMPING, REST, BACKLASH, LOCKED };

static double of(const double *x, int coordinate)
{
    return coordinate < 0 ? 0.0 : x[coordinate];
}

/* Depth x >= 0 in the teeth, which face sign, and the rate of x. */
static double mesh(const mbsr_force_args *args, double *sign, double *rate)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param;
    const int i = args->force->option[0], j = args->force->option[1];
    const double e = of(a->q, i) - param[RATIO] * of(b->q, j) + param[LOCKED] - param[REST];
    *sign = e < 0.0 ? -1.0 : 1.0;
    *rate = a->u && b->u ? *sign * (of(a->u, i) - param[RATIO] * of(b->u, j)) : 0.0;
    return fmax(0.0, fabs(e) - 0.5 * param[BACKLASH]);
}

/* Without backlash the damper acts at rest too, and both ways. */
static double torque(const double *param, double x, double rate)
{
    const double elastic = param[STIFFNESS] * x, damping = param[DAMPING] * rate;
    return param[BACKLASH] > 0.0 ? mbsri_one_sided(elastic, damping) : elastic + damping;
}

static int gear_evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    const int *coordinate = args->force->option;
    double sign, rate;
    const double x = mesh(args, &sign, &rate), T = sign * torque(param, x, rate);
    if (coordinate[0] >= 0) args->body[0].tau[coordinate[0]] -= T;
    if (coordinate[1] >= 0) args->body[1].tau[coordinate[1]] += param[RATIO] * T;
    return MBSR_OK;
}

static int gear_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const double *param = args->force->param, lever[2] = {1.0, -param[RATIO]};
    const int *coordinate = args->force->option;
    double sign, rate, by_elastic = 1.0, by_damping = 1.0;
    const double x = mesh(args, &sign, &rate);
    if (param[BACKLASH] > 0.0) {
        if (!(x > 0.0)) return MBSR_OK;
        mbsri_one_sided_slopes(param[STIFFNESS] * x, param[DAMPING] * rate, &by_elastic,
                               &by_damping);
    }
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 2 && coordinate[k] >= 0; ++l) {
            if (coordinate[l] < 0) continue;
            add_coordinate_slopes(args, out, k, coordinate[k], l, coordinate[l],
                                  -lever[k] * lever[l] * by_elastic * param[STIFFNESS],
                                  -lever[k] * lever[l] * by_damping * param[DAMPING]);
        }
    }
    return MBSR_OK;
}

static double gear_side(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    double sign, rate;
    const double x = mesh(args, &sign, &rate);
    return param[BACKLASH] > 0.0
               ? sign * mbsri_one_sided_branch(param[STIFFNESS] * x, param[DAMPING] * rate)
               : 0.0;
}

static int gear_energy(const mbsr_force_args *args, double *energy)
{
    double sign, rate;
    const double x = mesh(args, &sign, &rate);
    *energy += 0.5 * args->force->param[STIFFNESS] * x * x;
    return MBSR_OK;
}

static int gear_dissipation(const mbsr_force_args *args, double *power)
{
    const double *param = args->force->param;
    double sign, rate;
    const double x = mesh(args, &sign, &rate);
    *power += (torque(param, x, rate) - param[STIFFNESS] * x) * rate;
    return MBSR_OK;
}

static int gear_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const double *param = args->force->param;
    int status = check_coordinate(args, 0, args->force->option[0], true, text);
    if (!status) status = check_coordinate(args, 1, args->force->option[1], true, text);
    if (!status && args->body[0].id == args->body[1].id &&
        args->force->option[0] == args->force->option[1])
        status = mbsri_refuse(text, MBSR_ERR_VALUE, "both coordinates are %d of body %d",
                              args->force->option[0], args->body[0].id);
    if (!status) status = mbsri_check_not_negative(args, STIFFNESS, 2, text);
    if (!status && param[BACKLASH] < 0.0)
        status = mbsri_refuse_parameter(text, args, BACKLASH, "negative");
    if (!status && param[RATIO] == 0.0) status = mbsri_refuse_parameter(text, args, RATIO, "zero");
    if (!status && param[BACKLASH] > 0.0 && param[DAMPING] > 0.0 && param[STIFFNESS] == 0.0) {
        status = mbsri_refuse_parameter(text, args, DAMPING,
                                        "but teeth with backlash without stiffness have no force");
    }
    return status;
}

static int gear_check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 2, 2, text);
}

static const char *gear_parameter(int k)
{
    static const char *const names[] = {" (ratio)", " (stiffness)", " (damping)", " (rest)",
                                        " (backlash)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table gear_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "gear",
    .evaluate = gear_evaluate,
    .energy = gear_energy,
    .dissipation = gear_dissipation,
    .check = gear_check,
    .check_fields = gear_check_fields,
    .parameter = gear_parameter,
    .derivatives = gear_derivatives,
    .side = gear_side,
};

mbsr_force_def mbsr_force_gear(int a, int coordinate_a, int b, int coordinate_b,
                               const mbsr_gear *gear)
{
    mbsr_force_def def = mbsri_stock_force(&gear_table, 2, a, b);
    if (!gear) return mbsri_given_null(def);
    def.option[0] = coordinate_a;
    def.option[1] = coordinate_b;
    def.param[RATIO] = gear->ratio;
    def.param[STIFFNESS] = gear->stiffness;
    def.param[DAMPING] = gear->damping;
    def.param[REST] = gear->rest;
    def.param[BACKLASH] = gear->backlash;
    return def;
}

void mbsri_gear_hold(mbsr_force_def *def, int k, double value)
{
    def->option[k] = -1;
    def->param[LOCKED] += (k ? -def->param[RATIO] : 1.0) * value;
}

void mbsri_gear_release(mbsr_force_def *def)
{
    if (def->table == &gear_table) def->param[LOCKED] = 0.0;
}

int mbsri_force_coordinates(const mbsr_force_def *def)
{
    if (def->table == &gear_table) return 2;
    const bool one = def->table == &servo_table || def->table == &curve_table;
    return one || mbsri_law_of(def) != MBSRI_LAW_NONE;
}

bool mbsri_read_gear(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &gear_table) return false;
    spring->kind = MBSRI_GEAR;
    spring->coordinate[0] = def->option[0];
    spring->coordinate[1] = def->option[1];
    spring->stiffness[0] = def->param[STIFFNESS];
    spring->damping[0] = def->param[DAMPING];
    spring->rest = def->param[REST];
    spring->ratio = def->param[RATIO];
    spring->beyond = def->param[BACKLASH] > 0.0 ? "it has a backlash" : NULL;
    return true;
}
