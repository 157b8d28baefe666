/* Inverse dynamics: accelerations (9) root to leaves, equilibrium (11) leaves to root, with K = I.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   A_i  = -(H_i A_pi + J_i u_i' + kII_i)
 *   mu_i = f_i - M_i A_i - sum_j H_j^T mu_j,    out_i = J_i^T mu_i + a_i u_i' - tau_i
 *
 * with the armature a_i, entry by entry. */
#include "recursion/inverse.h"

#include "algebra/dense.h"
#include "model/query.h"
#include "recursion/inertia.h"

void mbsri_open_reaction(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    double *mu = d->mu + b->v;
    /* mu_i = f_i - M_i A_i, to which the successors add */
    mbsri_copy((size_t)b->d, d->f + b->v, mu);
    mbsri_inertia_times(b, d->p + b->p, d->M + b->dd, -1.0, d->A + b->v, mu);
}

void mbsri_accelerate(const mbsr_model *m, mbsr_data *d, int i, const double *udot)
{
    const mbsri_body *b = m->body + i;
    double *A = d->A + b->v;
    /* A_i = -(H_i A_pi + J_i u_i' + kII_i) */
    mbsri_zero((size_t)b->d, A);
    mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, d->A + b->pred.v, A);
    mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, udot, A);
    for (int k = 0; k < b->d; ++k) A[k] -= d->kII[b->v + (size_t)k];
    mbsri_open_reaction(m, d, i);
}

void mbsri_react(const mbsr_model *m, mbsr_data *d, int i, double *out)
{
    const mbsri_body *b = m->body + i;
    const double *mu = d->mu + b->v;
    /* J_i^T mu_i - tau_i */
    for (int k = 0; k < b->n; ++k) out[k] = -d->tau[b->iu + k];
    mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, mu, out);
    /* mu_pi -= H_i^T mu_i */
    mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, mu, d->mu + b->pred.v);
}

/* reads H, J, kII, M, f, tau of the stages before;  writes A, mu, out.
 * cost: d^2 + 2 d d_pred + 2 d n. */
void mbsri_inverse(const mbsr_model *m, mbsr_data *d, const double *udot)
{
    mbsri_gather(m, udot, d->udot);
    for (int i = 1; i <= m->bodies; ++i) mbsri_accelerate(m, d, i, d->udot + m->body[i].iu);
    mbsri_zero((size_t)m->root.d, d->mu);
    for (int i = m->bodies; i >= 1; --i) mbsri_react(m, d, i, d->out + m->body[i].iu);
    for (int k = 0; k < m->nu; ++k) d->out[k] += m->armature[k] * d->udot[k];
    d->accelerated = true;
}
