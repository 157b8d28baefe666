/* Results per body.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/not_finite.h"
#include "sweeps/embed.h"

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

/* Whether body k of the tree was added as one on body i, which is welded to another, or on one that is
 * welded to that. */
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

/* mu of body i, which is welded to another, without what stands on both: adds that, X^T mu of each body k that
 * was added as one on i, with X the translation from the origin of i to that of k. */
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
