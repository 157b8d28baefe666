/* How what a run keeps changes with the parameters of a study.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/study_slopes.h"

#include "program/touching.h"

#include <mbsrank/sensitivity.h>

#include <math.h>
#include <stdlib.h>

/* A run with its sensitivities. */
typedef struct sloped_run {
    study_work *w;
    int nq, nu, times;
    const double *time;
    double *q, *u;   /* times x nq, nu: states */
    double *dq, *du; /* parameters x times x nq, nu */
    double *at_q, *at_u;
} sloped_run;

static bool is_served(const study_work *w)
{
    const mbsr_study *s = w->study;
    bool served = w->in.table.lines == 0 && s->outputs > 0 && !columns_have_contacts(&w->c);
    for (int k = 0; k < s->outputs && served; ++k) {
        const mbsr_study_output *o = s->output + k;
        served = o->kind == MBSR_KEEP_AT && o->time == s->output->time &&
                 study_needs_no_forces(w, w->c.list + k);
    }
    return served;
}

/* The parameters of a model that may have a force element for contacts more than that of the study:
 * their list and numbers, to be freed. False: there is no memory. */
static bool find_again(const study_work *w, const mbsr_model *model, mbsr_parameters **list,
                       int **which)
{
    *which = calloc((size_t)w->study->parameters + 1, sizeof **which);
    if (!*which || mbsr_parameters_create(model, list, NULL)) return false;
    for (int k = 0; k < w->study->parameters; ++k)
        (*which)[k] = mbsr_parameters_find(*list, w->study->parameter[k].name);
    return true;
}

/* Runs the model with the values at hand. */
static int solve_sensitivities(sloped_run *r, const mbsr_model *model, const double *q,
                               const double *u)
{
    const study_work *w = r->w;
    const size_t states = (size_t)r->times * (size_t)(r->nq + r->nu + 1),
                 slopes = states * (size_t)w->study->parameters;
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    mbsr_sensitivity *s = NULL;
    mbsr_parameters *list = NULL;
    int *which = NULL, status = MBSR_ERR_NO_MEMORY;
    r->q = calloc(states + slopes + (size_t)(r->nq + r->nu), sizeof *r->q);
    if (!r->q) return status;
    r->u = r->q + r->times * r->nq;
    r->dq = r->u + r->times * r->nu;
    r->du = r->dq + w->study->parameters * r->times * r->nq;
    r->at_q = r->du + w->study->parameters * r->times * r->nu;
    r->at_u = r->at_q + r->nq;
    if (find_again(w, model, &list, &which)) {
        opt.ida = w->opt;
        opt.list = list;
        opt.parameters = w->study->parameters;
        opt.which = which;
        status = mbsr_sensitivity_create(model, &opt, &s, NULL);
    }
    if (!status) status = mbsr_sensitivity_run(s, 0.0, q, u, r->times, r->time, r->q, r->u);
    if (!status) status = mbsr_sensitivity_forward(s, r->dq, r->du);
    mbsr_sensitivity_destroy(s);
    mbsr_parameters_destroy(list);
    free(which);
    return status;
}

/* Columns of a model whose parameter k is more by h, at states that are by as much further along
 * their sensitivity: value (study->numbers). */
static int columns_along(const sloped_run *r, int k, double h, double *value)
{
    study_work *w = r->w;
    const double kept = w->parameter[k];
    mbsr_data *data = NULL;
    w->parameter[k] += h;
    int status =
        mbsr_parameters_data(w->list, w->study->parameters, w->which, w->parameter, &data, NULL);
    w->parameter[k] = kept;
    for (int i = 0; i < r->times && !status; ++i) {
        const mbsr_model *model = mbsr_data_model(data);
        const int at = k * r->times + i;
        for (int l = 0; l < r->nq; ++l)
            r->at_q[l] = r->q[i * r->nq + l] + h * r->dq[at * r->nq + l];
        for (int l = 0; l < r->nu; ++l)
            r->at_u[l] = r->u[i * r->nu + l] + h * r->du[at * r->nu + l];
        status = mbsr_stage_positions(model, data, r->time[i], r->at_q);
        if (!status) status = mbsr_stage_velocities(model, data, r->at_u);
        if (!status)
            status = columns_values(&w->c, model, data, r->time[i], r->at_q, r->at_u, w->row);
        for (int o = 0; o < w->study->outputs && !status; ++o)
            value[w->study->output[o].first + i] = w->row[o];
    }
    mbsr_data_destroy(data);
    return status;
}

/* Central differences along the sensitivities: columns are smooth functions of states. */
static int difference_columns(const sloped_run *r, double *slope)
{
    static const double part = 1e-4; /* of the parameter */
    study_work *w = r->w;
    const int numbers = w->study->numbers;
    int status = MBSR_OK;
    for (int k = 0; k < w->study->parameters && !status; ++k) {
        const double size = fabs(w->parameter[k]), h = part * (size > 0.0 ? size : 1.0);
        double *to = slope + k * numbers;
        status = columns_along(r, k, h, to);
        if (!status) status = columns_along(r, k, -h, w->value);
        for (int l = 0; l < numbers && !status; ++l) to[l] = (to[l] - w->value[l]) / (2.0 * h);
    }
    return status;
}

int study_slopes(study_work *w, double *slope)
{
    const mbsr_study *study = w->study;
    const double *q, *u;
    mbsr_model *model = NULL;
    touching contacts = {.contacts = NULL};
    if (!is_served(w) ||
        mbsr_parameters_model(w->list, study->parameters, w->which, w->parameter, &model, NULL))
        return 1;
    program_model one = w->m;
    one.model = model;
    if (!one.read) one.read = w->m.model;
    int status = start_state(&w->options.common, &one, &q, &u);
    if (!status) status = touching_make(&one, q, w->options.common.contacts, true, &contacts);
    sloped_run r = {.w = w,
                    .nq = mbsr_model_nq(model),
                    .nu = mbsr_model_nu(model),
                    .times = study->output->times,
                    .time = study->output->time};
    if (!status) status = solve_sensitivities(&r, contacts.model ? contacts.model : model, q, u);
    if (!status) status = difference_columns(&r, slope);
    free(r.q);
    if (contacts.model) mbsr_model_destroy(contacts.model);
    touching_free(&contacts);
    mbsr_model_destroy(model);
    return status;
}
