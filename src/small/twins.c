/* Copies of the model whose loads the report sets.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/twins.h"

#include "base/error.h"

int mbsri_small_failed(mbsr_small_masses *s, int status, const mbsr_error *error)
{
    if (status && error != &s->error) {
        s->error = *error;
        s->error.status = status;
    }
    return status;
}

static int load_at(void *user, double t, int n, double *value)
{
    const mbsri_small_load *load = user;
    const double h = t - load->from;
    for (int k = 0; k < n; ++k)
        value[k] = load->value[k] + h * (load->rate[k] + 0.5 * h * load->curvature[k]);
    return MBSR_OK;
}

/* Everything as it was given, then without the candidates' masses. */
static int amend(mbsr_small_masses *s, mbsr_model *m, bool without)
{
    int status = MBSR_OK;
    for (int id = 0; id < s->given->bodies && !status; ++id) status = mbsr_model_restore(m, id);
    for (int k = 0; k < s->candidates && !status && without; ++k) {
        const mbsri_candidate *c = s->candidate + k;
        if (!c->keeps_mass) status = mbsr_model_neglect(m, c->body, c->parts);
    }
    return status;
}

static int add_loads(mbsr_small_masses *s, mbsr_model *m)
{
    int status = MBSR_OK;
    for (int k = 0; k < s->candidates && !status; ++k) {
        const mbsr_force_def force =
            mbsr_force_applied(s->candidate[k].body, load_at, &s->candidate[k].load);
        status = mbsr_model_add_force(m, &force, NULL);
    }
    for (int k = 0; k < s->pushes && !status; ++k) {
        const mbsr_force_def force = mbsr_force_joint_applied(s->given->body[s->pushed[k].i].id,
                                                              load_at, &s->pushed[k].push);
        status = mbsr_model_add_force(m, &force, NULL);
    }
    return status;
}

static int make_model(mbsr_small_masses *s, bool without, bool loads, mbsr_model **made)
{
    int status = mbsr_model_copy(s->given, made, &s->error);
    if (status) return status;
    status = amend(s, *made, without);
    if (!status && loads) status = add_loads(s, *made);
    if (!status) status = mbsr_model_finish(*made);
    return mbsri_small_failed(s, status, mbsr_model_error(*made));
}

static int make_twin(mbsr_small_masses *s, bool without, mbsri_twin *twin)
{
    int status = make_model(s, without, true, &twin->model);
    if (!status) status = mbsr_data_create(twin->model, &twin->data, &s->error);
    if (!status)
        status = mbsr_newton_create(twin->model, MBSR_DAE_MOMENTUM, NULL, &twin->newton, &s->error);
    return status;
}

int mbsri_small_twins(mbsr_small_masses *s)
{
    mbsri_small_twins_release(s);
    int status = make_twin(s, false, &s->full);
    if (!status) status = make_twin(s, true, &s->reduced);
    return status ? status : make_model(s, true, false, &s->clean);
}

static void release(mbsri_twin *twin)
{
    mbsr_newton_destroy(twin->newton);
    mbsr_data_destroy(twin->data);
    mbsr_model_destroy(twin->model);
    *twin = (mbsri_twin){NULL, NULL, NULL};
}

void mbsri_small_twins_release(mbsr_small_masses *s)
{
    release(&s->full);
    release(&s->reduced);
    mbsr_model_destroy(s->clean);
    s->clean = NULL;
}
