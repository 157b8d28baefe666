/* The momentum form: y = (q, p, u), differential in q and p, algebraic in u.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * p are the generalised momenta, p_i = J_i^T m_i, with the impulses m of the joints (K = I, see
 * recursion/kinematics.c),
 *
 *   M_i V_i + m_i + sum_j H_j^T m_j = 0
 *
 * Differentiated, with sigma = m' - mu and (11):
 *
 *   p_i' = J_i'^T m_i + J_i^T sigma_i + tau_i
 *   sigma_i + sum_j H_j^T sigma_j = -f_i - M_i' V_i - sum_j H_j'^T m_j
 *
 * No pseudo-inverse and no derivative of one is in this. u follows from p where there is inertia,
 * and from the balance of forces where there is none. With the backward recursion (17) for momenta
 * (f -> 0, kII -> kI, tau -> p), ep = p - J^T (mbar + Mbar kI), and P the projection on what D
 * cannot take up,
 *
 *   0 = r - P (r + s e),    r_i = D_i u_i - (ep_i - J_i^T Mbar_i H_i V_pi)
 *
 * with e = tau - J^T (fbar + Mbar kII).
 *
 * P r is what of the momenta belongs to no inertia; P e = gamma are the forces there. s = 1 s makes
 * a momentum of a force. Projections need no basis: nothing can flip or turn. */
#include "forms/momentum.h"

#include "algebra/dense.h"
#include "dynamics/entry.h"
#include "forms/form.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/rates.h"
#include "sweeps/dynamics.h"

static int size(const mbsr_model *m)
{
    return m->nq + 2 * m->nu;
}

static int identify(const mbsr_model *m, mbsr_data *d, double *id)
{
    (void)d;
    for (int k = 0; k < m->nq + 2 * m->nu; ++k) id[k] = k < m->nq + m->nu ? 1.0 : 0.0;
    return MBSR_OK;
}

/* m and p at the state of mbsr_velocities.  reads M, V, H, J;  writes imp, p. */
void mbsri_momenta(const mbsr_model *m, mbsr_data *d, double *p)
{
    mbsri_zero(m->size_v, d->imp);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        double *imp = d->imp + b->v;
        /* m_i = -M_i V_i - sum_j H_j^T m_j */
        mbsri_ax(b->d, b->d, -1.0, d->M + b->dd, d->V + b->v, imp);
        mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, imp, d->imp + b->pred_v);
        /* p_i = J_i^T m_i */
        mbsri_zero((size_t)b->n, p + b->u);
        mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, imp, p + b->u);
    }
}

/* p' at the state of mbsr_forces, with rates and impulses.  reads imp, f, tau, H, J, their rates,
 * Mdot; writes sigma, pdot. */
static void momentum_rates(const mbsr_model *m, mbsr_data *d, double *pdot)
{
    mbsri_zero(m->size_v, d->sigma);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *imp = d->imp + b->v;
        double *sigma = d->sigma + b->v, *below = d->sigma + b->pred_v;
        /* sigma_i = -f_i - M_i' V_i - sum_j (H_j^T sigma_j + H_j'^T m_j) */
        for (int k = 0; k < b->d; ++k) sigma[k] -= d->f[b->v + (size_t)k];
        mbsri_ax(b->d, b->d, -1.0, d->Mdot + b->dd, d->V + b->v, sigma);
        mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, sigma, below);
        mbsri_atx(b->d, b->d_pred, -1.0, d->Hdot + b->dp, imp, below);
        /* p_i' = J_i'^T m_i + J_i^T sigma_i + tau_i */
        mbsri_copy((size_t)b->n, d->tau + b->iu, pdot + b->u);
        mbsri_atx(b->d, b->n, 1.0, d->Jdot + b->dn, imp, pdot + b->u);
        mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, sigma, pdot + b->u);
    }
}

/* ep at the state of mbsr_backward.  reads p, Mbar, G, kI, H, J;  writes impbar, ep. */
void mbsri_condense(const mbsr_model *m, mbsr_data *d, const double *p)
{
    mbsri_zero(m->size_v, d->impbar);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        double *mbar = d->impbar + b->v, *ep = d->ep + b->iu;
        /* mbar + Mbar kI,  ep = p - J^T (.),  m = (.) + G ep to the predecessor */
        mbsri_ax(b->d, b->d, 1.0, d->Mbar + b->dd, d->kI + b->v, mbar);
        mbsri_copy((size_t)b->n, p + b->u, ep);
        mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, mbar, ep);
        mbsri_ax(b->d, b->n, 1.0, d->G + b->dn, ep, mbar);
        mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, mbar, d->impbar + b->pred_v);
    }
}

/* The algebraic block.  reads ep, e, D, U, H, V, u;  writes F. */
static void balance(const mbsr_model *m, mbsr_data *d, double *F)
{
    const double s = 1.0;
    double *x = d->scratch + m->max_d, *projected = x + m->max_d;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *r = F + b->u;
        /* r = D u - ep + U^T H V_pi */
        mbsri_zero((size_t)b->d, x);
        mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->V + b->pred_v, x);
        for (int k = 0; k < b->n; ++k) r[k] = -d->ep[b->iu + k];
        mbsri_atx(b->d, b->n, 1.0, d->U + b->dn, x, r);
        mbsri_ax(b->n, b->n, 1.0, d->D + b->nn, d->u + b->iu, r);
        if (d->rank[i] == b->n) continue;
        /* r -= P (r + s e) */
        for (int k = 0; k < b->n; ++k) x[k] = r[k] + s * d->e[b->iu + k];
        mbsri_null_force(m, d, i, x, projected);
        for (int k = 0; k < b->n; ++k) r[k] -= projected[k];
    }
}

int mbsr_momenta(const mbsr_model *model, mbsr_data *data, double *p)
{
    const int status = mbsri_enter(model, data, p != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_momenta");
    if (status) return status;
    mbsri_momenta(model, data, p);
    return mbsri_check_result(model, data, (size_t)model->nu, p, "mbsr_momenta");
}

static int pack(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                double *y)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (status) return status;
    mbsri_momenta(m, d, y + m->nq);
    mbsri_copy((size_t)m->nq, q, y);
    mbsri_copy((size_t)m->nu, u, y + m->nq + m->nu);
    return MBSR_OK;
}

static int unpack(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                  double *u)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, y, q);
    mbsri_copy((size_t)m->nu, y + m->nq + m->nu, u);
    return MBSR_OK;
}

/* q' and p' at the state of y; then forces. */
int mbsri_momentum_derivatives(const mbsr_model *m, mbsr_data *d, double *qdot, double *pdot)
{
    int status = mbsri_coordinate_rates(m, d, qdot);
    if (!status) status = mbsri_rates(m, d);
    if (!status) status = mbsri_forces(m, d, NULL);
    if (status) return status;
    mbsri_momenta(m, d, pdot);
    momentum_rates(m, d, pdot);
    return MBSR_OK;
}

static int start(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *udot,
                 double *yp)
{
    (void)t, (void)y;
    mbsri_copy((size_t)m->nu, udot, yp + m->nq + m->nu);
    return mbsri_momentum_derivatives(m, d, yp, yp + m->nq);
}

static int residual(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *yp,
                    double *F)
{
    const double *p = y + m->nq, *u = p + m->nu;
    if (mbsri_sweeps_momentum_residual(m, d, t, y, yp, F)) {
        mbsri_remember(m, d, MBSRI_PENDING_FORWARD, y, u, NULL);
        return MBSR_OK;
    }
    int status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_momentum_derivatives(m, d, F, F + m->nq);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    /* q' - G u,  p' - (.) */
    for (int k = 0; k < m->nq + m->nu; ++k) F[k] = yp[k] - F[k];
    /* algebraic equations */
    mbsri_condense(m, d, p);
    balance(m, d, F + m->nq + m->nu);
    return MBSR_OK;
}

const mbsri_dae_form mbsri_form_momentum = {MBSR_DAE_MOMENTUM, size, identify, pack, unpack, start,
                                            residual};
