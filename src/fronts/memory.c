/* Memory of the equations of motion with loops: see fronts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/fronts.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "fronts/choose.h"
#include "recursion/closures.h"

struct mbsri_chunk {
    struct mbsri_chunk *next;
    size_t used, size; /* bytes behind this record */
};

static size_t rounded(size_t size)
{
    return (size + 31) / 32 * 32;
}

void *mbsri_fronts_allocate(mbsri_fronts *w, size_t size)
{
    enum { LEAST = 1 << 14 };
    const size_t record = rounded(sizeof(struct mbsri_chunk));
    struct mbsri_chunk *c = w->chunks;
    size = rounded(size);
    if (!c || c->size - c->used < size) {
        size_t room = c ? 2 * c->size : LEAST;
        if (room < size) room = size;
        c = mbsri_allocate(&w->m->allocator, record + room);
        if (!c) return NULL;
        *c = (struct mbsri_chunk){w->chunks, 0, room};
        w->chunks = c;
    }
    void *memory = (char *)c + record + c->used;
    c->used += size;
    return memory;
}

double *mbsri_fronts_scratch(mbsri_fronts *w, size_t numbers)
{
    if (numbers > w->scratch_size) {
        w->scratch = mbsri_fronts_allocate(w, 2 * numbers * sizeof *w->scratch);
        w->scratch_size = w->scratch ? 2 * numbers : 0;
    }
    return w->scratch;
}

/* ---- parts ---- */

mbsri_part *mbsri_fronts_open_part(mbsri_fronts *w, int count)
{
    const size_t n = (size_t)count,
                 needed = sizeof(mbsri_part) + 2 * n * n * sizeof(double) + n * sizeof(int);
    int step = 0;
    size_t room = 256; /* grows by halves and thirds in turn */
    for (; room < needed; ++step) room = room / 2 % 3 == 0 ? room / 3 * 4 : room / 2 * 3;
    mbsri_part *p = w->unused[step];
    if (p)
        w->unused[step] = *(void **)(void *)p;
    else
        p = mbsri_fronts_allocate(w, room);
    if (!p) return NULL;
    *p = (mbsri_part){.count = count, .A = (double *)(void *)(p + 1), .step = step};
    p->sizes = p->A + n * n;
    p->id = (int *)(void *)(p->sizes + n * n);
    return p;
}

void mbsri_fronts_close_part(mbsri_fronts *w, mbsri_part *part)
{
    const int step = part->step;
    *(void **)(void *)part = w->unused[step];
    w->unused[step] = part;
}

/* ---- the model ---- */

static void list_ends(mbsri_fronts *w)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *c = m->closures.data;
    for (int i = 0; i <= m->bodies; ++i) w->first_end[i] = -1;
    for (int id = 0; id < (int)m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            w->eliminated[c->row + k] = w->plan->when[m->bodies + 1 + id];
            w->left_out[c->row + k] = mbsri_is_stiff(c, k);
        }
        for (int l = 0; l < c->bodies; ++l) {
            const int end = id * MBSRI_ENDS + l, i = c->body[l];
            if (!mbsri_plan_reads(c, l)) continue;
            w->next_end[end] = w->first_end[i];
            w->first_end[i] = end;
        }
    }
}

/* A model without closures has no plan; one with far ends does not serve joints without inertia. */
static bool take_plan(mbsri_fronts *w, bool far)
{
    w->plan = w->m->plan;
    if (w->plan && (far || !w->plan->far)) return true;
    if (!mbsri_plan_create(w->m, false, &w->own_plan)) return false;
    w->plan = w->own_plan;
    return true;
}

static int no_memory(const mbsri_fronts *w, const char *function)
{
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for equations of %d joint rates and %d rows of closures",
                      function, w->m->nu, w->m->rows);
}

int mbsri_fronts_open(mbsri_fronts *w, const mbsr_model *m, mbsr_data *d, bool far,
                      const char *function)
{
    *w = (mbsri_fronts){.m = m, .d = d, .free = -1};
    if (!take_plan(w, far)) return no_memory(w, function);
    const size_t bodies = (size_t)m->bodies + 1, rows = (size_t)m->rows, nu = (size_t)m->nu,
                 ends = m->closures.count * MBSRI_ENDS, unknowns = rows + nu + m->size_v,
                 steps = (size_t)w->plan->steps;
    const size_t numbers = 2 * unknowns + nu + rows, ints = bodies + ends + rows + 2 * unknowns;
    w->memory =
        mbsri_allocate(&m->allocator, numbers * sizeof(double) + 3 * steps * sizeof(void *) +
                                          ints * sizeof(int) + rows * sizeof(bool));
    if (!w->memory) return no_memory(w, function);
    w->s = w->memory;
    w->v = w->s + unknowns;
    w->e = w->v + unknowns;
    w->share = w->e + nu;
    w->part = (mbsri_part **)(void *)(w->share + rows);
    w->pivots = (mbsri_pivots **)(void *)(w->part + steps);
    w->passing = (mbsri_passing **)(void *)(w->pivots + steps);
    w->first_end = (int *)(void *)(w->passing + steps);
    w->next_end = w->first_end + bodies;
    w->eliminated = w->next_end + ends;
    w->slot = w->eliminated + rows;
    w->set = w->slot + unknowns;
    w->left_out = (bool *)(w->set + unknowns);
    for (size_t k = 0; k < unknowns; ++k) w->slot[k] = -1;
    list_ends(w);
    return MBSR_OK;
}

void mbsri_fronts_close(mbsri_fronts *w)
{
    while (w->chunks) {
        struct mbsri_chunk *next = w->chunks->next;
        mbsri_release(&w->m->allocator, w->chunks);
        w->chunks = next;
    }
    mbsri_plan_destroy(w->m, w->own_plan);
    mbsri_release(&w->m->allocator, w->memory);
    w->own_plan = NULL;
    w->memory = NULL;
}
