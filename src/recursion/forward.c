/* Forward recursion that skips rank-deficient bodies, (18)-(24), and the residual (25), with K = I.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * D u' fixes only the range components of u'; the null components z = (I - D^+ D) u' are fixed by
 * no equation of second order. The accelerations are split into a part that is known without them
 * and a part that carries them, A = A0 + Az:
 *
 *   A0_i = -H_i A0_pi - kII_i - J_i D_i^+ w_i,  w_i = e_i - J_i^T Mbar_i H_i A0_pi     (19), (20)
 *   Az_i = -H_i Az_pi - J_i (z_i - D_i^+ J_i^T Mbar_i H_i Az_pi),   Az_0 = 0
 *   residual_i = D_i u_i' - (w_i - J_i^T Mbar_i H_i Az_pi)                        (25)
 *
 * with e = tau - J^T fbar - J^T Mbar kII. Mbar_i Az_i = 0 always (Lemma 3), so Az_i = 0 wherever
 * Mbar_i is non-singular: the second line runs only inside groups of rank-deficient bodies. With
 * isolated ones, the paper's assumption (23), this is (25a) behind regular bodies and (25b) behind
 * deficient ones; adjacent ones need no assumption. */
#include "recursion/forward.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"

#include <math.h>

bool mbsri_null_below(const mbsr_model *m, const mbsr_data *d, int i, double *x)
{
    const mbsri_body *b = m->body + i;
    if (!d->carries[b->parent]) return false;
    mbsri_zero((size_t)b->d, x);
    mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->Az + b->pred_v, x);
    return true;
}

/* A body whose own mass is regular stands still, unless that mass is so small beside others that
 * the rank decision took it for zero: then more is left of x + J z than rounding. */
void mbsri_null_pass(const mbsr_model *m, mbsr_data *d, int i, bool own, bool below,
                     const double *x, double *z)
{
    const mbsri_body *b = m->body + i;
    double *Az = d->Az + b->v;
    if (below) mbsri_atx(b->d, b->n, -1.0, d->G + b->dn, x, z);
    d->carries[i] = (below || own) && !b->regular;
    if (!below && !own) return;
    mbsri_zero((size_t)b->d, Az);
    mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, z, Az);
    for (int k = 0; k < b->d; ++k) {
        const double known = below ? x[k] : 0.0, size = fabs(Az[k]) + fabs(known);
        Az[k] -= known;
        if (fabs(Az[k]) > 1e-3 * size) d->carries[i] = true;
    }
}

/* A0 of body i and w = e - U^T H A0_pi.  reads e, U, Dinv, H, J, kII;  writes A and w (n). */
void mbsri_known_part(const mbsr_model *m, mbsr_data *d, int i, double *w, double *rate)
{
    const mbsri_body *b = m->body + i;
    double *A = d->A + b->v;
    /* A = H A0_pi,  w = e - U^T A */
    mbsri_zero((size_t)b->d, A);
    mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->A + b->pred_v, A);
    mbsri_copy((size_t)b->n, d->e + b->iu, w);
    mbsri_atx(b->d, b->n, -1.0, d->U + b->dn, A, w);
    /* rate = D^+ w,  A = -(H A0_pi + kII + J rate) */
    mbsri_zero((size_t)b->n, rate);
    mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, w, rate);
    mbsri_ax(b->d, b->n, 1.0, d->J + b->dn, rate, A);
    for (int k = 0; k < b->d; ++k) A[k] = -A[k] - d->kII[b->v + (size_t)k];
}

void mbsri_forward(const mbsr_model *m, mbsr_data *d, const double *udot, double *residual)
{
    double *x = d->scratch + m->max_d, *rate = x + m->max_d;
    mbsri_gather(m, udot, d->udot);
    d->accelerated = false; /* A is overwritten */
    d->carries[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *w = d->out + b->iu;
        /* A0, w */
        mbsri_known_part(m, d, i, w, rate);
        /* x = H Az_pi,  w -= U^T x,  Az from z = (I - D^+ D) u' */
        const bool below = mbsri_null_below(m, d, i, x), own = d->rank[i] < b->n;
        if (below) mbsri_atx(b->d, b->n, -1.0, d->U + b->dn, x, w);
        double *z = d->vec + b->iu;
        mbsri_zero((size_t)b->n, z);
        if (own) mbsri_null_part(m, d, i, d->udot + b->iu, z);
        mbsri_null_pass(m, d, i, own, below, x, z);
        /* residual = D u' - w */
        for (int k = 0; k < b->n; ++k) w[k] = -w[k];
        mbsri_ax(b->n, b->n, 1.0, d->D + b->nn, d->udot + b->iu, w);
    }
    mbsri_scatter(m, d->out, residual);
}

int mbsri_forward_by_stages(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u, const double *tau, double *udot)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, tau);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    double *w = d->scratch + m->max_d;
    for (int i = 1; i <= m->bodies; ++i) mbsri_known_part(m, d, i, w, udot + m->body[i].u);
    status = mbsri_check_ranks(m, d);
    const int overflow = mbsri_check_result(m, d, (size_t)m->nu, udot, "mbsr_forward_dynamics");
    if (overflow) return overflow;
    return status;
}
