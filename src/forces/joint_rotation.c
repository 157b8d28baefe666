/* Spring-damper on the orientation of a joint with a quaternion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * theta is the rotation vector of q rest^-1, along A's axes, and omega the first three of u:
 *
 *   tau = -(J^-T(theta) (c theta) + d omega),   energy 1/2 sum of c theta^2
 *
 * A change dq turns the body by phi = 2 vec(dq q*) / |q|^2 along A's axes (rotation.h). */
#include "algebra/space3.h"
#include "forces/columns.h"
#include "forces/rotation.h"
#include "forces/stock.h"

#include <math.h>

enum { STIFFNESS, DAMPING = STIFFNESS + 3, REST = DAMPING + 3 };

/* p = q r* */
static void unrotated(const double q[4], const double r[4], double p[4])
{
    p[0] = q[0] * r[0] + mbsri_dot3(q + 1, r + 1);
    mbsri_cross3(r + 1, q + 1, p + 1);
    for (int k = 1; k < 4; ++k) p[k] += r[0] * q[k] - q[0] * r[k];
}

/* theta, and n along q of a length that can be squared; half: whether theta is one of two. */
static int rotation_vector_of(const mbsr_force_args *args, double n[4], double theta[3], bool *half)
{
    double p[4];
    if (!mbsri_scale4(args->body->q, n)) return MBSR_ZERO_QUATERNION;
    unrotated(n, args->force->param + REST, p);
    mbsri_quaternion_vector(p, theta);
    *half = mbsri_turn_is_half(p, theta, args->force->param + STIFFNESS);
    return MBSR_OK;
}

static int evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    const double *stiffness = args->force->param + STIFFNESS,
                 *damping = args->force->param + DAMPING;
    double n[4], theta[3], moment[3];
    bool half;
    const int status = rotation_vector_of(args, n, theta, &half);
    if (status || half) return status ? status : MBSR_DEGENERATE_FORCE;
    for (int k = 0; k < 3; ++k) moment[k] = stiffness[k] * theta[k];
    mbsri_unturn(theta, moment, moment);
    for (int k = 0; k < 3; ++k) body->tau[k] -= moment[k] + damping[k] * body->u[k];
    return MBSR_OK;
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_force_body *body = args->body;
    const double *param = args->force->param;
    const int row = mbsri_tau_row(body, out->row[0]),
              q_column = mbsri_q_column(body, out->column[0]),
              u_column = mbsri_u_column(body, out->column[0]);
    double n[4], theta[3], T[9];
    bool half;
    const int status = rotation_vector_of(args, n, theta, &half);
    if (status || half) return status ? status : MBSR_DEGENERATE_FORCE;
    mbsri_turning_stiffness(theta, param + STIFFNESS, T);
    const double scale = 2.0 / (n[0] * body->q[0] + mbsri_dot3(n + 1, body->q + 1));
    for (int c = 0; c < 4; ++c) {
        double dq[4] = {0.0}, phi[3], dmoment[3];
        dq[c] = scale;
        mbsri_cross3(n + 1, dq + 1, phi);
        for (int k = 0; k < 3; ++k) phi[k] += n[0] * dq[1 + k] - dq[0] * n[1 + k];
        mbsri_rotate3(T, phi, dmoment);
        for (int k = 0; k < 3; ++k) mbsri_add_slope(out, row + k, q_column + c, -dmoment[k]);
    }
    for (int k = 0; k < 3; ++k) mbsri_add_slope(out, row + k, u_column + k, -param[DAMPING + k]);
    return MBSR_OK;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    const double *stiffness = args->force->param + STIFFNESS;
    double n[4], theta[3];
    bool half;
    const int status = rotation_vector_of(args, n, theta, &half);
    if (status) return status;
    for (int k = 0; k < 3; ++k) *energy_out += 0.5 * stiffness[k] * theta[k] * theta[k];
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    const double *damping = args->force->param + DAMPING, *u = args->body->u;
    for (int k = 0; k < 3; ++k) *power += damping[k] * u[k] * u[k];
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body;
    if (body->n < 3 || body->nq != body->n + 1) {
        return mbsri_refuse(text, MBSR_ERR_SPACE,
                            "the joint of body %d has nq = %d, n = %d; one with a quaternion has n "
                            ">= 3, nq = n + 1",
                            body->id, body->nq, body->n);
    }
    return mbsri_check_not_negative(args, STIFFNESS, 6, text);
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const double *rest = def->param + REST;
    const int status = mbsri_check_shape(def, 1, 0, text);
    if (status) return status;
    const double length = sqrt(rest[0] * rest[0] + mbsri_dot3(rest + 1, rest + 1));
    if (fabs(length - 1.0) < 1e-9) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "rest is a quaternion of length %g", length);
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (stiffness[0])", " (stiffness[1])", " (stiffness[2])", " (damping[0])", " (damping[1])",
        " (damping[2])",   " (rest[0])",      " (rest[1])",      " (rest[2])",    " (rest[3])"};
    return MBSRI_PARAMETER(names, k);
}

static double half_turn_side(const mbsr_force_args *args)
{
    double n[4], theta[3];
    bool half;
    if (rotation_vector_of(args, n, theta, &half)) return 0.0;
    return mbsri_turn_side(theta);
}

static const mbsr_force_table rotation_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "joint rotation spring-damper",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
    .side = half_turn_side,
};

mbsr_force_def mbsr_force_joint_rotation_spring(int body, const double stiffness[3],
                                                const double damping[3], const double rest[4])
{
    mbsr_force_def def = mbsri_stock_force(&rotation_table, 1, body, MBSR_GROUND);
    double n[4] = {1.0, 0.0, 0.0, 0.0};
    if (rest) mbsri_scale4(rest, n);
    const double length = sqrt(n[0] * n[0] + mbsri_dot3(n + 1, n + 1));
    for (int k = 0; k < 4; ++k) def.param[REST + k] = length > 0.0 ? n[k] / length : n[k];
    for (int k = 0; k < 3; ++k) {
        def.param[STIFFNESS + k] = stiffness ? stiffness[k] : 0.0;
        def.param[DAMPING + k] = damping ? damping[k] : 0.0;
    }
    return def;
}
