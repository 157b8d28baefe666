/* Reading a finished model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "model/query.h"

#include "base/error.h"

#include <string.h>

static bool ready(const mbsr_model *m)
{
    return m && m->finished;
}

int mbsri_index(const mbsr_model *m, int id)
{
    if (id == MBSR_GROUND) return 0;
    return id >= 0 && id < m->bodies ? m->index[id] : -1;
}

const char *mbsri_body_label(const mbsr_model *m, int i, char *buffer)
{
    return mbsri_label(buffer, "body", m->body[i].id,
                       (const char *)m->stored.names.data + m->body[i].name);
}

/* The body of that id, the ground excluded; NULL if there is none. */
static const mbsri_body *find_body(const mbsr_model *m, int id)
{
    return ready(m) && id >= 0 && id < m->bodies ? m->body + m->index[id] : NULL;
}

int mbsr_model_bodies(const mbsr_model *model)
{
    return ready(model) ? model->bodies : -1;
}

double mbsr_model_length(const mbsr_model *model)
{
    return ready(model) ? model->typical.length : -1.0;
}

double mbsr_model_rate(const mbsr_model *model)
{
    return ready(model) ? model->typical.frequency : -1.0;
}

int mbsr_model_forces(const mbsr_model *model)
{
    return ready(model) ? (int)(model->forces.count + model->elements.idle) : -1;
}

int mbsr_model_nq(const mbsr_model *model)
{
    return ready(model) ? model->nq : -1;
}

int mbsr_model_nu(const mbsr_model *model)
{
    return ready(model) ? model->nu : -1;
}

int mbsr_body_coordinates(const mbsr_model *model, int body, int *q_index, int *nq, int *u_index,
                          int *n)
{
    if (!model) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const mbsri_body *b = find_body(model, body);
    if (!b) return MBSR_ERR_ID;
    if (q_index) *q_index = b->q;
    if (nq) *nq = b->nq;
    if (u_index) *u_index = b->u;
    if (n) *n = b->n;
    return MBSR_OK;
}

int mbsr_body_parent(const mbsr_model *model, int body)
{
    const mbsri_body *b = find_body(model, body);
    return b ? ((const mbsri_body_entry *)model->entries.data)[b->id].parent : MBSR_NONE;
}

int mbsr_body_dimension(const mbsr_model *model, int body)
{
    const mbsri_body *b = find_body(model, body);
    return b ? b->d : -1;
}

int mbsr_body_pose_size(const mbsr_model *model, int body)
{
    const mbsri_body *b = find_body(model, body);
    return b ? b->np : -1;
}

int mbsr_body_group(const mbsr_model *model, int body)
{
    const mbsri_body *b = find_body(model, body);
    return b ? model->body[b->group.head].id : MBSR_NONE;
}

const char *mbsr_body_name(const mbsr_model *model, int body)
{
    const mbsri_body *b = find_body(model, body);
    return b ? (const char *)model->stored.names.data + b->name : NULL;
}

int mbsr_model_find_body(const mbsr_model *model, const char *name)
{
    if (!ready(model) || !name || !name[0]) return MBSR_NONE;
    for (int id = 0; id < model->bodies; ++id) {
        if (strcmp(mbsr_body_name(model, id), name) == 0) return id;
    }
    return MBSR_NONE;
}

void mbsri_gather(const mbsr_model *m, const double *caller, double *in_order)
{
    for (int k = 0; k < m->nu; ++k) in_order[k] = caller[m->order.u_of[k]];
}

void mbsri_scatter(const mbsr_model *m, const double *in_order, double *caller)
{
    for (int k = 0; k < m->nu; ++k) caller[m->order.u_of[k]] = in_order[k];
}

int mbsri_body_of_rate(const mbsr_model *m, int rate)
{
    int i = 1;
    while (rate < m->body[i].u || rate >= m->body[i].u + m->body[i].n) ++i;
    return i;
}

const char *mbsri_mass_advice(const mbsr_model *m, int i)
{
    for (int k = i; k <= m->bodies; ++k) {
        const mbsri_body *b = m->body + k;
        if ((k == i || b->parent == i) && b->inertia.kind == MBSR_INERTIA_FLEXIBLE)
            return " (a beam about its axis: radius_y, radius_z)";
    }
    return "";
}
