/* The (q, u) forms: y = (q, u),
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   0 = q' - G u
 *   0 = residual (25) of the recursion, or J^T mu - tau of inverse dynamics */
#include "internal.h"

#include "dense.h"
#include "fast/fast.h"

static int size(const mbsr_model *m)
{
    return m->nq + m->nu;
}

static int identify(const mbsr_model *m, mbsr_data *d, double *id)
{
    (void)d;
    for (int k = 0; k < m->nq + m->nu; ++k) id[k] = 1.0;
    return MBSR_OK;
}

static int pack(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                double *y)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, q, y);
    mbsri_copy((size_t)m->nu, u, y + m->nq);
    return MBSR_OK;
}

static int unpack(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                  double *u)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, y, q);
    mbsri_copy((size_t)m->nu, y + m->nq, u);
    return MBSR_OK;
}

static int start(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *udot,
                 double *yp)
{
    (void)t, (void)y;
    mbsri_copy((size_t)m->nu, udot, yp + m->nq);
    return mbsr_coordinate_rates(m, d, yp);
}

/* State of y, forces, and the first block of F. */
static int first_block(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                       const double *yp, double *F)
{
    int status = mbsr_positions(m, d, t, y);
    if (!status) status = mbsr_velocities(m, d, y + m->nq);
    if (!status) status = mbsr_coordinate_rates(m, d, F);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) F[k] = yp[k] - F[k];
    return mbsr_forces(m, d, NULL);
}

static int recursive(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *yp,
                     double *F)
{
    int status = first_block(m, d, t, y, yp, F);
    if (!status) status = mbsr_backward(m, d);
    return status ? status : mbsr_forward(m, d, yp + m->nq, F + m->nq);
}

static int inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                            const double *yp, double *F)
{
    const double *u = y + m->nq, *udot = yp + m->nq;
    if (mbsri_fast_inverse_residual(m, d, t, y, yp, F)) {
        mbsri_remember(m, d, MBSRI_PENDING_INVERSE, y, u, udot);
        return MBSR_OK;
    }
    const int status = first_block(m, d, t, y, yp, F);
    if (status) return status;
    mbsri_inverse_sweeps(m, d, udot);
    mbsri_scatter(m, d->out, F + m->nq);
    return MBSR_OK;
}

const mbsri_dae_form mbsri_form_recursive = {
    MBSR_DAE_RECURSIVE, size, identify, pack, unpack, start, recursive};

const mbsri_dae_form mbsri_form_inverse_dynamics = {
    MBSR_DAE_INVERSE_DYNAMICS, size, identify, pack, unpack, start, inverse_dynamics};
