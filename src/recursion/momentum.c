/* The steps of the momentum form for one body, with K = I (see kinematics.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/momentum.h"

#include "algebra/dense.h"
#include "recursion/flexible_factors.h"
#include "recursion/inertia.h"
#include "recursion/modal.h"
#include "recursion/rank.h"

void mbsri_momentum_of(const mbsr_model *m, mbsr_data *d, int i, double *p)
{
    const mbsri_body *b = m->body + i;
    double *imp = d->imp + b->v;
    /* m_i = -M_i V_i - sum_j H_j^T m_j */
    mbsri_inertia_times(b, d->p + b->p, d->M + b->dd, -1.0, d->V + b->v, imp);
    mbsri_atx_often(b->d, b->pred.d, -1.0, d->H + b->dp, imp, d->imp + b->pred.v);
    /* p_i = J_i^T m_i + a_i u_i */
    for (int k = 0; k < b->n; ++k) p[k] = b->mass.armature[k] * d->u[b->iu + k];
    mbsri_add_rates(b, d->J + b->dn, imp, p);
}

void mbsri_momentum_rate_of(const mbsr_model *m, mbsr_data *d, int i, double *pdot)
{
    const mbsri_body *b = m->body + i;
    const double *imp = d->imp + b->v;
    double *sigma = d->sigma + b->v, *below = d->sigma + b->pred.v;
    /* sigma_i = -f_i - M_i' V_i - sum_j (H_j^T sigma_j + H_j'^T m_j) */
    for (int k = 0; k < b->d; ++k) sigma[k] -= d->f[b->v + (size_t)k];
    if (b->d == 6)
        mbsri_ax_often(6, 6, -1.0, d->Mdot + b->dd, d->V + b->v, sigma);
    else
        mbsri_ax_long(b->d, b->d, -1.0, d->Mdot + b->dd, d->V + b->v, sigma);
    mbsri_atx_often(b->d, b->pred.d, -1.0, d->H + b->dp, sigma, below);
    mbsri_atx_often(b->d, b->pred.d, -1.0, d->Hdot + b->dp, imp, below);
    /* p_i' = J_i'^T m_i + J_i^T sigma_i + tau_i */
    mbsri_copy((size_t)b->n, d->tau + b->iu, pdot);
    mbsri_add_rates_dot(b, d->Jdot + b->dn, imp, pdot);
    mbsri_add_rates(b, d->J + b->dn, sigma, pdot);
}

void mbsri_condense_of(const mbsr_model *m, mbsr_data *d, int i, const double *p)
{
    const mbsri_body *b = m->body + i;
    double *mbar = d->impbar + b->v, *ep = d->ep + b->group.iu;
    /* mbar + Mbar kI,  ep = p - J^T (.),  m = (.) + G ep to the predecessor */
    double *sum = d->scratch;
    mbsri_copy((size_t)b->n, p, ep);
    if (mbsri_in_factors(d, i)) { /* kI = 0 */
        mbsri_factors_load(m, d, i, ep, mbar);
        mbsri_atx_often(b->d, b->pred.d, -1.0, d->H + b->dp, mbar, d->impbar + b->pred.v);
        return;
    }
    mbsri_copy((size_t)b->d, mbar, sum);
    mbsri_ax(b->d, b->d, 1.0, d->Mbar + b->dd, d->kI + b->v, sum);
    mbsri_group_load(m, d, i, d->impbar, d->kI, ep, sum, sum + m->most.d);
    if (mbsri_heads(m, d, i)) mbsri_copy((size_t)b->d, sum, mbar);
    mbsri_atx_often(b->d, b->pred.d, -1.0, d->H + b->dp, sum, d->impbar + b->pred.v);
}

void mbsri_balance_of(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, double *F)
{
    const mbsri_body *b = m->body + g->member[0];
    double *x = d->scratch + m->most.d, *projected = x + m->most.d;
    /* r = D u - ep + U^T H V_pi */
    mbsri_zero((size_t)b->d, x);
    mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->V + b->pred.v, x);
    for (int k = 0; k < g->n; ++k) F[k] = -d->ep[g->ig + k];
    const bool factored = mbsri_in_factors(d, g->member[0]);
    if (factored) {
        mbsri_factors_see(m, d, g->member[0], 1.0, x, F);
        mbsri_factors_multiply(m, d, g->member[0], d->u + b->iu, F);
    } else {
        mbsri_atx(b->d, g->n, 1.0, d->U + b->dg, x, F);
    }
    for (int k = 0; k < g->members && !factored; ++k) {
        const mbsri_body *member = m->body + g->member[k];
        mbsri_ax(g->n, member->n, 1.0, d->D + b->nn + (size_t)((member->group.iu - g->ig) * g->n),
                 d->u + member->iu, F);
    }
    if (g->members > 1 && !mbsri_coupled(m, d, g)) {
        /* as if joint by joint */
        mbsri_group_separate(m, d, g, F, d->scratch);
        for (int k = 0; k < g->members; ++k) {
            const mbsri_body *member = m->body + g->member[k];
            if (d->rank[g->member[k]] == member->n) continue;
            for (int l = 0; l < member->n; ++l)
                F[member->group.iu - g->ig + l] = -d->e[member->group.iu + l];
        }
        return;
    }
    const int rank = mbsri_group_rank(d, g);
    if (rank == g->n) return;
    /* s r - P (s r + e) */
    const double s = mbsri_momentum_rate(m, g->n, rank);
    for (int k = 0; k < g->n; ++k) {
        F[k] *= s;
        x[k] = F[k] + d->e[g->ig + k];
    }
    mbsri_null_force(m, d, g, x, projected);
    for (int k = 0; k < g->n; ++k) F[k] -= projected[k];
}
