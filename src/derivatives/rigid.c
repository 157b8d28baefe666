/* Derivatives of trees of rigid bodies: see rigid_record.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/rigid.h"

#include "algebra/dense.h"
#include "base/memory.h"
#include "model/query.h"
#include "newton/linear/linear.h"

#include <stdint.h>

bool mbsri_rigid_serves(const mbsr_model *m)
{
    const mbsri_sweeps *tree = m->tree.evaluated;
    return tree && m->rows == 0 && tree->blocks == 0 && tree->users == 0;
}

/* Compiled for the same processor as those of the tree, which there is with vector types alone. */
static const mbsri_rigid_kernels *kernels_of(const mbsri_sweeps *tree)
{
    (void)tree;
#if defined(MBSR_WITHOUT_VECTORS)
    return NULL;
#else
#if defined(MBSR_WITH_V3)
    if (tree->kernels == &mbsri_sweeps_v3) return &mbsri_rigid_v3;
#endif
    return &mbsri_rigid_base;
#endif
}

static void *take(unsigned char *base, size_t *used, size_t size)
{
    void *here = base ? base + *used : NULL;
    *used += (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    return here;
}

/* Numbers of G of all joints. */
static size_t rates_size(const mbsr_model *m)
{
    size_t count = 0;
    for (int i = 1; i <= m->tree.evaluated->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (b->joint.table->coordinate_rates) count += (size_t)b->nq * (size_t)b->n;
    }
    return count;
}

/* Places the arrays in `base`, or with base == NULL only returns the size. */
static size_t layout(const mbsr_model *m, unsigned char *base, mbsri_rigid *r)
{
    const size_t bodies = (size_t)m->tree.evaluated->bodies + 1, nu = (size_t)m->nu;
    size_t used = 0;
    r->body = take(base, &used, bodies * sizeof *r->body);
    r->column = take(base, &used, nu * sizeof *r->column);
    r->work = take(base, &used, bodies * sizeof *r->work);
    r->Dinv = take(base, &used, (size_t)m->tree.evaluated->multi * sizeof *r->Dinv);
    r->y = take(base, &used, nu * sizeof *r->y);
    r->q = take(base, &used, (size_t)m->nq * sizeof *r->q);
    r->u = take(base, &used, nu * sizeof *r->u);
    r->tau_q = take(base, &used, nu * sizeof *r->tau_q);
    r->tau_u = take(base, &used, nu * sizeof *r->tau_u);
    r->composite = take(base, &used, bodies * sizeof *r->composite);
    r->force = take(base, &used, bodies * sizeof *r->force);
    r->spare = take(base, &used, nu * sizeof *r->spare);
    r->side = take(base, &used, nu * sizeof *r->side);
    r->along = take(base, &used, 3 * bodies * sizeof *r->along);
    r->reach = take(base, &used, bodies * sizeof *r->reach);
    const size_t loaded = r->elements && m->tree.evaluated->body_forces ? bodies : 0,
                 count = r->elements ? nu : 0;
    r->own = take(base, &used, loaded * sizeof *r->own);
    r->seen = take(base, &used, (loaded > 0 ? loaded : 1) * sizeof *r->seen);
    r->load = take(base, &used, 8 * loaded * sizeof *r->load);
    if (loaded == 0) r->load = NULL;
    r->G = take(base, &used, r->elements ? rates_size(m) * sizeof *r->G : 0);
    r->by_q = take(base, &used, count * sizeof *r->by_q);
    r->by_u = take(base, &used, count * sizeof *r->by_u);
    return used;
}

mbsri_rigid *mbsri_rigid_create(const mbsr_model *m)
{
    mbsri_rigid *r = mbsri_allocate(&m->allocator, sizeof *r);
    if (!r) return NULL;
    *r = (mbsri_rigid){.model = m, .kernels = kernels_of(m->tree.evaluated)};
    for (size_t k = 0; k < m->forces.count; ++k)
        r->elements = r->elements || !mbsri_linear_is_plain(m, k);
    const size_t size = layout(m, NULL, r);
    r->memory = mbsri_allocate(&m->allocator, size + MBSR_DATA_ALIGNMENT);
    if (!r->memory) {
        mbsri_release(&m->allocator, r);
        return NULL;
    }
    const uintptr_t past = (uintptr_t)r->memory % MBSR_DATA_ALIGNMENT;
    unsigned char *base = (unsigned char *)r->memory + (MBSR_DATA_ALIGNMENT - past);
    mbsri_zero(size / sizeof(double), (double *)(void *)base);
    layout(m, base, r);
    return r;
}

void mbsri_rigid_destroy(mbsri_rigid *r)
{
    if (!r) return;
    const mbsr_allocator allocator = r->model->allocator;
    mbsri_release(&allocator, r->memory);
    mbsri_release(&allocator, r);
}

int mbsri_rigid_linearise(mbsri_rigid *r, mbsr_data *d, const double *q, const double *u,
                          const double *udot, bool forward)
{
    const mbsr_model *m = r->model;
    const size_t nu = (size_t)m->nu;
    mbsri_gather(m, u, r->u);
    for (int k = 0; k < m->nq; ++k) r->q[k] = q[m->order.q_of[k]];
    mbsri_zero(nu, r->tau_q);
    mbsri_zero(nu, r->tau_u);
    mbsri_coordinate_slopes(&m->elements.along, d->element.off + mbsri_other_forces(m), r->q, r->u,
                            r->tau_q, r->tau_u);
    r->tree = m->tree.evaluated;
    const mbsri_sweep_run run = {.model = m,
                                 .data = d,
                                 .tree = r->tree,
                                 .state = d->sweep.state,
                                 .multi = d->sweep.multi,
                                 .load = r->tree->body_forces ? d->sweep.load : NULL,
                                 .q = r->q,
                                 .u = r->u};
    return r->kernels->prepare(r, &run, udot, forward);
}
