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
 * and from the balance of forces where there is none. Group by group (recursion/group.h),
 *
 *   0 = s r - P (s r + e)
 *   r_i = D_i u_i - (ep_i - J_i^T Mbar_i H_i V_pi)     momenta that u does not account for
 *   e   = tau - J^T (fbar + Mbar kII)                  joint forces
 *   ep  = p - J^T (mbar + Mbar kI)                     the same of momenta: (17) with f -> 0,
 *                                                      kII -> kI, tau -> p gives mbar
 *
 * with the projection P on the directions that D gives no inertia, and s, which makes a force of a
 * momentum: the rate typical of the model where a joint or group has inertia in some directions
 * alone, else 1. P r are momenta that belong to no inertia, P e = gamma the forces in those
 * directions. Projections need no basis, so that nothing can flip or rotate.
 *
 * With closures y = (q, p, u, Lambda, Eta), and F has their rows behind these: loops.c. */
#include "forms/momentum.h"

#include "algebra/dense.h"
#include "dynamics/entry.h"
#include "forms/form.h"
#include "forms/loops.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/momentum.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/rates.h"
#include "sweeps/dynamics.h"

static int momentum_size(const mbsr_model *m)
{
    return m->nq + 2 * m->nu + mbsri_loops_size(m);
}

static int momentum_identify(const mbsr_model *m, mbsr_data *d, double *id)
{
    (void)d;
    for (int k = 0; k < momentum_size(m); ++k) id[k] = k < m->nq + m->nu ? 1.0 : 0.0;
    return MBSR_OK;
}

void mbsri_momenta(const mbsr_model *m, mbsr_data *d, double *p)
{
    mbsri_zero(m->size.v, d->imp);
    for (int i = m->bodies; i >= 1; --i) mbsri_momentum_of(m, d, i, p + m->body[i].u);
}

/* p' at the state of mbsr_stage_forces, with rates and impulses. */
static void momentum_rates(const mbsr_model *m, mbsr_data *d, double *pdot)
{
    mbsri_zero(m->size.v, d->sigma);
    for (int i = m->bodies; i >= 1; --i) mbsri_momentum_rate_of(m, d, i, pdot + m->body[i].u);
}

void mbsri_condense(const mbsr_model *m, mbsr_data *d, const double *p)
{
    mbsri_zero(m->size.v, d->impbar);
    for (int i = m->bodies; i >= 1; --i) mbsri_condense_of(m, d, i, p + m->body[i].u);
}

int mbsr_momenta(const mbsr_model *model, mbsr_data *data, double *p)
{
    const int status = mbsri_enter(model, data, p != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_momenta");
    if (status) return status;
    mbsri_momenta(model, data, p);
    return mbsri_check_result(model, data, (size_t)model->nu, p, "mbsr_momenta");
}

static int momentum_pack(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                         const double *u, double *y)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (status) return status;
    mbsri_momenta(m, d, y + m->nq);
    mbsri_copy((size_t)m->nq, q, y);
    mbsri_copy((size_t)m->nu, u, y + m->nq + m->nu);
    return m->rows > 0 ? mbsri_loops_pack(m, d, y + m->nq + 2 * m->nu) : MBSR_OK;
}

static int momentum_unpack(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                           double *u)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, y, q);
    mbsri_copy((size_t)m->nu, y + m->nq + m->nu, u);
    return MBSR_OK;
}

/* q' and p' at the state of y; then forces. */
int mbsri_momentum_derivatives(const mbsr_model *m, mbsr_data *d, const double *lambda,
                               double *qdot, double *pdot)
{
    int status = mbsri_coordinate_rates(m, d, qdot);
    if (!status) status = mbsri_rates(m, d);
    if (!status) status = mbsri_forces(m, d, NULL, lambda);
    if (status) return status;
    mbsri_momenta(m, d, pdot);
    momentum_rates(m, d, pdot);
    return MBSR_OK;
}

static int momentum_start(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                          const double *udot, double *yp)
{
    (void)t, (void)y;
    mbsri_copy((size_t)m->nu, udot, yp + m->nq + m->nu);
    return mbsri_momentum_derivatives(m, d, NULL, yp, yp + m->nq);
}

static int momentum_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                             const double *yp, double *F)
{
    const double *p = y + m->nq, *u = p + m->nu, *x = u + m->nu, *xp = yp + m->nq + 2 * m->nu;
    double *F_x = F + m->nq + 2 * m->nu;
    if (m->rows > 0) mbsri_loops_take(m, d, x, xp);
    int status = mbsri_sweeps_momentum_residual(m, d, t, y, yp, F);
    if (!status && m->rows > 0) status = mbsri_loops_residual(m, d, x, xp, F_x);
    if (!status) mbsri_remember(m, d, MBSRI_PENDING_FORWARD, y, u, NULL);
    if (status != MBSRI_NOT_SERVED) return status;
    status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status && m->rows > 0) status = mbsri_closure_jacobians(m, d);
    const double *lambda = m->rows > 0 ? d->loop_lambda : NULL;
    if (!status) status = mbsri_momentum_derivatives(m, d, lambda, F, F + m->nq);
    if (!status && m->rows > 0) status = mbsri_loops_coordinate_rates(m, d, F);
    if (!status && m->rows > 0) status = mbsri_loops_residual(m, d, x, xp, F_x);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    /* q' - G u,  p' - (.) */
    for (int k = 0; k < m->nq + m->nu; ++k) F[k] = yp[k] - F[k];
    /* algebraic equations */
    mbsri_condense(m, d, p);
    double *balance = d->vec;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        mbsri_balance_of(m, d, &g, balance);
        mbsri_group_scatter(m, &g, balance, F + m->nq + m->nu);
    }
    return MBSR_OK;
}

const mbsri_dae_form mbsri_form_momentum = {MBSR_DAE_MOMENTUM, momentum_size,   momentum_identify,
                                            momentum_pack,     momentum_unpack, momentum_start,
                                            momentum_residual};
