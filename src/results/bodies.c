/* Results per body.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/not_finite.h"
#include "sweeps/embed.h"

#include "results/energy.h"

#include <mbsrank/dynamics.h>

#include <math.h>

/* Index of a body whose results of `stage` are asked for; negative: refused, status in *status. */
static int enter_body(const mbsr_model *m, mbsr_data *d, int body, const double *out,
                      mbsri_stage stage, const char *function, int *status)
{
    *status = mbsri_enter(m, d, out != NULL, stage, function);
    if (*status) return -1;
    const int i = mbsri_index(m, body);
    if (i < 0)
        *status = mbsri_fail(&d->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                             "%s: there is no body %d", function, body);
    return i;
}

int mbsr_body_pose(const mbsr_model *model, mbsr_data *data, int body, double *pose)
{
    int status;
    const int i =
        enter_body(model, data, body, pose, MBSRI_STAGE_POSITIONS, "mbsr_body_pose", &status);
    if (i >= 0) mbsri_copy((size_t)model->body[i].np, data->p + model->body[i].p, pose);
    return status;
}

int mbsr_body_twist(const mbsr_model *model, mbsr_data *data, int body, double *twist)
{
    int status;
    const int i =
        enter_body(model, data, body, twist, MBSRI_STAGE_VELOCITIES, "mbsr_body_twist", &status);
    if (i >= 0) mbsri_copy((size_t)model->body[i].d, data->V + model->body[i].v, twist);
    return status; /* velocities and poses are finite where the stages succeed */
}

int mbsr_body_energy(const mbsr_model *model, mbsr_data *data, int body, double *kinetic)
{
    int status;
    const int i =
        enter_body(model, data, body, kinetic, MBSRI_STAGE_VELOCITIES, "mbsr_body_energy", &status);
    if (i < 0) return status;
    const double T = i > 0 ? mbsri_kinetic_energy_of(model, data, i) : 0.0;
    status = mbsri_check_result(model, data, 1, &T, "mbsr_body_energy");
    if (!status) *kinetic = T;
    return status;
}

/* The same for what belongs to given accelerations. */
static int enter_accelerated(const mbsr_model *m, mbsr_data *d, int body, const double *out,
                             const char *function, int *status)
{
    const int i = enter_body(m, d, body, out, MBSRI_STAGE_FORCES, function, status);
    if (*status) return i;
    if (d->accelerated) {
        const size_t first = m->body[i].v, dim = (size_t)m->body[i].d;
        *status = mbsri_check_result(m, d, dim, d->A + first, function);
        if (!*status) *status = mbsri_check_result(m, d, dim, d->mu + first, function);
        return *status ? -1 : i;
    }
    *status =
        mbsri_fail(&d->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "%s: call mbsr_stage_accelerations or mbsr_inverse_dynamics before", function);
    return -1;
}

int mbsr_body_acceleration(const mbsr_model *model, mbsr_data *data, int body, double *acceleration)
{
    int status;
    const int i =
        enter_accelerated(model, data, body, acceleration, "mbsr_body_acceleration", &status);
    if (i >= 0) mbsri_copy((size_t)model->body[i].d, data->A + model->body[i].v, acceleration);
    return status;
}

/* Whether body k of the tree was added as one on body i, which is welded to another, or on one that
 * is welded to that. */
static bool was_on(const mbsr_model *m, int k, int i)
{
    const mbsri_body_entry *entry = m->entries.data;
    int at = mbsri_index(m, entry[m->body[k].id].parent);
    while (at > m->live && at != i) at = mbsri_index(m, entry[m->body[at].id].parent);
    return at == i;
}

static void origin_of(const mbsri_body *b, const mbsr_data *d, double r[3])
{
    double R[9];
    mbsri_embedded_pose(b->joint.space, d->p + b->p, R, r);
}

/* mu of body i, which is welded to another, without what stands on both: adds that, X^T mu of each
 * body k that was added as one on i, with X the translation from the origin of i to that of k. */
static void add_handed_over(const mbsr_model *m, const mbsr_data *d, int i, double *force)
{
    const mbsri_body *b = m->body + i;
    double r[3], sum[6] = {0.0}, own[6];
    origin_of(b, d, r);
    for (int k = 1; k <= m->live; ++k) {
        if (!was_on(m, k, i)) continue;
        double arm[3], mu[6];
        origin_of(m->body + k, d, arm);
        mbsri_add3(-1.0, r, arm);
        mbsri_lift(m->body[k].d, d->mu + m->body[k].v, mu);
        mbsri_add_cross3(arm, mu + 3, mu);
        for (int l = 0; l < 6; ++l) sum[l] += mu[l];
    }
    mbsri_lower(b->d, sum, own);
    for (int l = 0; l < b->d; ++l) force[l] -= own[l];
}

/* -K^T mu: what the joint exerts on the body. For the root: the force that holds it against all
 * that stands on it. */
int mbsr_joint_reaction(const mbsr_model *model, mbsr_data *data, int body, double *force)
{
    int status;
    const int i = enter_accelerated(model, data, body, force, "mbsr_joint_reaction", &status);
    if (i < 0) return status;
    const mbsri_body *b = model->body + i;
    for (int k = 0; k < b->d; ++k) force[k] = -data->mu[b->v + (size_t)k];
    if (i > model->live) add_handed_over(model, data, i, force);
    return MBSR_OK;
}

/* A motion of a body as one in space: the arm to its point, then angular and linear parts of V and
 * A. */
typedef struct point_motion {
    double r[3], arm[3], omega[3], v[3], alpha[3], a[3];
} point_motion;

static void move_in_space(const mbsri_body *b, const mbsr_data *d, const double *point,
                          point_motion *to)
{
    const double *R = d->p + b->p, *V = d->V + b->v, *A = d->A + b->v;
    mbsri_copy(3, R + MBSR_POSE_X, to->r);
    for (int k = 0; k < 3; ++k)
        to->arm[k] = R[k] * point[0] + R[3 + k] * point[1] + R[6 + k] * point[2];
    mbsri_copy(3, V, to->omega);
    mbsri_copy(3, V + 3, to->v);
    mbsri_copy(3, A, to->alpha);
    mbsri_copy(3, A + 3, to->a);
}

static void move_in_plane(const mbsri_body *b, const mbsr_data *d, const double *point,
                          point_motion *to)
{
    const double *p = d->p + b->p, *V = d->V + b->v, *A = d->A + b->v;
    mbsri_copy(2, p, to->r);
    mbsri_copy(2, V, to->v);
    mbsri_copy(2, A, to->a);
    if (b->joint.space != MBSR_SPACE_PLANAR) return;
    to->arm[0] = cos(p[2]) * point[0] - sin(p[2]) * point[1];
    to->arm[1] = sin(p[2]) * point[0] + cos(p[2]) * point[1];
    to->omega[2] = V[2];
    to->alpha[2] = A[2];
}

int mbsr_body_point(const mbsr_model *model, mbsr_data *data, int body, const double point[3],
                    double position[3], double velocity[3], double acceleration[3])
{
    static const char name[] = "mbsr_body_point";
    static const double origin[3] = {0.0, 0.0, 0.0};
    const mbsri_stage stage = velocity ? MBSRI_STAGE_VELOCITIES : MBSRI_STAGE_POSITIONS;
    int status;
    const int i = acceleration ? enter_accelerated(model, data, body, acceleration, name, &status)
                               : enter_body(model, data, body, origin, stage, name, &status);
    if (i < 0) return status;
    const mbsri_body *b = model->body + i;
    point_motion motion = {.r = {0.0}};
    const double *at = point ? point : origin;
    if (b->joint.space == MBSR_SPACE_SPATIAL || b->joint.space == MBSR_SPACE_FLEXIBLE) {
        move_in_space(b, data, at, &motion);
    } else if (b->joint.space == MBSR_SPACE_PLANAR || b->joint.space == MBSR_SPACE_POINT) {
        move_in_plane(b, data, at, &motion);
    } else if (b->joint.space != MBSR_SPACE_FIXED) {
        return mbsri_fail(&data->error, MBSR_ERR_SPACE, body, MBSR_NONE,
                          "%s: body %d is in general space, where points have no place", name,
                          body);
    }
    double speed[3], along[3], inward[3];
    mbsri_cross3(motion.omega, motion.arm, speed);
    mbsri_cross3(motion.alpha, motion.arm, along);
    mbsri_cross3(motion.omega, speed, inward);
    for (int k = 0; k < 3; ++k) {
        if (position) position[k] = motion.r[k] + motion.arm[k];
        if (velocity) velocity[k] = motion.v[k] + speed[k];
        if (acceleration) acceleration[k] = motion.a[k] + along[k] + inward[k];
    }
    return MBSR_OK;
}

/* Columns of joint k on the way to the root: -X J_k with X = the product of -H below it. */
int mbsr_body_jacobian(const mbsr_model *model, mbsr_data *data, int body, double *jacobian)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status;
    const int i =
        enter_body(m, d, body, jacobian, MBSRI_STAGE_POSITIONS, "mbsr_body_jacobian", &status);
    if (i < 0) return status;
    const int rows = m->body[i].d;
    const size_t dim = (size_t)rows;
    double *X = d->scratch, *next = X + (size_t)m->most.d * (size_t)m->most.d;
    mbsri_zero(dim * (size_t)m->nu, jacobian);
    mbsri_zero(dim * dim, X);
    for (int k = 0; k < rows; ++k) X[k * (rows + 1)] = 1.0;
    for (int k = i; k > 0; k = m->body[k].parent) {
        const mbsri_body *b = m->body + k;
        mbsri_ab(rows, b->d, b->n, -1.0, X, d->J + b->dn, jacobian + dim * (size_t)b->u);
        mbsri_zero(dim * (size_t)b->pred.d, next);
        mbsri_ab(rows, b->d, b->pred.d, -1.0, X, d->H + b->dp, next);
        mbsri_copy(dim * (size_t)b->pred.d, next, X);
    }
    return mbsri_check_result(m, d, dim * (size_t)m->nu, jacobian, "mbsr_body_jacobian");
}
