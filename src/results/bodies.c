/* Results per body.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

/* Index of a body whose results of `stage` are asked for; negative: refused, status in *status. */
static int enter(const mbsr_model *m, mbsr_data *d, int body, const double *out, mbsri_stage stage,
                 const char *function, int *status)
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
    const int i = enter(model, data, body, pose, MBSRI_STAGE_POSITIONS, "mbsr_body_pose", &status);
    if (i >= 0) mbsri_copy((size_t)model->body[i].np, data->p + model->body[i].p, pose);
    return status;
}

int mbsr_body_twist(const mbsr_model *model, mbsr_data *data, int body, double *twist)
{
    int status;
    const int i =
        enter(model, data, body, twist, MBSRI_STAGE_VELOCITIES, "mbsr_body_twist", &status);
    if (i >= 0) mbsri_copy((size_t)model->body[i].d, data->V + model->body[i].v, twist);
    return status; /* velocities and poses are finite where the stages succeed */
}

/* The same for what belongs to given accelerations. */
static int enter_accelerated(const mbsr_model *m, mbsr_data *d, int body, const double *out,
                             const char *function, int *status)
{
    const int i = enter(m, d, body, out, MBSRI_STAGE_FORCES, function, status);
    if (*status) return i;
    if (d->accelerated) {
        const size_t first = m->body[i].v, dim = (size_t)m->body[i].d;
        *status = mbsri_check_result(m, d, dim, d->A + first, function);
        if (!*status) *status = mbsri_check_result(m, d, dim, d->mu + first, function);
        return *status ? -1 : i;
    }
    *status = mbsri_fail(&d->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                         "%s: call mbsr_accelerations or mbsr_inverse_dynamics before", function);
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

/* -K^T mu: what the joint exerts on the body. For the root: the force that holds it against all
 * that stands on it. */
int mbsr_joint_reaction(const mbsr_model *model, mbsr_data *data, int body, double *force)
{
    int status;
    const int i = enter_accelerated(model, data, body, force, "mbsr_joint_reaction", &status);
    if (i < 0) return status;
    const mbsri_body *b = model->body + i;
    for (int k = 0; k < b->d; ++k) force[k] = -data->mu[b->v + (size_t)k];
    return MBSR_OK;
}

/* Columns of joint k on the way to the root: -X J_k with X = the product of -H below it. */
int mbsr_body_jacobian(const mbsr_model *model, mbsr_data *data, int body, double *jacobian)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status;
    const int i = enter(m, d, body, jacobian, MBSRI_STAGE_POSITIONS, "mbsr_body_jacobian", &status);
    if (i < 0) return status;
    const int rows = m->body[i].d;
    const size_t dim = (size_t)rows;
    double *X = d->scratch, *next = X + (size_t)m->max_d * (size_t)m->max_d;
    mbsri_zero(dim * (size_t)m->nu, jacobian);
    mbsri_zero(dim * dim, X);
    for (int k = 0; k < rows; ++k) X[k * (rows + 1)] = 1.0;
    for (int k = i; k > 0; k = m->body[k].parent) {
        const mbsri_body *b = m->body + k;
        mbsri_ab(rows, b->d, b->n, -1.0, X, d->J + b->dn, jacobian + dim * (size_t)b->u);
        mbsri_zero(dim * (size_t)b->d_pred, next);
        mbsri_ab(rows, b->d, b->d_pred, -1.0, X, d->H + b->dp, next);
        mbsri_copy(dim * (size_t)b->d_pred, next, X);
    }
    return mbsri_check_result(m, d, dim * (size_t)m->nu, jacobian, "mbsr_body_jacobian");
}
