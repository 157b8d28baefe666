/* The (q, u) forms: y = (q, u).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   0 = q' - G u
 *   0 = residual (25) of the recursion, or J^T mu - tau of inverse dynamics */
#include "algebra/dense.h"
#include "dynamics/entry.h"
#include "forms/form.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "sweeps/dynamics.h"

static int direct_size(const mbsr_model *m)
{
    return m->nq + m->nu;
}

static int direct_identify(const mbsr_model *m, mbsr_data *d, double *id)
{
    (void)d;
    for (int k = 0; k < m->nq + m->nu; ++k) id[k] = 1.0;
    return MBSR_OK;
}

static int direct_pack(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                       const double *u, double *y)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, q, y);
    mbsri_copy((size_t)m->nu, u, y + m->nq);
    return MBSR_OK;
}

static int direct_unpack(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                         double *u)
{
    (void)d, (void)t;
    mbsri_copy((size_t)m->nq, y, q);
    mbsri_copy((size_t)m->nu, y + m->nq, u);
    return MBSR_OK;
}

static int direct_start(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                        const double *udot, double *yp)
{
    (void)t, (void)y;
    mbsri_copy((size_t)m->nu, udot, yp + m->nq);
    return mbsri_coordinate_rates(m, d, yp);
}

/* State of y, forces, and the first block of F. */
static int first_block(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                       const double *yp, double *F)
{
    int status = mbsri_positions(m, d, t, y);
    if (!status) status = mbsri_velocities(m, d, y + m->nq);
    if (!status) status = mbsri_coordinate_rates(m, d, F);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) F[k] = yp[k] - F[k];
    return mbsri_forces(m, d, NULL, NULL);
}

static int recursive(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *yp,
                     double *F)
{
    int status = first_block(m, d, t, y, yp, F);
    if (!status) status = mbsri_backward(m, d);
    if (!status) mbsri_forward(m, d, yp + m->nq, F + m->nq);
    return status;
}

static int inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                            const double *yp, double *F)
{
    const double *u = y + m->nq, *udot = yp + m->nq;
    int status = mbsri_sweeps_inverse_residual(m, d, t, y, yp, F);
    if (!status) mbsri_remember(m, d, MBSRI_PENDING_INVERSE, y, u, udot);
    if (status != MBSRI_NOT_SERVED) return status;
    status = first_block(m, d, t, y, yp, F);
    if (status) return status;
    mbsri_inverse(m, d, udot);
    mbsri_scatter(m, d->out, F + m->nq);
    return MBSR_OK;
}

const mbsri_dae_form mbsri_form_recursive = {MBSR_DAE_RECURSIVE, direct_size,   direct_identify,
                                             direct_pack,        direct_unpack, direct_start,
                                             recursive};

const mbsri_dae_form mbsri_form_inverse_dynamics = {MBSR_DAE_INVERSE_DYNAMICS,
                                                    direct_size,
                                                    direct_identify,
                                                    direct_pack,
                                                    direct_unpack,
                                                    direct_start,
                                                    inverse_dynamics};
