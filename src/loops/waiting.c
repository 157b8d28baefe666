/* Memory of the equations of motion with loops, and what they have of the model: see system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/waiting.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "recursion/closures.h"

struct mbsri_chunk {
    struct mbsri_chunk *next;
    size_t used, size; /* bytes behind this record */
};

void *mbsri_system_allocate(mbsri_system *w, size_t size)
{
    enum { LEAST = 1 << 14 };
    struct mbsri_chunk *c = w->chunks;
    size = (size + 15) / 16 * 16;
    if (!c || c->size - c->used < size) {
        size_t room = c ? 2 * c->size : LEAST;
        if (room < size) room = size;
        c = mbsri_allocate(&w->m->allocator, (sizeof *c + 15) / 16 * 16 + room);
        if (!c) return NULL;
        *c = (struct mbsri_chunk){w->chunks, 0, room};
        w->chunks = c;
    }
    void *memory = (char *)c + (sizeof *c + 15) / 16 * 16 + c->used;
    c->used += size;
    return memory;
}

static void list_ends(mbsri_system *w)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *c = m->closures.data;
    for (int i = 0; i <= m->bodies; ++i) w->first_end[i] = -1;
    for (int id = 0; id < (int)m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            w->closes[c->row + k] = c->meets;
            w->left_out[c->row + k] = mbsri_is_stiff(c, k);
        }
        for (int l = 0; l < c->bodies; ++l) {
            const int end = id * MBSRI_ENDS + l, i = c->body[l];
            if (i == 0 || c->column[l] < 0) continue;
            w->next_end[end] = w->first_end[i];
            w->first_end[i] = end;
        }
    }
}

int mbsri_system_open(mbsri_system *w, const mbsr_model *m, mbsr_data *d, const char *function)
{
    *w = (mbsri_system){.m = m, .d = d};
    const size_t bodies = (size_t)m->bodies + 1, rows = (size_t)m->rows, nu = (size_t)m->nu,
                 ends = m->closures.count * MBSRI_ENDS, unknowns = rows + nu;
    const size_t numbers = 2 * unknowns + 2 * m->size_v + nu + rows, pointers = 4 * bodies + ends,
                 ints = bodies + ends + rows + 2 * unknowns + 2 * (bodies + ends);
    w->memory = mbsri_allocate(&m->allocator, numbers * sizeof(double) + pointers * sizeof(void *) +
                                                  ints * sizeof(int) + rows * sizeof(bool));
    if (!w->memory)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for equations of %d joint rates and %d rows of closures",
                          function, m->nu, m->rows);
    w->s = w->memory;
    w->v = w->s + unknowns;
    w->a = w->v + unknowns;
    w->fbar = w->a + m->size_v;
    w->e = w->fbar + m->size_v;
    w->share = w->e + nu;
    w->joint = (mbsri_passing **)(void *)(w->share + rows);
    w->closing = (mbsri_pivots **)(void *)(w->joint + bodies);
    w->behind = (mbsri_waiting **)(void *)(w->closing + bodies);
    w->part = w->behind + bodies;
    w->first_end = (int *)(void *)(w->part + bodies + ends);
    w->next_end = w->first_end + bodies;
    w->closes = w->next_end + ends;
    w->slot = w->closes + rows;
    w->set = w->slot + unknowns;
    w->group = w->set + unknowns;
    w->mate = w->group + bodies + ends;
    w->left_out = (bool *)(w->mate + bodies + ends);
    for (size_t k = 0; k < unknowns; ++k) w->slot[k] = -1;
    list_ends(w);
    return MBSR_OK;
}

void mbsri_system_close(mbsri_system *w)
{
    while (w->chunks) {
        struct mbsri_chunk *next = w->chunks->next;
        mbsri_release(&w->m->allocator, w->chunks);
        w->chunks = next;
    }
    mbsri_release(&w->m->allocator, w->memory);
    w->memory = NULL;
}

mbsri_waiting *mbsri_open_waiting(mbsri_system *w, int count, int d)
{
    const size_t k = (size_t)count, numbers = 2 * k * k + 2 * (size_t)d * k;
    mbsri_waiting *p =
        mbsri_system_allocate(w, sizeof *p + numbers * sizeof(double) + k * sizeof(int));
    if (!p) return NULL;
    *p = (mbsri_waiting){.count = count, .F = (double *)(void *)(p + 1)};
    mbsri_zero(numbers, p->F);
    p->sizes = p->F + k * k;
    p->Q = p->sizes + k * k;
    p->lengths = p->Q + (size_t)d * k;
    p->id = (int *)(void *)(p->lengths + (size_t)d * k);
    return p;
}
