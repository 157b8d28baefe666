/* The steps of the momentum form for one body, with K = I (see kinematics.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/momentum.h"

#include "algebra/dense.h"
#include "recursion/rank.h"

void mbsri_momentum_of(const mbsr_model *m, mbsr_data *d, int i, double *p)
{
    const mbsri_body *b = m->body + i;
    double *imp = d->imp + b->v;
    /* m_i = -M_i V_i - sum_j H_j^T m_j */
    mbsri_ax(b->d, b->d, -1.0, d->M + b->dd, d->V + b->v, imp);
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, imp, d->imp + b->pred_v);
    /* p_i = J_i^T m_i */
    mbsri_zero((size_t)b->n, p);
    mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, imp, p);
}

void mbsri_momentum_rate_of(const mbsr_model *m, mbsr_data *d, int i, double *pdot)
{
    const mbsri_body *b = m->body + i;
    const double *imp = d->imp + b->v;
    double *sigma = d->sigma + b->v, *below = d->sigma + b->pred_v;
    /* sigma_i = -f_i - M_i' V_i - sum_j (H_j^T sigma_j + H_j'^T m_j) */
    for (int k = 0; k < b->d; ++k) sigma[k] -= d->f[b->v + (size_t)k];
    mbsri_ax(b->d, b->d, -1.0, d->Mdot + b->dd, d->V + b->v, sigma);
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, sigma, below);
    mbsri_atx(b->d, b->d_pred, -1.0, d->Hdot + b->dp, imp, below);
    /* p_i' = J_i'^T m_i + J_i^T sigma_i + tau_i */
    mbsri_copy((size_t)b->n, d->tau + b->iu, pdot);
    mbsri_atx(b->d, b->n, 1.0, d->Jdot + b->dn, imp, pdot);
    mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, sigma, pdot);
}

void mbsri_condense_of(const mbsr_model *m, mbsr_data *d, int i, const double *p)
{
    const mbsri_body *b = m->body + i;
    double *mbar = d->impbar + b->v, *ep = d->ep + b->iu;
    /* mbar + Mbar kI,  ep = p - J^T (.),  m = (.) + G ep to the predecessor */
    mbsri_ax(b->d, b->d, 1.0, d->Mbar + b->dd, d->kI + b->v, mbar);
    mbsri_copy((size_t)b->n, p, ep);
    mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, mbar, ep);
    mbsri_ax(b->d, b->n, 1.0, d->G + b->dn, ep, mbar);
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, mbar, d->impbar + b->pred_v);
}

void mbsri_balance_of(const mbsr_model *m, mbsr_data *d, int i, double *F)
{
    const mbsri_body *b = m->body + i;
    const double s = 1.0;
    double *x = d->scratch + m->max_d, *projected = x + m->max_d;
    /* r = D u - ep + U^T H V_pi */
    mbsri_zero((size_t)b->d, x);
    mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->V + b->pred_v, x);
    for (int k = 0; k < b->n; ++k) F[k] = -d->ep[b->iu + k];
    mbsri_atx(b->d, b->n, 1.0, d->U + b->dn, x, F);
    mbsri_ax(b->n, b->n, 1.0, d->D + b->nn, d->u + b->iu, F);
    if (d->rank[i] == b->n) return;
    /* r -= P (r + s e) */
    for (int k = 0; k < b->n; ++k) x[k] = F[k] + s * d->e[b->iu + k];
    mbsri_null_force(m, d, i, x, projected);
    for (int k = 0; k < b->n; ++k) F[k] -= projected[k];
}
