/* Sensitivities of runs: creation.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/sensitivity_record.h"

#include "base/cookie.h"
#include "ida/error.h"

#include <stdio.h>
#include <stdlib.h>

mbsr_sensitivity_opt mbsr_default_sensitivity_opt(void)
{
    return (mbsr_sensitivity_opt){.cookie = MBSRI_COOKIE, .ida = mbsr_default_ida_opt()};
}

static int refuse_sensitivity(mbsr_error *error, int status, const char *text)
{
    return mbsri_ida_refuse(error, status, "mbsr_sensitivity_create: %s", text);
}

static int check_sensitivity(const mbsr_model *model, const mbsr_sensitivity_opt *opt,
                             mbsr_error *error)
{
    if (opt->cookie != MBSRI_COOKIE)
        return refuse_sensitivity(error, MBSR_ERR_NO_DEFAULT,
                                  "opt was not made by mbsr_default_sensitivity_opt");
    if (!opt->list || !opt->which)
        return refuse_sensitivity(error, MBSR_ERR_NULL,
                                  opt->list ? "which is NULL" : "list is NULL");
    if (opt->parameters < 1)
        return refuse_sensitivity(error, MBSR_ERR_VALUE, "parameters must be positive");
    if (opt->ida.form != MBSR_DAE_MOMENTUM)
        return refuse_sensitivity(error, MBSR_ERR_VALUE, "form must be MBSR_DAE_MOMENTUM");
    if (opt->ida.events != 0)
        return refuse_sensitivity(
            error, MBSR_ERR_VALUE,
            "events must be 0: what a run does at an event is not known here");
    if (mbsr_dae_size(model, MBSR_DAE_MOMENTUM) < 0)
        return refuse_sensitivity(error, MBSR_ERR_UNFINISHED, "the model is not finished");
    return MBSR_OK;
}

/* What the derivatives of inverse dynamics do not know about a parameter. */
static int check_parameter(mbsr_sensitivity *s, int k, mbsr_error *error)
{
    mbsr_parameter p;
    const int which = s->opt.which[k];
    if (mbsr_parameter_get(s->opt.list, which, &p))
        return mbsri_ida_refuse(error, MBSR_ERR_ID,
                                "mbsr_sensitivity_create: which[%d] is %d, but there are %d "
                                "parameters",
                                k, which, mbsr_parameters_count(s->opt.list));
    if (p.part == MBSR_PARAMETER_JOINT && mbsr_model_closures(s->model) > 0)
        return mbsri_ida_fail(error, MBSR_ERR_SPACE, p.id, MBSR_NONE,
                              "mbsr_sensitivity_create: %.100s: closures would open with the frame "
                              "of a joint",
                              p.name);
    if (p.part == MBSR_PARAMETER_JOINT && !s->frame[0])
        snprintf(s->frame, sizeof s->frame, "%s", p.name);
    const bool mass = p.part == MBSR_PARAMETER_MASS || p.part == MBSR_PARAMETER_TENSOR ||
                      p.part == MBSR_PARAMETER_MOMENT || p.part == MBSR_PARAMETER_ARMATURE;
    s->value[k] = p.value;
    if (mass && p.value == 0.0 && s->zero == MBSR_NONE) {
        s->zero = k;
        snprintf(s->named, sizeof s->named, "%s", p.name);
    }
    return MBSR_OK;
}

/* What a run needs. */
static int prepare_run(mbsr_sensitivity *s, mbsr_error *error)
{
    const mbsr_model *m = s->model;
    int status = MBSR_OK;
    s->zero = MBSR_NONE;
    s->size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    s->nq = mbsr_model_nq(m), s->nu = mbsr_model_nu(m);
    s->parameters = s->opt.parameters;
    s->value = mbsri_sensitivity_take((size_t)s->parameters);
    if (!s->value) return refuse_sensitivity(error, MBSR_ERR_NO_MEMORY, "no memory");
    for (int k = 0; k < s->parameters && !status; ++k) status = check_parameter(s, k, error);
    if (!status) status = mbsr_derivatives_create(m, &s->derivatives, error);
    if (!status) {
        status =
            mbsr_derivatives_parameters(s->derivatives, s->opt.list, s->parameters, s->opt.which);
        if (status && error) *error = *mbsr_derivatives_error(s->derivatives);
    }
    if (!status) status = mbsr_data_create(m, &s->data, error);
    if (!status) status = mbsri_sensitivity_driver(s, error);
    if (!status) status = mbsri_sensitivity_find_sides(s, error);
    if (status) return status;
    s->begin = mbsri_sensitivity_take(2 * (size_t)s->size);
    s->work = mbsri_sensitivity_take(4 * (size_t)s->size + (size_t)s->parameters);
    s->given =
        mbsri_sensitivity_take(2 * (size_t)s->nq + 4 * (size_t)s->nu + 2 * (size_t)s->parameters);
    return s->begin && s->work && s->given
               ? MBSR_OK
               : refuse_sensitivity(error, MBSR_ERR_NO_MEMORY, "no memory");
}

int mbsr_sensitivity_create(const mbsr_model *model, const mbsr_sensitivity_opt *opt,
                            mbsr_sensitivity **sensitivity, mbsr_error *error)
{
    if (sensitivity) *sensitivity = NULL;
    if (!model || !opt || !sensitivity)
        return refuse_sensitivity(error, MBSR_ERR_NULL, "model, opt or sensitivity is NULL");
    int status = check_sensitivity(model, opt, error);
    if (status) return status;
    mbsr_sensitivity *s = malloc(sizeof *s);
    if (!s) return refuse_sensitivity(error, MBSR_ERR_NO_MEMORY, "no memory");
    *s = (mbsr_sensitivity){.model = model, .opt = *opt};
    status = prepare_run(s, error);
    s->opt.list = NULL, s->opt.which = NULL; /* the caller's, and read */
    if (status)
        mbsr_sensitivity_destroy(s);
    else
        *sensitivity = s;
    return status;
}

void mbsr_sensitivity_destroy(mbsr_sensitivity *sensitivity)
{
    mbsr_sensitivity *s = sensitivity;
    if (!s) return;
    mbsr_newton_destroy(s->newton);
    mbsr_newton_destroy(s->back);
    mbsr_ida_destroy(s->ida);
    mbsr_derivatives_destroy(s->derivatives);
    mbsr_data_destroy(s->data);
    mbsri_sensitivity_free_sides(&s->sides);
    free(s->step.data);
    free(s->state.data);
    free(s->time.data);
    free(s->work);
    free(s->value);
    free(s->begin);
    free(s->given);
    free(s);
}

long mbsr_sensitivity_steps(const mbsr_sensitivity *sensitivity)
{
    return sensitivity && sensitivity->run.made ? (long)sensitivity->step.count : 0;
}

const mbsr_error *mbsr_sensitivity_error(const mbsr_sensitivity *sensitivity)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the object is NULL"};
    return sensitivity ? &sensitivity->error : &none;
}
