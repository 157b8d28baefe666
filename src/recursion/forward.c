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
#include "recursion/flexible_factors.h"
#include "recursion/kinematics.h"
#include "recursion/modal.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"

#include <math.h>

bool mbsri_null_below(const mbsr_model *m, const mbsr_data *d, int i, double *x)
{
    const mbsri_body *b = m->body + i;
    if (!d->carries[b->parent]) return false;
    mbsri_zero((size_t)b->d, x);
    mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->Az + b->pred.v, x);
    return true;
}

void mbsri_null_velocity(const mbsr_model *m, mbsr_data *d, int i, const double *x, const double *z)
{
    const mbsri_body *b = m->body + i;
    double *Az = d->Az + b->v;
    d->carries[i] = !b->mass.regular;
    mbsri_zero((size_t)b->d, Az);
    mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, z, Az);
    for (int k = 0; k < b->d; ++k) {
        const double known = x ? x[k] : 0.0, size = fabs(Az[k]) + fabs(known);
        Az[k] -= known;
        if (fabs(Az[k]) > 1e-3 * size) d->carries[i] = true;
    }
}

void mbsri_null_pass(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, bool own, bool below,
                     double *x, double *z)
{
    const mbsri_body *b = m->body + g->member[0];
    if (below) mbsri_atx(b->d, g->n, -1.0, d->G + b->dg, x, z);
    for (int k = 0; k < g->members; ++k) d->carries[g->member[k]] = false;
    if (!below && !own) return;
    mbsri_null_velocity(m, d, g->member[0], below ? x : NULL, z);
    for (int k = 1; k < g->members; ++k) {
        const int i = g->member[k];
        const bool moved = mbsri_null_below(m, d, i, x);
        mbsri_null_velocity(m, d, i, moved ? x : NULL, z + m->body[i].group.iu - g->ig);
    }
}

/* A0 of the group and w = e - U^T H A0_pi.  reads e, U, Dinv, H, J, kII;  writes A and w (n). */
void mbsri_known_part(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, double *w,
                      double *rate)
{
    const mbsri_body *b = m->body + g->member[0];
    double *A = d->A + b->v;
    /* A = H A0_pi,  w = e - U^T A */
    mbsri_zero((size_t)b->d, A);
    mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->A + b->pred.v, A);
    mbsri_copy((size_t)g->n, d->e + g->ig, w);
    if (mbsri_in_factors(d, g->member[0])) { /* H ends with the frame, kII = 0 */
        mbsri_factors_see(m, d, g->member[0], -1.0, A, w);
        mbsri_factors_solve(m, d, g->member[0], w, rate);
        for (int k = 0; k < MBSRI_FRAME_ROWS; ++k) A[k] = -A[k];
        mbsri_copy((size_t)g->n, rate, A + MBSRI_FRAME_ROWS);
        return;
    }
    mbsri_atx(b->d, g->n, -1.0, d->U + b->dg, A, w);
    /* rate = D^+ w,  A = -(H A0_pi + kII + J rate), member by member */
    mbsri_zero((size_t)g->n, rate);
    mbsri_ax(g->n, g->n, 1.0, d->Dinv + b->nn, w, rate);
    for (int i = 0; i < g->members; ++i) {
        b = m->body + g->member[i];
        A = d->A + b->v;
        if (i > 0) {
            mbsri_zero((size_t)b->d, A);
            mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->A + b->pred.v, A);
        }
        mbsri_ax(b->d, b->n, 1.0, d->J + b->dn, rate + b->group.iu - g->ig, A);
        for (int k = 0; k < b->d; ++k) A[k] = -A[k] - d->kII[b->v + (size_t)k];
    }
}

void mbsri_forward(const mbsr_model *m, mbsr_data *d, const double *udot, double *residual)
{
    double *x = d->scratch + m->most.d, *rate = x + m->most.d, *given = rate + m->most.d;
    d->accelerated = false; /* A is overwritten */
    d->carries[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_body *b = m->body + i;
        const mbsri_group g = mbsri_group_of(m, d, i);
        double *w = d->w + g.ig;
        /* A0, w */
        mbsri_known_part(m, d, &g, w, rate);
        mbsri_group_gather(m, &g, udot, given);
        /* x = H Az_pi,  w -= U^T x,  Az from z = (I - D^+ D) u' */
        const bool below = mbsri_null_below(m, d, i, x), own = mbsri_group_rank(d, &g) < g.n;
        if (below) mbsri_atx(b->d, g.n, -1.0, d->U + b->dg, x, w);
        double *z = d->vec + g.ig;
        mbsri_zero((size_t)g.n, z);
        if (own) mbsri_null_part(m, d, &g, given, z);
        mbsri_null_pass(m, d, &g, own, below, x, z);
        /* residual = D u' - w */
        for (int k = 0; k < g.n; ++k) w[k] = -w[k];
        mbsri_ax(g.n, g.n, 1.0, d->D + b->nn, given, w);
        mbsri_group_scatter(m, &g, w, residual);
    }
}

void mbsri_forward_with_null(const mbsr_model *m, mbsr_data *d, double *udot, double *residual)
{
    mbsri_forward(m, d, udot, residual);
    double *x = d->scratch + m->most.d, *change = x + m->most.d;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        mbsri_group_gather(m, &g, residual, x);
        mbsri_zero((size_t)g.n, change);
        mbsri_ax(g.n, g.n, -1.0, d->Dinv + m->body[g.member[0]].nn, x, change);
        mbsri_group_gather(m, &g, udot, x);
        for (int k = 0; k < g.n; ++k) x[k] += change[k];
        mbsri_group_scatter(m, &g, x, udot);
    }
}

int mbsri_forward_by_stages(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u, const double *tau, double *udot)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, tau, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    double *w = d->scratch + m->most.d, *rate = w + m->most.d;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        mbsri_known_part(m, d, &g, w, rate);
        mbsri_group_scatter(m, &g, rate, udot);
    }
    status = mbsri_check_ranks(m, d);
    const int overflow = mbsri_check_result(m, d, (size_t)m->nu, udot, "mbsr_forward_dynamics");
    if (overflow) return overflow;
    return status;
}
