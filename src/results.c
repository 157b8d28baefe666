/* Results per body, and the search for the first quantity that is not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include "dense.h"

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
    return status;
}

/* The same for what belongs to given accelerations. */
static int enter_accelerated(const mbsr_model *m, mbsr_data *d, int body, const double *out,
                             const char *function, int *status)
{
    const int i = enter(m, d, body, out, MBSRI_STAGE_FORCES, function, status);
    if (*status || d->accelerated) return i;
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
    return MBSR_OK;
}

/* The first of a body's quantities, in the order in which they are computed, that is not finite;
 * NULL if all are. */
static const char *culprit(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const size_t dim = (size_t)b->d, n = (size_t)b->n;
    const struct {
        const char *name;
        size_t length;
        const double *x;
        mbsri_stage stage;
    } list[] = {
        {"the pose", (size_t)b->np, d->p + b->p, MBSRI_STAGE_POSITIONS},
        {"H", dim * (size_t)b->d_pred, d->H + b->dp, MBSRI_STAGE_POSITIONS},
        {"J", dim * n, d->J + b->dn, MBSRI_STAGE_POSITIONS},
        {"kI", i > 0 ? dim : 0, d->kI + b->v, MBSRI_STAGE_POSITIONS},
        {"the mass matrix", i > 0 ? dim * dim : 0, d->M + b->dd, MBSRI_STAGE_VELOCITIES},
        {"the velocity", dim, d->V + b->v, MBSRI_STAGE_VELOCITIES},
        {"kII", i > 0 ? dim : 0, d->kII + b->v, MBSRI_STAGE_VELOCITIES},
        {"the gyroscopic force", i > 0 ? dim : 0, d->h + b->v, MBSRI_STAGE_VELOCITIES},
        {"the applied force", i > 0 ? dim : 0, d->f + b->v, MBSRI_STAGE_FORCES},
        {"the joint force", n, d->tau + b->iu, MBSRI_STAGE_FORCES},
    };
    for (size_t k = 0; k < sizeof list / sizeof list[0]; ++k) {
        if (d->stage >= list[k].stage && !mbsri_finite(list[k].length, list[k].x))
            return list[k].name;
    }
    return NULL;
}

int mbsri_report_not_finite(const mbsr_model *m, mbsr_data *d)
{
    char label[MBSRI_LABEL];
    for (int i = 0; i <= m->bodies; ++i) {
        const char *name = culprit(m, d, i);
        if (!name) continue;
        return mbsri_fail(&d->error, MBSR_NOT_FINITE, m->body[i].id, MBSR_NONE,
                          "%s: %s is not finite at t = %g",
                          i > 0 ? mbsri_body_label(m, i, label) : "root", name, d->t);
    }
    return mbsri_fail(
        &d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
        "a result is not finite at t = %g although all forces and kinematics are: overflow", d->t);
}
