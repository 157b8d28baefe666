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
    bool of_data;
};

void *mbsri_fronts_allocate(mbsri_fronts *w, size_t size)
{
    enum { LEAST = 1 << 14 };
    const size_t record = mbsri_rounded(sizeof(struct mbsri_chunk));
    struct mbsri_chunk *c = w->chunks;
    size = mbsri_rounded(size);
    if (!c || c->size - c->used < size) {
        size_t room = c && c->size > LEAST ? 2 * c->size : LEAST;
        if (room < size) room = size;
        c = mbsri_allocate(&w->m->allocator, record + room);
        if (!c) return NULL;
        *c = (struct mbsri_chunk){w->chunks, 0, room, false};
        w->chunks = c;
    }
    void *memory = (char *)c + record + c->used;
    c->used += size;
    return memory;
}

/* The chunk of the data, where the memory of no other fronts stands. */
static void take_chunk(mbsri_fronts *w)
{
    mbsr_data *d = w->d;
    const size_t record = mbsri_rounded(sizeof(struct mbsri_chunk));
    if (!w->m->plan || d->fronts.taken) return;
    d->fronts.taken = true;
    w->chunks = d->fronts.memory;
    *w->chunks = (struct mbsri_chunk){NULL, 0, mbsri_fronts_bytes(w->m) - record, true};
}

double *mbsri_fronts_scratch(mbsri_fronts *w, size_t numbers)
{
    if (numbers > w->scratch_size) {
        w->scratch = mbsri_fronts_allocate(w, 2 * numbers * sizeof *w->scratch);
        w->scratch_size = w->scratch ? 2 * numbers : 0;
    }
    return w->scratch;
}

/* ---- fronts, and parts of them ---- */

static size_t front_size(size_t unknowns)
{
    return (2 * unknowns * unknowns + 3 * unknowns) * sizeof(double) + unknowns * sizeof(int);
}

bool mbsri_fronts_make_room(mbsri_fronts *w, int unknowns)
{
    if (unknowns <= w->room) return true;
    const size_t room = (size_t)unknowns + (size_t)unknowns / 4;
    w->front.A = mbsri_fronts_allocate(w, front_size(room));
    w->room = w->front.A ? (int)room : 0;
    if (!w->front.A) return false;
    w->front.scale = w->front.A + 2 * room * room;
    w->front.value = w->front.scale + room;
    w->front.across = w->front.value + room;
    w->front.id = (int *)(void *)(w->front.across + room);
    return true;
}

mbsri_part *mbsri_fronts_open_part(mbsri_fronts *w, int count)
{
    const size_t n = (size_t)count;
    int step;
    const size_t room = mbsri_part_room(count, &step);
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

static size_t unknowns_of(const mbsr_model *m)
{
    return (size_t)m->rows + (size_t)m->nu + m->size.v;
}

/* Arrays over unknowns, joint rates, rows and steps. */
static size_t array_size(const mbsr_model *m, const mbsri_plan *plan)
{
    const size_t unknowns = unknowns_of(m), rows = (size_t)m->rows, nu = (size_t)m->nu;
    return (2 * unknowns + nu + rows) * sizeof(double) + 3 * (size_t)plan->steps * sizeof(void *) +
           (2 * unknowns + nu) * sizeof(int) + rows * sizeof(bool);
}

static size_t bytes_of(const mbsr_model *m, const mbsri_plan *plan)
{
    const size_t rows = (size_t)m->rows, nu = (size_t)m->nu, most = (size_t)plan->most,
                 callers = (3 * nu + 5 * rows) * sizeof(double),
                 /* of unknowns that are late: seldom more */
        late = 5 * plan->bytes / 4 + 2 * front_size(most) + (size_t)1024;
    return mbsri_rounded(array_size(m, plan)) + callers + plan->bytes + late + front_size(most + 6);
}

size_t mbsri_fronts_bytes(const mbsr_model *m)
{
    const size_t bytes = m->plan ? bytes_of(m, m->plan) : 0,
                 near = m->plan && m->plan->near ? bytes_of(m, m->plan->near) : 0;
    return bytes > near ? bytes : near;
}

/* A model without closures has no plan; one with far ends does not serve joints without inertia. */
static bool take_plan(mbsri_fronts *w, bool far)
{
    const mbsri_plan *plan = w->m->plan;
    if (!plan && !mbsri_plan_create(w->m, false, &w->own_plan)) return false;
    if (!plan) plan = w->own_plan;
    w->plan = far || !plan->far ? plan : plan->near;
    return true;
}

static int no_memory_for_fronts(const mbsri_fronts *w, const char *function)
{
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for equations of %d joint rates and %d rows of closures",
                      function, w->m->nu, w->m->rows);
}

static void leave_springs_out(mbsri_fronts *w)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    for (; c < end; ++c) {
        for (int k = 0; k < c->rows; ++k) w->left_out[c->row + k] = mbsri_is_stiff(c, k);
    }
}

int mbsri_fronts_open(mbsri_fronts *w, const mbsr_model *m, mbsr_data *d, bool far,
                      const char *function)
{
    *w = (mbsri_fronts){.m = m, .d = d};
    if (!take_plan(w, far)) return no_memory_for_fronts(w, function);
    const size_t rows = (size_t)m->rows, nu = (size_t)m->nu, unknowns = unknowns_of(m),
                 steps = (size_t)w->plan->steps;
    take_chunk(w);
    w->s = mbsri_fronts_allocate(w, array_size(m, w->plan));
    if (!w->s) return no_memory_for_fronts(w, function);
    w->v = w->s + unknowns;
    w->e = w->v + unknowns;
    w->share = w->e + nu;
    w->part = (mbsri_part **)(void *)(w->share + rows);
    w->pivots = (mbsri_pivots **)(void *)(w->part + steps);
    w->passing = (mbsri_passing **)(void *)(w->pivots + steps);
    w->slot = (int *)(void *)(w->passing + steps);
    w->set = w->slot + unknowns;
    w->free = w->set + unknowns;
    w->left_out = (bool *)(w->free + nu);
    for (size_t k = 0; k < unknowns; ++k) w->slot[k] = -1;
    leave_springs_out(w);
    return MBSR_OK;
}

bool mbsri_fronts_begin(mbsri_fronts *w)
{
    if (!w->kept) {
        w->kept = w->chunks;
        w->kept_bytes = w->chunks->used;
    }
    while (w->chunks != w->kept) {
        struct mbsri_chunk *next = w->chunks->next;
        mbsri_release(&w->m->allocator, w->chunks);
        w->chunks = next;
    }
    w->chunks->used = w->kept_bytes;
    w->room = 0;
    w->scratch_size = 0;
    for (size_t k = 0; k < sizeof w->unused / sizeof w->unused[0]; ++k) w->unused[k] = NULL;
    return mbsri_fronts_make_room(w, w->plan->most + 4);
}

void mbsri_fronts_close(mbsri_fronts *w)
{
    while (w->chunks) {
        struct mbsri_chunk *next = w->chunks->next;
        if (w->chunks->of_data)
            w->d->fronts.taken = false;
        else
            mbsri_release(&w->m->allocator, w->chunks);
        w->chunks = next;
    }
    mbsri_plan_destroy(w->m, w->own_plan);
    w->own_plan = NULL;
}
