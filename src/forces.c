/* Applied forces f and joint forces tau: gyroscopic terms and all force elements.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include "dense.h"

/* Body i as force elements see it; `rates`: velocities and outputs are there. The root drops what
 * is added to it. */
static mbsr_force_body view(const mbsr_model *m, mbsr_data *d, int i, bool rates)
{
    const mbsri_body *b = m->body + i;
    mbsr_force_body body = {.id = b->id,
                            .space = b->joint.space,
                            .d = b->d,
                            .np = b->np,
                            .n = b->n,
                            .nq = b->nq,
                            .p = d->p + b->p,
                            .V = rates ? d->V + b->v : NULL,
                            .f = rates ? d->f + b->v : NULL};
    if (i > 0) {
        body.M = d->M + b->dd;
        body.inertia = &b->inertia;
        body.q = d->q + b->iq;
        body.u = rates ? d->u + b->iu : NULL;
        body.tau = rates ? d->tau + b->iu : NULL;
    }
    return body;
}

static int failed(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int status,
                  const char *function)
{
    char label[MBSRI_LABEL];
    return mbsri_fail(
        &d->error, status, MBSR_NONE, force->id, "%s (%s): %s returned %d at t = %g",
        mbsri_label(label, "force", force->id, (const char *)m->names.data + force->name),
        force->def.table->name, function, status, d->t);
}

/* One call of an element; energy == NULL: forces, else its energy is added there. */
static int call(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int bodies,
                double *energy)
{
    const mbsr_force_args args = {
        .force = &force->def, .t = d->t, .bodies = bodies, .body = d->force_bodies};
    if (!energy) {
        const int status = force->def.table->evaluate(&args);
        return status ? failed(m, d, force, status, "evaluate") : MBSR_OK;
    }
    if (!force->def.table->energy) return MBSR_OK;
    double one = 0.0;
    const int status = force->def.table->energy(&args, &one);
    *energy += one;
    return status ? failed(m, d, force, status, "energy") : MBSR_OK;
}

/* All calls of an element. */
static int visit(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, double *energy)
{
    if (force->def.table->flags & MBSR_FORCE_EVERY_BODY) {
        for (int i = 1; i <= m->bodies; ++i) {
            d->force_bodies[0] = view(m, d, i, !energy);
            const int status = call(m, d, force, 1, energy);
            if (status) return status;
        }
        return MBSR_OK;
    }
    for (int k = 0; k < force->def.bodies; ++k) {
        d->force_bodies[k] = view(m, d, m->list_index[force->list + (size_t)k], !energy);
    }
    return call(m, d, force, force->def.bodies, energy);
}

int mbsr_forces(const mbsr_model *model, mbsr_data *data, const double *tau)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_forces");
    if (status) return status;
    d->stage = MBSRI_STAGE_VELOCITIES;

    mbsri_zero((size_t)m->nu, d->tau);
    if (tau) mbsri_gather(m, tau, d->tau);
    /* f_i = -h_i */
    mbsri_zero((size_t)m->root.d, d->f);
    for (size_t k = (size_t)m->root.d; k < m->size_v; ++k) d->f[k] = -d->h[k];
    /* + force elements */
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k) {
        status = visit(m, d, force + k, NULL);
        if (status) return status;
    }
    d->stage = MBSRI_STAGE_FORCES;
    return MBSR_OK;
}

int mbsr_energy(const mbsr_model *model, mbsr_data *data, double *kinetic, double *potential)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_energy");
    if (status) return status;
    double T = 0.0, E = 0.0;
    /* 1/2 V^T M V */
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_zero((size_t)b->d, d->scratch);
        mbsri_ax(b->d, b->d, 1.0, d->M + b->dd, d->V + b->v, d->scratch);
        T += 0.5 * mbsri_dot(b->d, d->V + b->v, d->scratch);
    }
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; potential && k < m->forces.count; ++k) {
        status = visit(m, d, force + k, &E);
        if (status) return status;
    }
    if (kinetic) *kinetic = T;
    if (potential) *potential = E;
    return MBSR_OK;
}
