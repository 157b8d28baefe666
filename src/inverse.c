/* Inverse dynamics: accelerations (9) root to leaves, equilibrium (11) leaves to root, joint forces
 * J^T mu.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include "dense.h"
#include "fast/fast.h"

/* reads H, J, kII, M, f, tau of the stages before;  writes A, mu, out = J^T mu - tau.  cost: d^2 +
 * 2 d d_pred + 2 d n. */
void mbsri_inverse_sweeps(const mbsr_model *m, mbsr_data *d, const double *udot)
{
    mbsri_gather(m, udot, d->udot);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *A = d->A + b->v, *mu = d->mu + b->v;
        /* A_i = -(H_i A_pi + J_i u_i' + kII_i) */
        mbsri_zero((size_t)b->d, A);
        mbsri_ax(b->d, b->d_pred, -1.0, d->H + b->dp, d->A + b->pred_v, A);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, d->udot + b->iu, A);
        for (int k = 0; k < b->d; ++k) A[k] -= d->kII[b->v + (size_t)k];
        /* mu_i = f_i - M_i A_i, to which the successors add */
        mbsri_copy((size_t)b->d, d->f + b->v, mu);
        mbsri_ax(b->d, b->d, -1.0, d->M + b->dd, A, mu);
    }
    mbsri_zero((size_t)m->root.d, d->mu);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *mu = d->mu + b->v;
        /* J_i^T mu_i - tau_i */
        for (int k = 0; k < b->n; ++k) d->out[b->iu + k] = -d->tau[b->iu + k];
        mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, mu, d->out + b->iu);
        /* mu_pi -= H_i^T mu_i */
        mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, mu, d->mu + b->pred_v);
    }
    d->accelerated = true;
}

int mbsr_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                          const double *u, const double *udot, double *tau)
{
    int status =
        mbsri_enter(model, data, q && u && udot && tau, MBSRI_STAGE_NONE, "mbsr_inverse_dynamics");
    if (status) return status;
    if (mbsri_finite((size_t)model->nu, udot) &&
        mbsri_fast_inverse_dynamics(model, data, t, q, u, udot, tau)) {
        mbsri_remember(model, data, MBSRI_PENDING_INVERSE, q, u, udot);
        return MBSR_OK;
    }
    status = mbsr_positions(model, data, t, q);
    if (!status) status = mbsr_velocities(model, data, u);
    if (!status) status = mbsr_forces(model, data, NULL);
    if (status) return status;
    mbsri_inverse_sweeps(model, data, udot);
    mbsri_scatter(model, data->out, tau);
    return mbsri_finite((size_t)model->nu, tau) ? MBSR_OK : mbsri_report_not_finite(model, data);
}

int mbsr_accelerations(const mbsr_model *model, mbsr_data *data, const double *udot)
{
    const int status =
        mbsri_enter(model, data, udot != NULL, MBSRI_STAGE_FORCES, "mbsr_accelerations");
    if (status) return status;
    mbsri_inverse_sweeps(model, data, udot);
    return mbsri_finite((size_t)model->nu, data->out) ? MBSR_OK
                                                      : mbsri_report_not_finite(model, data);
}

int mbsr_bias_forces(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                     const double *u, double *bias)
{
    const int status =
        mbsri_enter(model, data, q && u && bias, MBSRI_STAGE_NONE, "mbsr_bias_forces");
    if (status) return status;
    double *none = data->u_given; /* the index-1 form's, between whose calls this is free */
    mbsri_zero((size_t)model->nu, none);
    return mbsr_inverse_dynamics(model, data, t, q, u, none, bias);
}
