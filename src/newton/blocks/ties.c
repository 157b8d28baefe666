/* Which bodies force elements tie across the tree, with what elimination adds: see linked.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/memory.h"
#include "newton/blocks/linked.h"
#include "newton/blocks/swept.h"
#include "newton/slopes/relation.h"

/* ---- the pattern ---- */

/* Ties while they are found: lists of each body. */
typedef struct pattern {
    mbsr_newton *w;
    int *first; /* N + 1, -1: none */
    int *next, *other;
    int count, room;
    double work; /* of passing them, about, in multiplications */
} pattern;

static bool grow(pattern *p)
{
    const mbsr_allocator *allocator = &p->w->model->allocator;
    const int room = 2 * p->room + 64;
    int *next = mbsri_allocate(allocator, 2 * (size_t)room * sizeof(int));
    if (!next) return false;
    for (int k = 0; k < p->count; ++k) {
        next[k] = p->next[k];
        next[room + k] = p->other[k];
    }
    if (p->next) mbsri_release(allocator, p->next);
    p->next = next;
    p->other = next + room;
    p->room = room;
    return true;
}

/* Two different bodies; false: no memory. */
static bool tie(pattern *p, int i, int j)
{
    const int body = i > j ? i : j, other = i > j ? j : i;
    for (int k = p->first[body]; k >= 0; k = p->next[k]) {
        if (p->other[k] == other) return true;
    }
    if (p->count == p->room && !grow(p)) return false;
    p->next[p->count] = p->first[body];
    p->other[p->count] = other;
    p->first[body] = p->count++;
    return true;
}

/* What the elements tie; false: no memory. */
static bool tie_elements(pattern *p)
{
    const mbsr_model *m = p->w->model;
    const mbsri_force *forces = m->forces.data;
    for (int k = 0; k < p->w->correction.count; ++k) {
        const mbsri_force *force = forces + p->w->correction.element[k].force;
        const int *body = m->list_index + force->list;
        for (int i = 0; i < force->def.bodies; ++i) {
            for (int j = 0; j < i; ++j) {
                if (body[i] == 0 || body[j] == 0) continue;
                if (mbsri_relate(m, body[i], body[j]) != MBSRI_APART) continue;
                if (!tie(p, body[i], body[j])) return false;
            }
        }
    }
    return true;
}

/* What eliminating body i ties; false: no memory. */
static bool tie_rest(pattern *p, int i)
{
    enum { NUMBERS = 12, ROWS = 18, STEP = 500 };
    const int parent = p->w->model->body[i].parent;
    int ties = 0;
    for (int k = p->first[i]; k >= 0; k = p->next[k]) {
        ++ties;
        if (parent > 0 && parent != p->other[k] && !tie(p, parent, p->other[k])) return false;
        for (int l = p->next[k]; l >= 0; l = p->next[l]) {
            if (!tie(p, p->other[k], p->other[l])) return false;
        }
    }
    if (ties > 0) p->work += NUMBERS * (ties + 1.0) * (STEP + ties * NUMBERS * ROWS);
    return true;
}

/* Bodies of a group are eliminated with its head: none to which one is tied may come before. */
static bool in_order(const pattern *p)
{
    const mbsr_model *m = p->w->model;
    for (int i = 1; i <= m->bodies; ++i) {
        for (int k = p->first[i]; k >= 0; k = p->next[k]) {
            if (m->body[i].head <= p->other[k]) return false;
        }
    }
    return true;
}

/* The same of a correction of low rank: a solution each, and a dense matrix. */
static double work_of_correction(const mbsr_newton *w)
{
    enum { STEP = 400 };
    double rank = 0.0;
    for (int k = 0; k < w->correction.count; ++k) {
        int rows, columns;
        mbsri_slopes_shape(
            w->model, (const mbsri_force *)w->model->forces.data + w->correction.element[k].force,
            &rows, &columns);
        rank += 0.5 * rows;
    }
    return rank * (STEP * (double)w->model->bodies + rank * rank);
}

/* Whether all elements leave joints alone, and nothing else ties bodies. */
static bool serves(const mbsr_newton *w)
{
    const mbsri_force *force = w->model->forces.data;
    if (w->model->rows > 0 || w->lean) return false;
    for (int k = 0; k < w->correction.count; ++k) {
        const unsigned flags = force[w->correction.element[k].force].def.table->flags;
        if (!(flags & MBSR_FORCE_NO_JOINT)) return false;
    }
    return w->correction.count > 0;
}

static size_t largest(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* Numbers of x, of y and of unknowns, whichever elimination it is. */
static size_t most_columns(const mbsr_newton *w, int i)
{
    return largest(MBSRI_SWEPT_MOTIONS, (size_t)(w->node[i].e + w->model->body[i].d));
}

static size_t most_rows(const mbsr_newton *w, int i)
{
    return largest(MBSRI_SWEPT_ACTIONS, 3 * (size_t)w->model->body[i].d);
}

static size_t most_rates(const mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    return (size_t)(b->group_n > b->n ? b->group_n : b->n);
}

/* Of the joint, or of the group it is the head of: unknowns, and the loads on its bodies. */
static size_t most_answers(const mbsr_newton *w, int i)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    size_t count = 2 * most_rates(w, i) + 3 * (size_t)b->d;
    for (int k = 1; k < b->members; ++k) count += 3 * (size_t)m->body[m->member[b->at + k]].d;
    return count;
}

static size_t take(size_t *used, size_t count)
{
    const size_t at = *used;
    *used += count;
    return at;
}

/* Lists of what was found, and places of its matrices; `own` is zero where nothing is tied. */
static void place_matrices(const pattern *p, mbsri_links *v)
{
    const mbsr_newton *w = p->w;
    const int bodies = w->model->bodies;
    int count = 0;
    v->size = 1; /* so that no place is zero */
    for (int i = 0; i <= bodies; ++i) v->own[i] = 0;
    for (int i = 0; i <= bodies; ++i) {
        v->first[i] = count;
        for (int k = i > 0 ? p->first[i] : -1; k >= 0; k = p->next[k]) {
            const int j = p->other[k];
            mbsri_link *link = v->link + count++;
            link->other = j;
            link->on = take(&v->size, most_columns(w, j) * most_rows(w, i));
            link->onto = take(&v->size, most_columns(w, i) * most_rows(w, j));
            v->own[i] = v->own[j] = 1;
        }
    }
    v->first[bodies + 1] = count;
    for (int i = 1; i <= bodies; ++i) {
        if (v->own[i] > 0) v->own[i] = take(&v->size, most_columns(w, i) * most_rows(w, i));
    }
    v->matrices = v->size;
}

/* The rest of the doubles; returns those of by_rate. */
static size_t place_answers(const pattern *p, mbsri_links *v)
{
    const mbsr_newton *w = p->w;
    size_t most = 0;
    for (int i = 1; i <= w->model->bodies; ++i) {
        size_t rows = 0;
        for (int k = v->first[i]; k < v->first[i + 1]; ++k) {
            const int j = v->link[k].other;
            v->link[k].answer = take(&v->size, most_columns(w, j) * most_answers(w, i));
            rows += most_rows(w, j);
        }
        most = largest(most, rows * most_rates(w, i));
    }
    return most;
}

/* Memory of what was found. */
static bool keep(const pattern *p)
{
    mbsr_newton *w = p->w;
    mbsri_links *v = &w->links;
    const mbsr_allocator *allocator = &w->model->allocator;
    const size_t bodies = (size_t)w->model->bodies + 1, links = (size_t)p->count,
                 records = links * sizeof *v->link + bodies * sizeof *v->own,
                 lists = (bodies + 1) * sizeof *v->first, places = (bodies + 1) * sizeof *v->place;
    v->memory = mbsri_allocate(allocator, records + places + lists);
    if (!v->memory) return false;
    v->link = v->memory;
    v->own = (size_t *)(void *)(v->link + links);
    v->place = (double **)(void *)(v->own + bodies);
    v->first = (int *)(void *)(v->place + bodies + 1);
    place_matrices(p, v);
    const size_t by_rate = place_answers(p, v), loads = take(&v->size, by_rate),
                 load = take(&v->size, MBSRI_SWEPT_ACTIONS * bodies),
                 motion = take(&v->size, MBSRI_SWEPT_MOTIONS * bodies),
                 bytes = v->size * sizeof(double);
    v->store = mbsri_allocate(allocator, bytes);
    if (!v->store) return false;
    v->by_rate = v->store + loads;
    v->load = v->store + load;
    v->motion = v->store + motion;
    v->bytes = records + places + lists + bytes;
    w->linked = true;
    return true;
}

bool mbsri_links_create(mbsr_newton *w, bool forced)
{
    const mbsr_model *m = w->model;
    const mbsr_allocator *allocator = &m->allocator;
    if (!serves(w)) return true;
    const double most = work_of_correction(w);
    pattern p = {.w = w};
    p.first = mbsri_allocate(allocator, ((size_t)m->bodies + 1) * sizeof(int));
    if (!p.first) return false;
    for (int i = 0; i <= m->bodies; ++i) p.first[i] = -1;
    bool memory = tie_elements(&p);
    for (int i = m->bodies; i > 0 && memory && (forced || p.work < most); --i)
        memory = tie_rest(&p, i);
    if (memory && (forced || p.work < most) && in_order(&p)) memory = keep(&p);
    if (p.next) mbsri_release(allocator, p.next);
    mbsri_release(allocator, p.first);
    return memory;
}

void mbsri_links_destroy(mbsr_newton *w)
{
    const mbsr_allocator *allocator = &w->model->allocator;
    if (w->links.store) mbsri_release(allocator, w->links.store);
    if (w->links.memory) mbsri_release(allocator, w->links.memory);
}
