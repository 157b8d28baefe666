/* Kinematics, root to leaves: poses (7), velocities (8), and the part of (9) without accelerations.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * (8) and (9) are multiplied by K^-1 once, here:  H, J, kI, kII <- K^-1 (H, J, kI, kII). From then
 * on
 *
 *   V_i = -(H_i V_pi + J_i u_i + kI_i)          A_i = -(H_i A_pi + J_i u_i' + kII_i)
 *
 * and the recursions have K = I. With mu <- K^T mu and Mbar <- K^T Mbar K all equations of the
 * paper keep their form; J^T mu, D and the residual (25) keep their values. */
#include "recursion/kinematics.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "joints/chain.h"
#include "model/query.h"
#include "recursion/inertia.h"
#include "recursion/locks.h"
#include "recursion/modal.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/driver.h>

#include <math.h>

mbsr_joint_args mbsri_joint_args(const mbsr_model *m, const mbsr_data *d, int i, bool velocities)
{
    const mbsri_body *b = m->body + i;
    return (mbsr_joint_args){.param = b->joint.param,
                             .option = b->joint.option,
                             .motion = b->joint.motion,
                             .user = b->joint.user,
                             .d = b->d,
                             .np = b->np,
                             .n = b->joint.n,
                             .nq = b->joint.nq,
                             .t = d->t,
                             .q = b->lock.count ? d->q_full + b->lock.full : d->q + b->iq,
                             .u = !velocities     ? NULL
                                  : b->lock.count ? d->u_full + b->lock.full
                                                  : d->u + b->iu,
                             .pred_space = b->pred.space,
                             .pred_d = b->pred.d,
                             .p_pred = d->p + b->pred.p,
                             .V_pred = velocities ? d->V + b->pred.v : NULL,
                             .p = d->p + b->p,
                             .V = velocities ? d->V + b->v : NULL};
}

int mbsri_joint_failed(const mbsr_model *m, mbsr_data *d, int i, int status, const char *function)
{
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, status, m->body[i].id, MBSR_NONE,
                      "%s: joint '%s': %s returned %d (%s) at t = %g",
                      mbsri_body_label(m, i, label), m->body[i].joint.table->name, function, status,
                      mbsr_status_text(status), d->t);
}

int mbsri_move_root(const mbsr_model *m, mbsr_data *d)
{
    const mbsr_root *root = &m->root;
    mbsri_zero((size_t)root->np, d->p);
    for (int k = 0; k < 9 && root->space == MBSR_SPACE_SPATIAL; k += 4) d->p[MBSR_POSE_R + k] = 1.0;
    mbsri_zero((size_t)root->d, d->V);
    mbsri_zero((size_t)root->d, d->A);
    if (!root->motion) return MBSR_OK;
    const int status = root->motion(root->user, d->t, d->p, d->V, d->A);
    if (status) {
        return mbsri_fail(&d->error, status, MBSR_GROUND, MBSR_NONE,
                          "root: motion returned %d at t = %g", status, d->t);
    }
    const char *bad = !mbsri_finite((size_t)root->np, d->p)  ? "pose"
                      : !mbsri_finite((size_t)root->d, d->V) ? "velocity"
                      : !mbsri_finite((size_t)root->d, d->A) ? "acceleration"
                                                             : NULL;
    if (!bad) return MBSR_OK;
    return mbsri_fail(&d->error, MBSR_NOT_FINITE, MBSR_GROUND, MBSR_NONE,
                      "root: the %s is not finite at t = %g", bad, d->t);
}

/* MBSR_NOT_FINITE if x (n numbers), which a function of joint i wrote, is not finite. */
static int check_joint_finite(const mbsr_model *m, mbsr_data *d, int i, int n, const double *x,
                              const char *what)
{
    if (mbsri_finite((size_t)n, x)) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_NOT_FINITE, m->body[i].id, MBSR_NONE,
                      "%s: joint '%s': %s is not finite at t = %g", mbsri_body_label(m, i, label),
                      m->body[i].joint.table->name, what, d->t);
}

/* Scales the rows, then the columns of K to largest entries 1: the verdict on K shall not depend
 * on units. */
static void equilibrate_K(int n, double *K, double *row, double *column)
{
    for (int i = 0; i < n; ++i) {
        double size = 0.0;
        for (int j = 0; j < n; ++j) size = fmax(size, fabs(K[j * n + i]));
        row[i] = size > 0.0 ? 1.0 / size : 1.0;
        for (int j = 0; j < n; ++j) K[j * n + i] *= row[i];
    }
    for (int j = 0; j < n; ++j) {
        double size = 0.0;
        for (int i = 0; i < n; ++i) size = fmax(size, fabs(K[j * n + i]));
        column[j] = size > 0.0 ? 1.0 / size : 1.0;
        for (int i = 0; i < n; ++i) K[j * n + i] *= column[j];
    }
}

/* K <- K^-1; refuses a K that is singular to working accuracy. */
static int invert_K(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    double *K = d->Kinv + b->k, *row = d->scratch, *column = row + b->d, *work = column + b->d;
    char label[MBSRI_LABEL];
    const int status = check_joint_finite(m, d, i, b->d * b->d, K, "K");
    if (status) return status;
    equilibrate_K(b->d, K, row, column);
    const double rcond = mbsri_lapack_inverse(b->d, K, d->pivots, work);
    if (!(rcond > 1e-15)) {
        return mbsri_fail(&d->error, MBSR_SINGULAR_K, b->id, MBSR_NONE,
                          "%s: joint '%s': K is singular at t = %g (reciprocal condition %.2g)",
                          mbsri_body_label(m, i, label), b->joint.table->name, d->t, rcond);
    }
    for (int j = 0; j < b->d; ++j) {
        for (int k = 0; k < b->d; ++k) K[j * b->d + k] *= column[k] * row[j];
    }
    return MBSR_OK;
}

/* Full column rank of J by the Cholesky factorisation of J^T J with unit diagonal: pivots are
 * squared distances of a column from the span of those before it. The columns' units do not
 * matter. Those of rates with armature depend on no others: D has a pivot of their own there. */
static int check_J(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n;
    const double *J = d->J + b->dn;
    double *L = d->scratch, *norm = L + (size_t)n * (size_t)n;
    for (int k = 0; k < n; ++k) norm[k] = sqrt(mbsri_dot(b->d, J + k * b->d, J + k * b->d));
    for (int k = 0; k < n; ++k) {
        const bool own = b->mass.armature[k] > 0.0;
        for (int j = 0; j <= k && own; ++j) L[k * n + j] = j < k ? 0.0 : INFINITY;
        for (int j = 0; j <= k && !own; ++j) {
            const double scale = norm[j] * norm[k];
            double sum = mbsri_dot(b->d, J + j * b->d, J + k * b->d);
            if (!(scale <= 0.0)) sum /= scale; /* NaN stays NaN */
            for (int l = 0; l < j; ++l) sum -= L[k * n + l] * L[j * n + l];
            if (j < k) {
                L[k * n + j] = sum / L[j * n + j];
            } else if (sum > 1e-13) {
                L[k * n + k] = sqrt(sum);
            } else {
                char label[MBSRI_LABEL];
                const int status = isfinite(sum) ? MBSR_RANK_DEFICIENT_J : MBSR_NOT_FINITE;
                return mbsri_fail(&d->error, status, b->id, MBSR_NONE,
                                  "%s: joint '%s': J %s at t = %g (column %d)",
                                  mbsri_body_label(m, i, label), b->joint.table->name,
                                  isfinite(sum) ? "has not full column rank" : "is not finite",
                                  d->t, k);
            }
        }
    }
    return MBSR_OK;
}

/* x <- K^-1 x for `columns` columns of d numbers. */
static void divide_by_K(const mbsri_body *b, mbsr_data *d, int columns, double *x)
{
    const size_t size = (size_t)b->d * (size_t)columns;
    mbsri_copy(size, x, d->scratch);
    mbsri_zero(size, x);
    mbsri_ab(b->d, b->d, columns, 1.0, d->Kinv + b->k, d->scratch, x);
}

static bool unit_K(const mbsri_body *b)
{
    return (b->joint.table->flags & MBSR_JOINT_UNIT_K) != 0;
}

/* H, J, kI of body i, K divided out.  reads p, q;  writes Kinv, H, J, kI. */
static int jacobians(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const mbsr_joint_args args = mbsri_joint_args(m, d, i, false);
    double *K = NULL, *H = d->H + b->dp, *J = d->J + b->dn, *kI = d->kI + b->v;
    double *all = b->lock.count ? d->scratch : J; /* every column, those held included */
    mbsri_zero((size_t)b->d * (size_t)b->pred.d, H);
    mbsri_zero((size_t)b->d * (size_t)b->joint.n, all);
    mbsri_zero((size_t)b->d, kI);
    if (!unit_K(b)) {
        K = d->Kinv + b->k;
        mbsri_zero((size_t)b->d * (size_t)b->d, K);
        for (int k = 0; k < b->d; ++k) K[k * b->d + k] = 1.0;
    }
    int status = b->joint.table->jacobians(&args, K, H, all, kI);
    if (status) return mbsri_joint_failed(m, d, i, status, "jacobians");
    if (b->lock.count) mbsri_drop_held(b, all, J);
    /* the rank of J before K is divided out: an ill-conditioned K must not count against J */
    if (!(b->joint.table->flags & MBSR_JOINT_REGULAR_J)) status = check_J(m, d, i);
    if (status || !K) return status;
    status = invert_K(m, d, i);
    if (status) return status;
    divide_by_K(b, d, b->pred.d, H);
    divide_by_K(b, d, b->n, J);
    divide_by_K(b, d, 1, kI);
    return MBSR_OK;
}

/* Whether it is a sequence of steps in space without coordinates that are held. */
static bool is_chain(const mbsri_body *b)
{
    return b->joint.table->position == mbsri_chain_position &&
           b->joint.table->jacobians == mbsri_chain_jacobians && !b->lock.count;
}

/* Pose, H, J, kI of such a joint at once. */
static int place_chain(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    mbsr_joint_args args = mbsri_joint_args(m, d, i, false);
    args.p = NULL;
    mbsri_zero((size_t)b->d * (size_t)b->pred.d, d->H + b->dp);
    mbsri_zero((size_t)b->d * (size_t)b->n, d->J + b->dn);
    mbsri_zero((size_t)b->d, d->kI + b->v);
    int status = mbsri_chain_place(&args, d->p + b->p, d->H + b->dp, d->J + b->dn, d->kI + b->v);
    if (status) return mbsri_joint_failed(m, d, i, status, "position");
    status = check_joint_finite(m, d, i, b->np, d->p + b->p, "the pose");
    if (!status && !(b->joint.table->flags & MBSR_JOINT_REGULAR_J)) status = check_J(m, d, i);
    return status;
}

int mbsri_place_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    if (is_chain(b)) return place_chain(m, d, i);
    if (b->lock.count) mbsri_with_held(b, d->q + b->iq, true, d->q_full + b->lock.full);
    mbsr_joint_args args = mbsri_joint_args(m, d, i, false);
    args.p = NULL;
    /* p_i from k(p_i, p_pi, q_i, t) = 0 */
    mbsri_zero((size_t)b->np, d->p + b->p);
    int status = b->joint.table->position(&args, d->p + b->p);
    if (status) return mbsri_joint_failed(m, d, i, status, "position");
    status = check_joint_finite(m, d, i, b->np, d->p + b->p, "the pose");
    if (status) return status;
    /* K, H, J, kI */
    return jacobians(m, d, i);
}

int mbsri_position_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int status = mbsri_place_joint(m, d, i);
    if (status) return status;
    /* M_i(p_i) */
    mbsri_inertia_mass(b, d->p + b->p, d->M + b->dd);
    return MBSR_OK;
}

int mbsri_positions(const mbsr_model *m, mbsr_data *d, double t, const double *q)
{
    d->stage = MBSRI_STAGE_NONE;
    d->accelerated = d->lambda_known = false;
    d->pending = MBSRI_PENDING_NONE;
    if (!isfinite(t) || !mbsri_finite((size_t)m->nq, q)) {
        return mbsri_fail(&d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                          "mbsr_stage_positions: t or q is not finite");
    }
    if (d->lean) {
        return mbsri_fail(&d->error, MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE,
                          "mbsr_stage_positions: the data was made by mbsr_data_create_lean or "
                          "mbsr_data_init_lean; this call, or this state, needs full data");
    }
    d->t = t;
    int status = mbsri_move_root(m, d);
    if (status) return status;

    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_copy((size_t)b->nq, q + b->q, d->q + b->iq);
        status = mbsri_position_of(m, d, i);
        if (status) return status;
    }
    d->stage = MBSRI_STAGE_POSITIONS;
    return MBSR_OK;
}

int mbsri_move_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    if (b->lock.count) mbsri_with_held(b, d->u + b->iu, false, d->u_full + b->lock.full);
    double *V = d->V + b->v, *kII = d->kII + b->v;
    /* V_i = -(H_i V_pi + J_i u_i + kI_i) */
    mbsri_zero((size_t)b->d, V);
    mbsri_ax_often(b->d, b->pred.d, -1.0, d->H + b->dp, d->V + b->pred.v, V);
    mbsri_add_along(b, -1.0, d->J + b->dn, d->u + b->iu, V);
    for (int k = 0; k < b->d; ++k) V[k] -= d->kI[b->v + (size_t)k];
    if (!mbsri_finite((size_t)b->d, V)) {
        char label[MBSRI_LABEL];
        return mbsri_report_not_finite(m, d, mbsri_body_label(m, i, label));
    }
    /* kII_i */
    const mbsr_joint_args args = mbsri_joint_args(m, d, i, true);
    mbsri_zero((size_t)b->d, kII);
    int status = b->joint.table->bias(&args, kII);
    if (status) return mbsri_joint_failed(m, d, i, status, "bias");
    if (!unit_K(b)) divide_by_K(b, d, 1, kII);
    return MBSR_OK;
}

int mbsri_velocity_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    int status = mbsri_move_joint(m, d, i);
    if (status) return status;
    /* gyroscopic force; M_i where it is given by a function */
    status = mbsri_inertia_velocity(b, d->t, d->p + b->p, d->V + b->v, d->M + b->dd, d->h + b->v);
    return status ? mbsri_joint_failed(m, d, i, status, "the inertia's function") : MBSR_OK;
}

int mbsri_velocities(const mbsr_model *m, mbsr_data *d, const double *u)
{
    d->stage = MBSRI_STAGE_POSITIONS;
    d->accelerated = d->lambda_known = false;
    d->pending = MBSRI_PENDING_NONE;
    if (!mbsri_finite((size_t)m->nu, u)) {
        return mbsri_fail(&d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                          "mbsr_stage_velocities: u is not finite");
    }
    mbsri_gather(m, u, d->u);

    for (int i = 1; i <= m->bodies; ++i) {
        const int status = mbsri_velocity_of(m, d, i);
        if (status) return status;
    }
    d->stage = MBSRI_STAGE_VELOCITIES;
    return MBSR_OK;
}

int mbsri_coordinate_rates_of(const mbsr_model *m, mbsr_data *d, int i, double *qdot)
{
    const mbsri_body *b = m->body + i;
    if (!b->joint.table->coordinate_rates) {
        mbsri_copy((size_t)b->n, d->u + b->iu, qdot);
        return MBSR_OK;
    }
    const mbsr_joint_args args = mbsri_joint_args(m, d, i, true);
    mbsri_zero((size_t)b->nq, qdot);
    const int status = b->joint.table->coordinate_rates(&args, qdot);
    if (status) return mbsri_joint_failed(m, d, i, status, "coordinate_rates");
    return check_joint_finite(m, d, i, b->nq, qdot, "what coordinate_rates wrote");
}

int mbsri_coordinate_rates(const mbsr_model *m, mbsr_data *d, double *qdot)
{
    int status = MBSR_OK;
    for (int i = 1; i <= m->bodies && !status; ++i)
        status = mbsri_coordinate_rates_of(m, d, i, qdot + m->body[i].q);
    return status;
}

int mbsri_normalise(const mbsr_model *m, mbsr_data *d, double *q)
{
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (!b->joint.table->normalise) continue;
        const mbsr_joint_args args = mbsri_joint_args(m, d, i, false);
        double *own = q + b->q, *full = b->lock.count ? d->scratch : own;
        if (b->lock.count) mbsri_with_held(b, own, true, full);
        const int status = b->joint.table->normalise(&args, full);
        if (status) return mbsri_joint_failed(m, d, i, status, "normalise");
        for (int k = 0; k < b->joint.n && b->lock.count; ++k) {
            if (isnan(b->lock.at[k])) *own++ = full[k];
        }
    }
    return MBSR_OK;
}
