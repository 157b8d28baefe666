/* The equations of motion as a DAE: entry points, one table of functions a form.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forms/dae.h"

#include "algebra/numbers.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"

const mbsri_dae_form *mbsri_find_form(mbsr_dae_form form)
{
    static const mbsri_dae_form *const forms[] = {&mbsri_form_momentum, &mbsri_form_recursive,
                                                  &mbsri_form_inverse_dynamics, &mbsri_form_index1};
    for (size_t k = 0; k < sizeof forms / sizeof forms[0]; ++k) {
        if (forms[k]->form == form) return forms[k];
    }
    return NULL;
}

/* mbsri_enter plus a check of the form, which goes to *f. */
static int enter_form(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, bool arguments,
                      const char *function, const mbsri_dae_form **f)
{
    const int status = mbsri_enter(m, d, arguments, MBSRI_STAGE_NONE, function);
    if (status) return status;
    *f = mbsri_find_form(form);
    if (*f && (m->rows == 0 || form == MBSR_DAE_MOMENTUM)) return MBSR_OK;
    if (*f) {
        return mbsri_fail(&d->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "%s: the model has closures, which only the momentum form takes",
                          function);
    }
    return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "%s: form is %d, no such form", function, (int)form);
}

int mbsri_pack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
               const double *q, const double *u, double *y)
{
    static const char name[] = "mbsr_dae_pack";
    int status = mbsri_check_input(d, 1, &t, name, "t");
    if (!status) status = mbsri_check_input(d, (size_t)m->nq, q, name, "q");
    if (!status) status = mbsri_check_input(d, (size_t)m->nu, u, name, "u");
    if (!status) status = form->pack(m, d, t, q, u, y);
    if (!status) status = mbsri_normalise(m, d, y);
    return status ? status : mbsri_check_result(m, d, (size_t)form->size(m), y, name);
}

int mbsri_unpack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
                 const double *y, double *q, double *u)
{
    static const char name[] = "mbsr_dae_unpack";
    int status = mbsri_check_input(d, 1, &t, name, "t");
    if (!status) status = mbsri_check_input(d, (size_t)form->size(m), y, name, "y");
    if (!status) status = form->unpack(m, d, t, y, q, u);
    if (!status) status = mbsri_normalise(m, d, q);
    if (!status) status = mbsri_check_result(m, d, (size_t)m->nq, q, name);
    return status ? status : mbsri_check_result(m, d, (size_t)m->nu, u, name);
}

int mbsri_pack_motion(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
                      const double *q, const double *u, const double *udot, double *y, double *yp)
{
    int status = mbsri_pack(form, m, d, t, q, u, y);
    if (!status) status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (!status) status = mbsri_backward(m, d);
    return status ? status : form->start(m, d, t, y, udot, yp);
}

int mbsr_dae_size(const mbsr_model *model, mbsr_dae_form form)
{
    const mbsri_dae_form *f = mbsri_find_form(form);
    const bool served = f && model && (model->rows == 0 || form == MBSR_DAE_MOMENTUM);
    return served && model->finished ? f->size(model) : -1;
}

int mbsr_dae_id(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double *id)
{
    const mbsri_dae_form *f;
    const int status = enter_form(model, data, form, id != NULL, "mbsr_dae_id", &f);
    return status ? status : f->id(model, data, id);
}

int mbsr_dae_pack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                  const double *q, const double *u, double *y)
{
    const mbsri_dae_form *f;
    const int status = enter_form(model, data, form, q && u && y, "mbsr_dae_pack", &f);
    return status ? status : mbsri_pack(f, model, data, t, q, u, y);
}

int mbsr_dae_unpack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                    const double *y, double *q, double *u)
{
    const mbsri_dae_form *f;
    const int status = enter_form(model, data, form, y && q && u, "mbsr_dae_unpack", &f);
    return status ? status : mbsri_unpack(f, model, data, t, y, q, u);
}

int mbsr_dae_residual(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                      const double *y, const double *yp, double *F)
{
    const mbsri_dae_form *f;
    int status = enter_form(model, data, form, y && yp && F, "mbsr_dae_residual", &f);
    if (status) return status;
    const size_t size = (size_t)f->size(model);
    if (!mbsri_finite(size, yp)) {
        return mbsri_fail(&data->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_residual: yp is not finite");
    }
    status = f->residual(model, data, t, y, yp, F);
    if (status) return status;
    return mbsri_check_result(model, data, size, F, "mbsr_dae_residual");
}
