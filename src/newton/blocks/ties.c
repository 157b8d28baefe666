/* Which bodies force elements tie across the tree, with what elimination adds: see linked.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/memory.h"
#include "newton/blocks/linked.h"
#include "newton/blocks/swept.h"
#include "newton/slopes/relation.h"

#include <math.h>

/* ---- the pattern ---- */

/* Ties while they are found, each in the lists of both bodies. */
typedef struct pattern {
    mbsr_newton *w;
    int *first;  /* N + 1, -1: none */
    int *degree; /* N + 1: to bodies that are not yet eliminated */
    int *behind; /* N + 1: successors that are not; of the head of a group, of all its bodies */
    int *ready, *left; /* heads that may go; N + 1: whether bodies are not eliminated */
    int *next, *other;
    int count, room, waiting;
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

static void list(pattern *p, int i, int j)
{
    p->next[p->count] = p->first[i];
    p->other[p->count] = j;
    p->first[i] = p->count++;
    ++p->degree[i];
}

/* Two different bodies; false: no memory. */
static bool tie(pattern *p, int i, int j)
{
    for (int k = p->first[i]; k >= 0; k = p->next[k]) {
        if (p->other[k] == j) return true;
    }
    if (p->count + 2 > p->room && !grow(p)) return false;
    list(p, i, j);
    list(p, j, i);
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

/* Body i goes, and ties what it was tied to; false: no memory. */
static bool eliminate(pattern *p, int i)
{
    enum { NUMBERS = 12, ROWS = 18, STEP = 500 };
    const int parent = p->w->model->body[i].parent, ties = p->degree[i];
    p->left[i] = 0;
    for (int k = p->first[i]; k >= 0; k = p->next[k]) {
        const int one = p->other[k];
        if (!p->left[one]) continue;
        --p->degree[one];
        if (parent > 0 && parent != one && !tie(p, parent, one)) return false;
        for (int l = p->next[k]; l >= 0; l = p->next[l]) {
            if (p->left[p->other[l]] && !tie(p, one, p->other[l])) return false;
        }
    }
    if (ties > 0) p->work += NUMBERS * (ties + 1.0) * (STEP + ties * NUMBERS * ROWS);
    return true;
}

/* Of the joints and groups behind which nothing is left, the one that is tied to the fewest bodies, or the latest that is tied to no
 * more than one: lists of thousands are not searched for less. */
static int choose(pattern *p)
{
    int at = p->waiting - 1;
    for (int k = at; k >= 0 && p->degree[p->ready[at]] > 1; --k) {
        if (p->degree[p->ready[k]] < p->degree[p->ready[at]]) at = k;
    }
    const int chosen = p->ready[at];
    --p->waiting;
    for (int k = at; k < p->waiting; ++k) p->ready[k] = p->ready[k + 1];
    return chosen;
}

/* The order, and all ties; false: no memory, or more work than `most`. */
static bool eliminate_all(pattern *p, double most, bool *memory)
{
    enum { OWN = 2500 }; /* bodies that are not tied go through memory, too */
    const mbsr_model *m = p->w->model;
    mbsri_links *v = &p->w->links;
    int done = 0;
    p->work = OWN * (double)m->bodies;
    for (int i = 1; i <= m->bodies; ++i) {
        const int head = m->body[i].parent > 0 ? m->body[m->body[i].parent].head : 0;
        p->left[i] = 1;
        if (m->body[i].head == i) ++p->behind[head];
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (m->body[i].head == i && p->behind[i] == 0) p->ready[p->waiting++] = i;
    }
    while (done < m->bodies && *memory && p->work < most) {
        const int head = choose(p);
        const int parent = m->body[head].parent, above = parent > 0 ? m->body[parent].head : 0;
        for (int k = m->body[head].members - 1; k >= 0 && *memory; --k) {
            const int i = m->member[m->body[head].at + k];
            *memory = eliminate(p, i);
            v->position[i] = done;
            v->order[done++] = i;
        }
        if (--p->behind[above] == 0 && above > 0) p->ready[p->waiting++] = above;
    }
    return *memory && p->work < most;
}

/* No ties within groups, which are eliminated in one step. */
static bool apart(const pattern *p)
{
    const mbsri_body *body = p->w->model->body;
    for (int i = 1; i <= p->w->model->bodies; ++i) {
        for (int k = p->first[i]; k >= 0; k = p->next[k]) {
            if (body[i].head == body[p->other[k]].head) return false;
        }
    }
    return true;
}

/* The same of a correction of low rank: a solution each, and a dense matrix. */
static double work_of_correction(const mbsr_newton *w)
{
    enum { STEP = 250 };
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

/* Lists of what was found, and places of its matrices. */
static void place_matrices(const pattern *p, mbsri_links *v)
{
    const mbsr_newton *w = p->w;
    const int bodies = w->model->bodies;
    int count = 0;
    v->size = v->own[0] = 0;
    for (int i = 0; i <= bodies; ++i) {
        v->first[i] = count;
        for (int k = i > 0 ? p->first[i] : -1; k >= 0; k = p->next[k]) {
            const int j = p->other[k];
            if (v->position[j] < v->position[i]) continue;
            mbsri_link *link = v->link + count++;
            link->other = j;
            link->on = take(&v->size, most_columns(w, j) * most_rows(w, i));
            link->onto = take(&v->size, most_columns(w, i) * most_rows(w, j));
        }
    }
    v->first[bodies + 1] = count;
    for (int i = 1; i <= bodies; ++i)
        v->own[i] = take(&v->size, most_columns(w, i) * most_rows(w, i));
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
    const size_t bodies = (size_t)w->model->bodies + 1, links = (size_t)p->count / 2,
                 records = links * sizeof *v->link + bodies * sizeof *v->own,
                 lists = (bodies + 1) * sizeof *v->first, places = (bodies + 1) * sizeof *v->place;
    v->memory = mbsri_allocate(allocator, records + places + lists);
    if (!v->memory) return false;
    v->link = v->memory;
    v->own = (size_t *)(void *)(v->link + links);
    v->place = (double **)(void *)(v->own + bodies);
    v->first = (int *)(void *)(v->place + bodies + 1);
    place_matrices(p, v);
    const size_t by_rate = place_answers(p, v), rates = take(&v->size, by_rate),
                 load = take(&v->size, MBSRI_TIED_LOAD * bodies),
                 motion = take(&v->size, MBSRI_SWEPT_MOTIONS * bodies),
                 sums = take(&v->size, MBSRI_TIED_SUMS * bodies), bytes = v->size * sizeof(double);
    v->store = mbsri_allocate(allocator, bytes);
    if (!v->store) return false;
    v->by_rate = v->store + rates;
    v->load = v->store + load;
    v->motion = v->store + motion;
    v->sums = v->store + sums;
    v->bytes += records + places + lists + bytes;
    w->linked = true;
    return true;
}

/* Which successor of a body is eliminated first, and a matrix for each. */
static void renumber(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    for (int k = m->bodies - 1; k >= 0; --k) {
        const int i = w->links.order[k];
        if (m->body[i].parent > 0) w->node[m->body[i].parent].last = i;
        w->node[i].slot = i - 1;
    }
    w->slots = m->bodies;
}

bool mbsri_links_create(mbsr_newton *w, bool forced)
{
    const mbsr_model *m = w->model;
    const mbsr_allocator *allocator = &m->allocator;
    mbsri_links *v = &w->links;
    const size_t bodies = (size_t)m->bodies + 1;
    pattern p = {.w = w};
    if (!serves(w)) return true;
    v->order = mbsri_allocate(allocator, 2 * bodies * sizeof(int));
    p.first = mbsri_allocate(allocator, 5 * bodies * sizeof(int));
    bool memory = v->order && p.first;
    if (memory) {
        v->position = v->order + bodies;
        v->bytes = 2 * bodies * sizeof(int);
        p.degree = p.first + bodies;
        p.behind = p.degree + bodies;
        p.ready = p.behind + bodies;
        p.left = p.ready + bodies;
        for (size_t i = 0; i < bodies; ++i) {
            p.first[i] = -1;
            p.degree[i] = p.behind[i] = p.left[i] = 0;
        }
        memory = tie_elements(&p);
        const double most = forced ? INFINITY : work_of_correction(w);
        if (memory && eliminate_all(&p, most, &memory) && apart(&p)) memory = keep(&p);
    }
    if (w->linked) renumber(w);
    if (p.next) mbsri_release(allocator, p.next);
    if (p.first) mbsri_release(allocator, p.first);
    return memory;
}

void mbsri_links_destroy(mbsr_newton *w)
{
    const mbsr_allocator *allocator = &w->model->allocator;
    if (w->links.store) mbsri_release(allocator, w->links.store);
    if (w->links.memory) mbsri_release(allocator, w->links.memory);
    if (w->links.order) mbsri_release(allocator, w->links.order);
}
