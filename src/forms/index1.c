/* The index-1 form of M. Arnold, (2), (29)-(32): y = (q, v), v_j = (eta_j, zeta_j) split by the
 * rank of D_j, with adjacent deficient bodies.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * S D S = X diag(lambda, 0) X^T with X = [R N] and S fixed. The null velocities go from the root to
 * the leaves as the null accelerations do (recursion/forward.c), G^T = D^+ J^T Mbar:
 *
 *   w_i = u_i + G_i^T H_i Vz_pi,    eta_i = R_i^T S^-1 w_i,    zeta_i = N_i^T S^-1 w_i
 *   Vz_i = -H_i Vz_pi - J_i (z_i - G_i^T H_i Vz_pi),    z_i = S N_i zeta_i             (29)
 *
 * Differentiated along the motion, zeta' cancels against the part of the accelerations that the
 * equations of motion leave open. With Y = Vz' - Az, delta_i = (G_i^T H_i)' Vz_pi,
 *
 *   eta_i' = R_i'^T S^-1 w_i + R_i^T S^-1 [ D_i^+ w0_i + delta_i + G_i^T H_i Y_pi ]        (32)
 *   0 = N_i^T S e_i
 *   Y_i = -H_i Y_pi - H_i' Vz_pi - J_i' (z_i - G_i^T H_i Vz_pi)
 *         - J_i (y_i - delta_i - G_i^T H_i Y_pi)
 *   y_i = S N_i' zeta_i + S N_i (N_i'^T S^-1 w_i + N_i^T S^-1 delta_i)
 *
 * where w0 is the load on the joint with the known accelerations, w of recursion/forward.c. bases.c
 * makes X a smooth function of the state and gives X', G'. */
#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "forms/bases.h"
#include "forms/form.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rates.h"

#include <mbsrank/driver.h>

static int index1_size(const mbsr_model *m)
{
    return m->nq + m->nu;
}

static int need_frame(mbsr_data *d)
{
    if (d->frame.known) return MBSR_OK;
    return mbsri_fail(&d->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                      "the index-1 form has no reference frame yet: call mbsr_dae_pack first");
}

static int index1_identify(const mbsr_model *m, mbsr_data *d, double *id)
{
    const int status = need_frame(d);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) id[k] = 1.0;
    double *own = d->v_given;
    for (int i = 1; i <= m->bodies; ++i) {
        if (m->body[i].group.head != i) continue;
        const mbsri_group g = mbsri_group_in_model(m, i);
        for (int k = 0; k < g.n; ++k) own[k] = k < d->frame.rank[i] ? 1.0 : 0.0;
        mbsri_group_scatter(m, &g, own, id + m->nq);
    }
    return MBSR_OK;
}

/* A group, and its part of what belongs to blocks. */
typedef struct block {
    mbsri_group g;
    const mbsri_body *head;
    int n, rank;
    const double *X, *Xdot, *s;
} block;

static block block_of(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    block k = {.g = mbsri_group_of(m, d, i), .head = b, .X = d->X + b->nn, .Xdot = d->Xdot + b->nn};
    k.n = k.g.n;
    k.rank = mbsri_group_rank(d, &k.g);
    k.s = d->s + k.g.ig;
    return k;
}

/* z = S N zeta with zeta = X_N^T S^-1 w. */
static void null_rate(const block *b, const double *zeta, double *z)
{
    mbsri_zero((size_t)b->n, z);
    mbsri_ax(b->n, b->n - b->rank, 1.0, b->X + b->rank * b->n, zeta, z);
    for (int k = 0; k < b->n; ++k) z[k] *= b->s[k];
}

/* v from u (by the caller's order) or, with `inverse`, u from v; w stays in the data.
 * reads X, s, G, H, J;  writes w, Az (Vz), carries, vec (z - G^T H Vz_pi). */
static void transform(const mbsr_model *m, mbsr_data *d, const double *from, double *to,
                      bool inverse)
{
    double *x = d->scratch, *scaled = x + m->most.d, *v = scaled + m->most.d;
    d->carries[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const block b = block_of(m, d, i);
        const double *G = d->G + b.head->dg;
        const int dim = b.head->d, n = b.n;
        double *w = d->w + b.g.ig, *z = d->vec + b.g.ig;
        const bool from_pred = mbsri_null_below(m, d, i, x);
        if (inverse) {
            /* w = S X v,  u = w - G^T x */
            mbsri_group_gather(m, &b.g, from, v);
            mbsri_zero((size_t)n, w);
            mbsri_ax(n, n, 1.0, b.X, v, w);
            for (int k = 0; k < n; ++k) w[k] *= b.s[k];
            mbsri_copy((size_t)n, w, scaled);
            if (from_pred) mbsri_atx(dim, n, -1.0, G, x, scaled);
            mbsri_group_scatter(m, &b.g, scaled, to);
        } else {
            /* w = u + G^T x,  v = X^T S^-1 w */
            mbsri_group_gather(m, &b.g, from, w);
            if (from_pred) mbsri_atx(dim, n, 1.0, G, x, w);
            for (int k = 0; k < n; ++k) scaled[k] = w[k] / b.s[k], v[k] = 0.0;
            mbsri_atx(n, n, 1.0, b.X, scaled, v);
            mbsri_group_scatter(m, &b.g, v, to);
        }
        null_rate(&b, v + b.rank, z);
        mbsri_null_pass(m, d, &b.g, b.rank < n, from_pred, x, z);
    }
}

/* delta = (G^T H)' Vz_pi = G'^T H Vz_pi + G^T H' Vz_pi; hv = H' Vz_pi. */
static void drift(const block *k, const mbsr_data *d, const double *x, double *hv, double *delta)
{
    const mbsri_body *b = k->head;
    mbsri_zero((size_t)b->d, hv);
    mbsri_ax(b->d, b->pred.d, 1.0, d->Hdot + b->dp, d->Az + b->pred.v, hv);
    mbsri_atx(b->d, k->n, 1.0, d->Gdot + b->dg, x, delta);
    mbsri_atx(b->d, k->n, 1.0, d->G + b->dg, hv, delta);
}

/* y_i of the derivation: S N' zeta + S N (N'^T S^-1 w + N^T S^-1 delta). */
static void null_drift(const block *b, const mbsr_data *d, const double *zeta, const double *delta,
                       double *y, double *scaled, double *weight)
{
    const int n = b->n, k0 = n - b->rank;
    const double *N = b->X + b->rank * n, *Ndot = b->Xdot + b->rank * n, *w = d->w + b->g.ig;
    for (int l = 0; l < k0; ++l) weight[l] = 0.0;
    for (int k = 0; k < n; ++k) scaled[k] = w[k] / b->s[k];
    mbsri_atx(n, k0, 1.0, Ndot, scaled, weight);
    for (int k = 0; k < n; ++k) scaled[k] = delta[k] / b->s[k];
    mbsri_atx(n, k0, 1.0, N, scaled, weight);
    for (int k = 0; k < n; ++k) y[k] = 0.0;
    mbsri_ax(n, k0, 1.0, Ndot, zeta, y);
    mbsri_ax(n, k0, 1.0, N, weight, y);
    for (int k = 0; k < n; ++k) y[k] *= b->s[k];
}

/* -zeta' = -(N'^T S^-1 w + N^T S^-1 (u' + delta)) into out[rank ..]; udot (n). */
static void null_slope(const block *b, const mbsr_data *d, const double *udot, const double *delta,
                       double *scaled, double *out)
{
    const int n = b->n, rank = b->rank;
    const double *w = d->w + b->g.ig;
    for (int k = rank; k < n; ++k) out[k] = 0.0;
    for (int k = 0; k < n; ++k) scaled[k] = w[k] / b->s[k];
    mbsri_atx(n, n - rank, -1.0, b->Xdot + rank * n, scaled, out + rank);
    for (int k = 0; k < n; ++k) scaled[k] = (udot[k] + delta[k]) / b->s[k];
    mbsri_atx(n, n - rank, -1.0, b->X + rank * n, scaled, out + rank);
}

/* Y of the bodies of a group from Y of the predecessor; y: the null drift, J-part z - G^T H Vz_pi
 * in vec; work: d. */
static void drift_velocities(const mbsr_model *m, mbsr_data *d, const block *of, const double *y,
                             double *work)
{
    for (int l = 0; l < of->g.members; ++l) {
        const int i = of->g.member[l];
        const mbsri_body *b = m->body + i;
        double *Y = d->Y + b->v;
        if (!d->carries[i]) continue;
        mbsri_zero((size_t)b->d, Y);
        mbsri_ax(b->d, b->n, -1.0, d->Jdot + b->dn, d->vec + b->group.iu, Y);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, y + b->group.iu - of->g.ig, Y);
        if (!d->carries[b->parent]) continue;
        /* H Y_pi + H' Vz_pi */
        mbsri_zero((size_t)b->d, work);
        mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->Y + b->pred.v, work);
        mbsri_ax(b->d, b->pred.d, 1.0, d->Hdot + b->dp, d->Az + b->pred.v, work);
        for (int k = 0; k < b->d; ++k) Y[k] -= work[k];
    }
}

/* -eta' and gamma, group by group, into F; with udot (u', as the caller's u) -zeta' instead of
 * gamma. reads v, and all that transform, the backward recursion, the rates and the frame left in
 * the data; writes A, Y, F. */
static void equations(const mbsr_model *m, mbsr_data *d, const double *v, const double *udot,
                      double *F)
{
    const int dm = m->most.d;
    double *x = d->scratch, *hv = x + dm, *hy = hv + dm, *delta = hy + dm, *rate = delta + dm;
    double *load = rate + dm, *y = load + dm, *scaled = y + dm, *weight = scaled + dm;
    double *own = weight + dm, *given = own + dm, *out = given + dm;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const block of = block_of(m, d, i);
        const mbsri_body *b = of.head;
        const int n = of.n, r = of.rank;
        const double *s = of.s, *w = d->w + of.g.ig, *e = d->e + of.g.ig;
        mbsri_group_gather(m, &of.g, v, own);
        mbsri_known_part(m, d, &of.g, load, rate); /* rate = D^+ w0 */
        mbsri_zero((size_t)n, delta);
        const bool from_pred = mbsri_null_below(m, d, i, x);
        if (from_pred) {
            drift(&of, d, x, hv, delta);
            mbsri_zero((size_t)b->d, hy);
            mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->Y + b->pred.v, hy);
        }
        null_drift(&of, d, own + r, delta, y, scaled, weight);
        if (udot) {
            mbsri_group_gather(m, &of.g, udot, given);
            null_slope(&of, d, given, delta, scaled, out);
        }
        /* rate + delta + G^T H Y_pi,  y - delta - G^T H Y_pi */
        if (from_pred) mbsri_atx(b->d, n, 1.0, d->G + b->dg, hy, delta);
        for (int k = 0; k < n; ++k) rate[k] += delta[k], y[k] -= delta[k];
        drift_velocities(m, d, &of, y, x);
        /* eta' = R'^T S^-1 w + R^T S^-1 rate */
        for (int k = 0; k < r; ++k) out[k] = 0.0;
        for (int k = 0; k < n; ++k) scaled[k] = w[k] / s[k];
        mbsri_atx(n, r, -1.0, of.Xdot, scaled, out);
        for (int k = 0; k < n; ++k) scaled[k] = rate[k] / s[k];
        mbsri_atx(n, r, -1.0, of.X, scaled, out);
        if (!udot) {
            /* gamma = N^T S e */
            for (int k = r; k < n; ++k) out[k] = 0.0;
            for (int k = 0; k < n; ++k) scaled[k] = s[k] * e[k];
            mbsri_atx(n, n - r, 1.0, of.X + r * n, scaled, out + r);
        }
        mbsri_group_scatter(m, &of.g, out, F);
    }
}

/* Masses and frame at (t, q): what transform needs. */
static int prepare_frame(const mbsr_model *m, mbsr_data *d, double t, const double *q)
{
    mbsri_zero((size_t)m->nu, d->u_given); /* masses do not depend on velocities */
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, d->u_given);
    if (!status) status = mbsri_backward_masses(m, d);
    return status ? status : mbsri_frame_align(m, d);
}

/* All that the equations need at (t, q), velocities u, but for v. */
static int evaluate_index1(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                           const double *u, double *qdot)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_coordinate_rates(m, d, qdot);
    if (!status) status = mbsri_rates(m, d);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (!status) status = mbsri_frame_align(m, d);
    return status ? status : mbsri_frame_rates(m, d);
}

/* A frame where there is none yet. */
static int index1_pack(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                       const double *u, double *y)
{
    int status = d->frame.known ? MBSR_OK : mbsri_frame_renew(m, d, t, q, u);
    if (status) return status;
    d->frame.used = true;
    status = prepare_frame(m, d, t, q);
    d->frame.used = false;
    if (status) return status;
    transform(m, d, u, y + m->nq, false);
    mbsri_copy((size_t)m->nq, q, y);
    return MBSR_OK;
}

static int index1_unpack(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                         double *u)
{
    int status = need_frame(d);
    if (status) return status;
    d->frame.used = true;
    status = prepare_frame(m, d, t, y);
    d->frame.used = false;
    if (status) return status;
    transform(m, d, y + m->nq, u, true);
    mbsri_copy((size_t)m->nq, y, q);
    return MBSR_OK;
}

/* q', eta' and gamma, or with udot zeta', at y: F gets minus the rates, plus gamma. */
static int blocks(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *udot,
                  double *F)
{
    const double *v = y + m->nq;
    int status = need_frame(d);
    if (status) return status;
    d->frame.used = true;
    status = prepare_frame(m, d, t, y);
    if (!status) {
        transform(m, d, v, d->u_given, true);
        status = evaluate_index1(m, d, t, y, d->u_given, F);
    }
    d->frame.used = false;
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) F[k] = -F[k];
    transform(m, d, v, d->u_given, true);
    equations(m, d, v, udot, F + m->nq);
    return MBSR_OK;
}

static int index1_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                           const double *yp, double *F)
{
    const int status = blocks(m, d, t, y, NULL, F);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) F[k] += yp[k];
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const block b = block_of(m, d, i);
        double *own = d->scratch, *rate = own + b.n;
        mbsri_group_gather(m, &b.g, F + m->nq, own);
        mbsri_group_gather(m, &b.g, yp + m->nq, rate);
        for (int k = 0; k < b.rank; ++k) own[k] += rate[k];
        mbsri_group_scatter(m, &b.g, own, F + m->nq);
    }
    return MBSR_OK;
}

static int index1_start(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                        const double *udot, double *yp)
{
    const int status = blocks(m, d, t, y, udot, yp);
    for (int k = 0; k < m->nq + m->nu; ++k) yp[k] = -yp[k];
    return status;
}

const mbsri_dae_form mbsri_form_index1 = {MBSR_DAE_INDEX1, index1_size,   index1_identify,
                                          index1_pack,     index1_unpack, index1_start,
                                          index1_residual};

int mbsr_index1_alignment(const mbsr_model *model, mbsr_data *data, double t, const double *y,
                          double *cosine)
{
    mbsr_data *d = data;
    int status = mbsri_enter_tree(model, d, y && cosine, MBSRI_STAGE_NONE, "mbsr_index1_alignment");
    if (!status) status = need_frame(d);
    if (status) return status;
    d->frame.used = true;
    status = prepare_frame(model, d, t, y);
    d->frame.used = false;
    if (!status)
        status = mbsri_check_result(model, d, 1, &d->frame.alignment, "mbsr_index1_alignment");
    if (!status || status == MBSR_FRAME_TURNED) *cosine = d->frame.alignment;
    return status;
}

/* Whether a range or null space of two dimensions or more may turn within itself. */
static bool may_spin(const mbsr_model *m, const mbsr_data *d)
{
    for (int i = 1; i <= m->bodies; ++i) {
        const int n = m->body[i].group.n, r = d->frame.rank[i];
        if (m->body[i].group.head == i && r > 0 && r < n && n > 2) return true;
    }
    return false;
}

int mbsr_index1_renew(const mbsr_model *model, mbsr_data *data, double t, const double *y,
                      double *yp, int *restart)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter_tree(m, d, y && yp, MBSRI_STAGE_NONE, "mbsr_index1_renew");
    if (!status) status = need_frame(d);
    if (status) return status;
    d->frame.used = true;
    status = prepare_frame(m, d, t, y);
    d->frame.used = false;
    if (status) return status;
    /* the aligned bases are the new reference: y stays, only the rates of the bases may change */
    mbsri_copy(m->size.nn, d->X, d->X_frame);
    if (restart) *restart = may_spin(m, d);
    double *zeta_rate = d->v_given;
    mbsri_copy((size_t)m->nu, yp + m->nq, zeta_rate);
    status = blocks(m, d, t, y, NULL, yp);
    for (int k = 0; k < m->nq + m->nu; ++k) yp[k] = -yp[k];
    for (int i = 1; i <= m->bodies; ++i) {
        if (m->body[i].group.head != i) continue;
        const mbsri_group g = mbsri_group_in_model(m, i);
        double *own = d->scratch, *rate = own + g.n;
        mbsri_group_gather(m, &g, yp + m->nq, own);
        mbsri_group_gather(m, &g, zeta_rate, rate);
        for (int k = d->frame.rank[i]; k < g.n; ++k) own[k] = rate[k];
        mbsri_group_scatter(m, &g, own, yp + m->nq);
    }
    if (status) return status;
    return mbsri_check_result(m, d, (size_t)(m->nq + m->nu), yp, "mbsr_index1_renew");
}

int mbsr_index1_reset(const mbsr_model *model, mbsr_data *data)
{
    const int status = mbsri_enter_tree(model, data, true, MBSRI_STAGE_NONE, "mbsr_index1_reset");
    if (!status) data->frame.known = false;
    return status;
}
