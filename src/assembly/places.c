/* Where the numbers of each body stand in the arrays of the data: see places.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/places.h"

#include "sweeps/tree.h"

static void place_arrays_of(mbsr_model *m, int i, mbsri_lengths *used)
{
    mbsri_body *b = m->body + i;
    const size_t d = (size_t)b->d, d_pred = (size_t)b->pred.d, n = (size_t)b->n;
    b->p = used->p;
    b->v = used->v;
    b->dd = used->dd;
    b->dp = used->dp;
    b->dn = used->dn;
    b->k = used->k;
    b->lock.full = used->full;
    b->scalar_offset = used->bodies++;
    used->p += (size_t)b->np;
    used->v += d;
    used->dd += d * d;
    used->dp += d * d_pred;
    used->dn += d * n;
    if (i > 0 && !(b->joint.table->flags & MBSR_JOINT_UNIT_K)) used->k += d * d;
    if (b->lock.count > 0) used->full += (size_t)b->joint.n;
}

void mbsri_places_set(mbsr_model *m, int bodies)
{
    mbsri_lengths used = {0};
    for (int i = 0; i <= bodies; ++i) {
        if (m->body[i].survey.in_sweeps) place_arrays_of(m, i, &used);
    }
    m->in_sweeps = used;
    for (int i = 0; i <= bodies; ++i) {
        if (!m->body[i].survey.in_sweeps) place_arrays_of(m, i, &used);
    }
    for (int i = 1; i <= bodies; ++i) {
        mbsri_body *b = m->body + i;
        const mbsri_body *pred = m->body + b->parent;
        b->pred.p = pred->p;
        b->pred.v = pred->v;
        b->pred.dd = pred->dd;
    }
    m->size = used;
}

void mbsri_places_see(mbsr_model *m)
{
    const mbsri_sweeps *const tree[] = {m->tree.plain, m->tree.newton};
    for (int k = 0; k < 2 && m->tree.plain; ++k) {
        for (int i = 1; i <= m->live; ++i) {
            const int flags = tree[k]->body[i].flags;
            if (!(flags & (MBSRI_BLOCK | MBSRI_LOADED))) continue;
            m->body[i].survey.in_sweeps = true;
            if (flags & MBSRI_BLOCK) m->body[m->body[i].parent].survey.in_sweeps = true;
        }
    }
}
