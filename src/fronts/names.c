/* Which unknowns meet in a step: see names.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/names.h"

#include "base/memory.h"
#include "recursion/closures.h"

#include <string.h>

/* ---- of one step ---- */

/* An unknown of the turn: 0 those complete, 1 rows that wait, 2 motions of other bodies. */
static void add_unknown(const mbsri_front_unknowns *x, int k, int turn, int id, int *count)
{
    const mbsr_model *m = x->m;
    const bool complete = id >= m->rows || x->plan->eliminated[id] <= k;
    const int kind = id >= m->rows + m->nu ? 2 : complete ? 0 : 1;
    if (kind != turn || x->slot[id] >= 0) return;
    x->slot[id] = *count;
    x->set[(*count)++] = id;
}

static void add_end(const mbsri_front_unknowns *x, int k, int turn, const mbsri_closure *c, int l,
                    int *count)
{
    const mbsri_body *b = x->m->body + c->body[l];
    bool any = false;
    for (int row = c->row; row < c->row + c->rows; ++row) {
        if (x->left_out[row]) continue;
        any = true;
        add_unknown(x, k, turn, row, count);
    }
    for (int j = 0; j < b->d && any; ++j)
        add_unknown(x, k, turn, mbsri_motion_name(x->m, b) + j, count);
}

static void name_turn(const mbsri_front_unknowns *x, int k, int turn, int *count)
{
    const mbsri_plan *plan = x->plan;
    const mbsri_plan_step *s = plan->step + k;
    const mbsri_closure *first = mbsri_all_closures(x->m);
    for (int l = 0; l < s->children; ++l) {
        const mbsri_part *p = x->part[plan->child[s->first + l]];
        for (int j = 0; p && j < p->count; ++j) add_unknown(x, k, turn, p->id[j], count);
    }
    for (int end = s->body > 0 ? plan->first_end[s->body] : -1; end >= 0;
         end = plan->next_end[end]) {
        if (mbsri_takes_end(x->m, plan, k, end / MBSRI_ENDS, s->body))
            add_end(x, k, turn, first + end / MBSRI_ENDS, end % MBSRI_ENDS, count);
    }
    if (s->closure < 0) return;
    const mbsri_closure *c = first + s->closure;
    for (int l = 0; l < c->bodies; ++l) {
        if (mbsri_plan_reads(c, l) && mbsri_takes_end(x->m, plan, k, s->closure, c->body[l]))
            add_end(x, k, turn, c, l, count);
    }
}

mbsri_census mbsri_fronts_names(const mbsri_front_unknowns *x, int k)
{
    const mbsri_plan_step *s = x->plan->step + k;
    const mbsri_body *b = x->m->body + s->body;
    const int motion = mbsri_motion_name(x->m, b);
    mbsri_census u = {.own = s->body > 0 ? b->d : 0};
    int count = 0;
    for (int j = 0; j < u.own; ++j) x->slot[motion + j] = 0;
    name_turn(x, k, 0, &count);
    u.complete = count;
    for (int j = 0; j < count; ++j) u.rows = u.rows || x->set[j] < x->m->rows;
    name_turn(x, k, 1, &count);
    u.waiting = count - u.complete;
    name_turn(x, k, 2, &count);
    u.motions = count - u.complete - u.waiting;
    for (int j = 0; j < u.own; ++j) {
        x->slot[motion + j] = count;
        x->set[count++] = motion + j;
    }
    return u;
}

/* ---- of a plan ---- */

enum { SIZES = 96 };

typedef struct planning {
    const mbsr_model *m;
    mbsri_plan *plan;
    mbsri_front_unknowns names;
    mbsri_part **part; /* steps */
    mbsri_array list;  /* int: names of all fronts */
    int unused[SIZES]; /* parts that were taken, by the sizes of memory */
    void *memory;
} planning;

size_t mbsri_part_room(int count, int *step)
{
    const size_t n = (size_t)count,
                 needed = sizeof(mbsri_part) + 2 * n * n * sizeof(double) + n * sizeof(int);
    size_t room = 256; /* grows by halves and thirds in turn */
    for (*step = 0; room < needed; ++*step) room = room / 2 % 3 == 0 ? room / 3 * 4 : room / 2 * 3;
    return room;
}

static void list_end_names(const mbsr_model *m, mbsri_plan *plan)
{
    const mbsri_closure *c = mbsri_all_closures(m);
    for (int i = 0; i <= m->bodies; ++i) plan->first_end[i] = -1;
    for (int id = 0; id < (int)m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k)
            plan->eliminated[c->row + k] = plan->when[m->bodies + 1 + id];
        for (int l = 0; l < c->bodies; ++l) {
            const int end = id * MBSRI_ENDS + l, i = c->body[l];
            if (!mbsri_plan_reads(c, l)) continue;
            plan->next_end[end] = plan->first_end[i];
            plan->first_end[i] = end;
        }
    }
}

/* What step k leaves of the unknowns in `set`; its place is that of these in the list, moved on. */
static mbsri_part *leave_part(planning *x, int k, const mbsri_census *u, int *id)
{
    const mbsr_model *m = x->m;
    const mbsri_body *b = m->body + x->plan->step[k].body;
    const mbsri_body *pred = m->body + (b->parent > 0 ? b->parent : 0);
    int count = u->waiting + u->motions;
    if (count == 0) return NULL;
    for (int j = 0; j < count; ++j) id[j] = x->names.set[u->complete + j];
    const int motion = mbsri_motion_name(m, pred);
    bool there = b->parent <= 0;
    for (int j = 0; j < count && !there; ++j) there = id[j] == motion;
    for (int j = 0; j < pred->d && !there; ++j) id[count++] = motion + j;
    mbsri_part *p = mbsri_allocate(&m->allocator, sizeof *p + (size_t)count * sizeof(int));
    if (!p) return NULL;
    *p = (mbsri_part){.count = count, .id = (int *)(void *)(p + 1)};
    memcpy(p->id, id, (size_t)count * sizeof *id);
    return p;
}

/* Memory of the step, as memory.c hands it out. */
static void count_memory(planning *x, int k, const mbsri_census *u)
{
    const mbsri_plan_step *s = x->plan->step + k;
    const size_t N = (size_t)(u->complete + u->waiting + u->motions + u->own),
                 pivots = (size_t)u->complete, passing = (size_t)(u->waiting + u->motions),
                 n = (size_t)x->m->body[s->body].n;
    size_t *bytes = &x->plan->bytes;
    int step;
    if (N > (size_t)x->plan->most) x->plan->most = (int)N;
    if (N > (size_t)u->own || s->children > 0)
        *bytes += mbsri_rounded(sizeof(mbsri_pivots) + pivots * (N + 1) * sizeof(double) +
                                N * sizeof(int));
    if (s->body > 0 && passing > 0)
        *bytes += mbsri_rounded(sizeof(mbsri_passing) + n * passing * sizeof(double) +
                                passing * sizeof(int));
    for (int l = 0; l < s->children; ++l) {
        mbsri_part **p = x->part + x->plan->child[s->first + l];
        if (!*p) continue;
        mbsri_part_room((*p)->count, &step);
        ++x->unused[step];
        mbsri_release(&x->m->allocator, *p);
        *p = NULL;
    }
}

static bool plan_step(planning *x, int k)
{
    const mbsr_model *m = x->m;
    mbsri_plan_step *s = x->plan->step + k;
    const mbsri_census u = mbsri_fronts_names(&x->names, k);
    const int count = u.complete + u.waiting + u.motions + u.own;
    for (int j = 0; j < count; ++j) x->names.slot[x->names.set[j]] = -1;
    s->complete = u.complete;
    s->waiting = u.waiting;
    s->motions = u.motions;
    s->own = u.own;
    s->names = x->list.count;
    if (!mbsri_reserve(&m->allocator, &x->list, (size_t)(count + m->most.d), sizeof(int)))
        return false;
    int *name = (int *)x->list.data + s->names, step;
    mbsri_part *p = x->part[k] = leave_part(x, k, &u, name);
    if (!p && u.waiting + u.motions > 0) return false;
    s->leaves = p ? p->count : 0;
    if (count > 0) memcpy(name, x->names.set, (size_t)count * sizeof *name);
    x->list.count += (size_t)count;
    count_memory(x, k, &u);
    if (!p) return true;
    const size_t room = mbsri_part_room(p->count, &step);
    if (x->unused[step] > 0)
        --x->unused[step];
    else
        x->plan->bytes += mbsri_rounded(room);
    return true;
}

static bool open_planning(planning *x)
{
    const mbsr_model *m = x->m;
    const size_t unknowns = (size_t)m->rows + (size_t)m->nu + m->size.v,
                 steps = (size_t)x->plan->steps, rows = (size_t)m->rows;
    x->memory =
        mbsri_allocate(&m->allocator, steps * sizeof(mbsri_part *) + 2 * unknowns * sizeof(int) +
                                          (rows + 1) * sizeof(bool));
    if (!x->memory) return false;
    x->part = x->memory;
    int *slot = (int *)(void *)(x->part + steps);
    bool *left_out = (bool *)(slot + 2 * unknowns);
    for (size_t k = 0; k < steps; ++k) x->part[k] = NULL;
    for (size_t k = 0; k < unknowns; ++k) slot[k] = -1;
    for (size_t k = 0; k < rows; ++k) left_out[k] = false;
    x->names = (mbsri_front_unknowns){m, x->plan, x->part, left_out, slot, slot + unknowns};
    return true;
}

bool mbsri_fronts_plan_names(const mbsr_model *m, mbsri_plan *plan)
{
    planning x = {.m = m, .plan = plan};
    bool room = open_planning(&x);
    plan->most = 0;
    plan->bytes = 0;
    list_end_names(m, plan);
    for (int k = 0; k < plan->steps && room; ++k) room = plan_step(&x, k);
    for (int k = 0; k < plan->steps && x.memory; ++k) mbsri_release(&m->allocator, x.part[k]);
    mbsri_release(&m->allocator, x.memory);
    plan->name = x.list.data;
    return room;
}
