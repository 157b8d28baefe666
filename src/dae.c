/* The (q, u) forms of the equations of motion as a DAE residual.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include "dense.h"

static bool known(mbsr_dae_form form)
{
    return form == MBSR_DAE_RECURSIVE || form == MBSR_DAE_INVERSE_DYNAMICS;
}

/* mbsri_enter plus a check of the form. */
static int enter(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, bool arguments,
                 const char *function)
{
    const int status = mbsri_enter(m, d, arguments, MBSRI_STAGE_NONE, function);
    if (status) return status;
    if (!known(form)) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: form is %d, no such form", function, (int)form);
    }
    return MBSR_OK;
}

int mbsr_dae_size(const mbsr_model *model, mbsr_dae_form form)
{
    return model && model->finished && known(form) ? model->nq + model->nu : -1;
}

int mbsr_dae_id(const mbsr_model *model, mbsr_dae_form form, double *id)
{
    if (!model || !id) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    if (!known(form)) return MBSR_ERR_VALUE;
    for (int k = 0; k < model->nq + model->nu; ++k) id[k] = 1.0;
    return MBSR_OK;
}

int mbsr_dae_pack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                  const double *q, const double *u, double *y)
{
    (void)t;
    const int status = enter(model, data, form, q && u && y, "mbsr_dae_pack");
    if (status) return status;
    mbsri_copy((size_t)model->nq, q, y);
    mbsri_copy((size_t)model->nu, u, y + model->nq);
    return MBSR_OK;
}

int mbsr_dae_unpack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                    const double *y, double *q, double *u)
{
    (void)t;
    const int status = enter(model, data, form, y && q && u, "mbsr_dae_unpack");
    if (status) return status;
    mbsri_copy((size_t)model->nq, y, q);
    mbsri_copy((size_t)model->nu, y + model->nq, u);
    return MBSR_OK;
}

/* Second block of F: the residual (25), or J^T mu - tau. */
static int dynamics(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, const double *udot,
                    double *F)
{
    int status = mbsr_forces(m, d, NULL);
    if (status) return status;
    if (form == MBSR_DAE_INVERSE_DYNAMICS) {
        mbsri_inverse_sweeps(m, d, udot, F);
        return MBSR_OK;
    }
    status = mbsr_backward(m, d);
    return status ? status : mbsr_forward(m, d, udot, F);
}

int mbsr_dae_residual(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                      const double *y, const double *yp, double *F)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = enter(m, d, form, y && yp && F, "mbsr_dae_residual");
    if (status) return status;
    if (!mbsri_finite((size_t)(m->nq + m->nu), yp)) {
        return mbsri_fail(&d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_residual: yp is not finite");
    }
    status = mbsr_positions(m, d, t, y);
    if (!status) status = mbsr_velocities(m, d, y + m->nq);
    /* q' - G u */
    if (!status) status = mbsr_coordinate_rates(m, d, F);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) F[k] = yp[k] - F[k];
    /* equations of motion */
    status = dynamics(m, d, form, yp + m->nq, F + m->nq);
    if (status) return status;
    return mbsri_finite((size_t)(m->nq + m->nu), F) ? MBSR_OK : mbsri_report_not_finite(m, d);
}
