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

/* Columns before each column, in all; 0: so many that sweeps to the leaves take less. */
static size_t count_paths(const mbsri_sweeps *tree, size_t nu)
{
    enum { MOST = 24 }; /* on the mean */
    size_t size = 0;
    for (int i = 1; i <= tree->bodies && size <= MOST * nu; ++i) {
        for (int at = tree->body[i].parent; at > 0 && size <= MOST * nu; at = tree->body[at].parent)
            size += (size_t)(tree->body[i].n * tree->body[at].n);
    }
    return size <= MOST * nu ? size + 1 : 0;
}

/* The rows of matrices: of models with up to so many rates. */
static void place_rows(size_t nu, mbsri_rigid_order *o)
{
    enum { LARGEST = 200 };
    const size_t vectors = (nu + 3) / 4,
                 groups = (vectors + MBSRI_RIGID_WIDTH - 1) / MBSRI_RIGID_WIDTH;
    o->width = 3;
    while ((size_t)o->width * groups < vectors) o->width += 2;
    o->part = (nu + 3 + 7) / 8 * 8;
    while (o->part < 4 * (size_t)o->width * groups) o->part += 8;
    o->down = nu <= LARGEST ? 4 * o->part : 0;
}

static void place_order(const mbsri_sweeps *tree, size_t nu, unsigned char *base, size_t *used,
                        mbsri_rigid_order *o)
{
    const size_t bodies = (size_t)tree->bodies + 1, paths = count_paths(tree, nu);
    place_rows(nu, o);
    o->first = mbsri_take_bytes(base, used, bodies * sizeof *o->first);
    o->end = mbsri_take_bytes(base, used, bodies * sizeof *o->end);
    o->u = mbsri_take_bytes(base, used, nu * sizeof *o->u);
    o->place = mbsri_take_bytes(base, used, nu * sizeof *o->place);
    o->slot = mbsri_take_bytes(base, used, nu * sizeof *o->slot);
    o->block_place = mbsri_take_bytes(base, used, nu * sizeof *o->block_place);
    o->travel = mbsri_take_bytes(base, used, MBSRI_RIGID_TRAVEL * nu * sizeof *o->travel);
    o->rows = mbsri_take_bytes(base, used, (o->down > 0 ? nu + 4 : 0) * o->down * sizeof *o->rows);
    const size_t kept = o->down > 0 ? paths : 0;
    o->path = mbsri_take_bytes(base, used, kept * sizeof *o->path);
    o->way = mbsri_take_bytes(base, used, nu * sizeof *o->way);
    if (kept == 0) o->path = NULL;
}

/* Places the arrays in `base`, or with base == NULL only returns the size. */
static size_t layout(const mbsr_model *m, unsigned char *base, mbsri_rigid *r)
{
    const size_t bodies = (size_t)m->tree.evaluated->bodies + 1, nu = (size_t)m->nu;
    size_t used = 0;
    r->body = mbsri_take_bytes(base, &used, bodies * sizeof *r->body);
    r->column = mbsri_take_bytes(base, &used, nu * sizeof *r->column);
    r->work = mbsri_take_bytes(base, &used, bodies * sizeof *r->work);
    r->Dinv = mbsri_take_bytes(base, &used, (size_t)m->tree.evaluated->multi * sizeof *r->Dinv);
    r->y = mbsri_take_bytes(base, &used, nu * sizeof *r->y);
    r->q = mbsri_take_bytes(base, &used, (size_t)m->nq * sizeof *r->q);
    r->u = mbsri_take_bytes(base, &used, nu * sizeof *r->u);
    r->tau_q = mbsri_take_bytes(base, &used, nu * sizeof *r->tau_q);
    r->tau_u = mbsri_take_bytes(base, &used, nu * sizeof *r->tau_u);
    r->composite = mbsri_take_bytes(base, &used, bodies * sizeof *r->composite);
    r->force = mbsri_take_bytes(base, &used, bodies * sizeof *r->force);
    r->side = mbsri_take_bytes(base, &used, (nu + 3) * sizeof *r->side);
    r->along = mbsri_take_bytes(base, &used, bodies * sizeof *r->along);
    place_order(m->tree.evaluated, nu, base, &used, &r->order);
    const size_t loaded = r->elements && m->tree.evaluated->body_forces ? bodies : 0,
                 count = r->elements ? nu : 0;
    r->own = mbsri_take_bytes(base, &used, loaded * sizeof *r->own);
    r->motion = mbsri_take_bytes(base, &used, (loaded > 0 ? loaded : 1) * sizeof *r->motion);
    r->load = mbsri_take_bytes(base, &used, 8 * loaded * sizeof *r->load);
    if (loaded == 0) r->load = NULL;
    r->G = mbsri_take_bytes(base, &used, r->elements ? rates_size(m) * sizeof *r->G : 0);
    r->by_q = mbsri_take_bytes(base, &used, count * sizeof *r->by_q);
    r->by_u = mbsri_take_bytes(base, &used, count * sizeof *r->by_u);
    return used;
}

/* The order of columns. */
static void order_columns(mbsri_rigid *r, const mbsri_sweeps *tree)
{
    const mbsri_sweep_body *body = tree->body;
    mbsri_rigid_order *o = &r->order;
    int *next = r->along; /* for the columns behind each, then for the bodies */
    for (int i = tree->bodies; i >= 1; --i) {
        o->end[i] += body[i].n;
        o->end[body[i].parent] += o->end[i];
    }
    next[0] = 0;
    for (int i = 1; i <= tree->bodies; ++i) {
        o->first[i] = next[body[i].parent];
        next[body[i].parent] += o->end[i];
        o->end[i] += o->first[i];
        next[i] = o->first[i] + body[i].n;
    }
}

/* Slots and paths, where bodies are in order. */
static void order_slots(mbsri_rigid *r, const mbsri_sweeps *tree)
{
    mbsri_rigid_order *o = &r->order;
    int slot = 0;
    size_t at = 0;
    for (int place = 1; place <= tree->bodies; ++place) {
        const int i = r->along[place], parent = tree->body[i].parent;
        if (o->first[i] != o->first[parent] + (parent > 0 ? tree->body[parent].n : 0))
            slot = (slot + 3) / 4 * 4;
        const size_t way = at;
        for (int up = parent; up > 0 && o->path; up = tree->body[up].parent) {
            for (int j = 0; j < tree->body[up].n && tree->body[i].n > 0; ++j)
                o->path[at++] = (size_t)(o->first[up] + j) * o->down;
        }
        for (int k = o->first[i]; k < o->first[i] + tree->body[i].n; ++k, ++slot) {
            o->slot[k] = slot;
            o->way[k] =
                (mbsri_rigid_way){(size_t)k * o->down, at - way, o->path ? o->path + way : NULL};
            if (slot % 4 == 0) o->block_place[slot / 4] = k;
        }
    }
    o->blocks = (size_t)(slot + 3) / 4;
}

/* r->along: bodies so that those behind one stand together. */
static void order_bodies(mbsri_rigid *r, const mbsri_sweeps *tree, int *size, int *next)
{
    for (int i = 0; i <= tree->bodies; ++i) size[i] = 1;
    for (int i = tree->bodies; i >= 1; --i) size[tree->body[i].parent] += size[i];
    next[0] = 1;
    for (int i = 1; i <= tree->bodies; ++i) {
        const int parent = tree->body[i].parent, place = next[parent];
        r->along[place] = i;
        next[parent] += size[i];
        next[i] = place + 1;
    }
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
    int *spare = mbsri_allocate(&m->allocator, 2 * ((size_t)r->model->bodies + 1) * sizeof *spare);
    if (!spare) {
        mbsri_rigid_destroy(r);
        return NULL;
    }
    order_columns(r, m->tree.evaluated);
    order_bodies(r, m->tree.evaluated, spare, spare + r->model->bodies + 1);
    order_slots(r, m->tree.evaluated);
    mbsri_release(&m->allocator, spare);
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
