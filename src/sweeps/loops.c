/* Loops in the vectorised sweeps: plan of a tree, memory of an evaluation.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The plan goes along the tree as the sweep will, with the rows that are open where all are
 * independent; beside each there may be one motion without inertia, as more are left to loops/. */
#include "sweeps/loops.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "base/memory.h"
#include "recursion/closures.h"

#include <math.h>
#include <string.h>

/* More unknowns at one place are for loops/. */
enum { MOST_UNKNOWNS = 256 };
enum { MOST_ENDS = MBSR_CLOSURE_BODIES + 1 }; /* of a closure */

static size_t doubles_of(size_t bytes)
{
    return (bytes + sizeof(double) - 1) / sizeof(double);
}

/* ---- ends ---- */

static unsigned rigid_rows(const mbsri_closure *c)
{
    unsigned rows = 0;
    for (int k = 0; k < c->rows; ++k) rows |= (unsigned)!mbsri_is_stiff(c, k) << k;
    return rows;
}

static void mark_way(mbsri_sweeps *tree, int from, int to)
{
    for (int i = from; i > to; i = tree->body[i].parent) tree->body[i].flags |= MBSRI_FRONT;
    tree->body[to].flags |= MBSRI_CLOSES;
}

/* Body number l of closure c, number `at` of all. */
static void list_end(mbsri_sweeps *tree, const mbsr_model *m, const mbsri_closure *c, int l, int at)
{
    mbsri_sweep_loops *w = tree->loops;
    const int i = c->body[l];
    const bool joints = mbsri_reads_joints(c);
    w->end[at] = (mbsri_sweep_loop_end){.next = w->first_end[i],
                                        .d = m->body[i].d,
                                        .n = joints ? m->body[i].n : 0,
                                        .rows = c->rows,
                                        .row = c->row,
                                        .rigid = rigid_rows(c),
                                        .coupling = mbsri_is_coupling(c),
                                        .C = c->at + (size_t)(c->column[l] * c->rows)};
    w->first_end[i] = at;
    w->joints = w->joints || joints;
    mark_way(tree, i, w->closes[c->row]);
}

static void list_loop_ends(mbsri_sweeps *tree, const mbsr_model *m)
{
    mbsri_sweep_loops *w = tree->loops;
    const mbsri_closure *c = m->closures.data;
    int ends = 0;
    for (int i = 0; i <= tree->bodies; ++i) {
        w->first_end[i] = -1;
        tree->body[i].flags &= ~(MBSRI_FRONT | MBSRI_CLOSES);
    }
    for (size_t number = 0; number < m->closures.count; ++number, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            w->closes[c->row + k] = c->meets;
            w->springs = w->springs || mbsri_is_stiff(c, k);
        }
        for (int l = 0; l < c->bodies && rigid_rows(c); ++l) {
            if (c->body[l] > 0 && c->column[l] >= 0) list_end(tree, m, c, l, ends++);
        }
    }
}

/* ---- plan ---- */

typedef struct planned_part {
    int body, count;
    int *id;
} planned_part;

typedef struct plan {
    const mbsri_sweeps *tree;
    const mbsr_model *m;
    mbsri_sweep_loops *loops;
    planned_part *part;
    int parts;
    int *names; /* behind those of all parts */
    size_t waiting;
    int *group, *unknowns; /* group of each part; unknowns of each group */
    int *last;             /* rows: a part that has the row, or -1 */
    bool serves;
} plan;

static size_t room_of(int count)
{
    return mbsri_open_size(2 * (size_t)count);
}

static void open_ends(plan *p, int i)
{
    for (int at = p->loops->first_end[i]; at >= 0; at = p->loops->end[at].next) {
        const mbsri_sweep_loop_end *end = p->loops->end + at;
        planned_part *part = p->part + p->parts++;
        *part = (planned_part){i, 0, p->names};
        for (int k = 0; k < end->rows; ++k) {
            if (end->rigid >> k & 1) part->id[part->count++] = end->row + k;
        }
        p->names += part->count;
        p->waiting += room_of(part->count);
    }
}

static int root_of_group(int *group, int k)
{
    while (group[k] != k) k = group[k] = group[group[k]];
    return k;
}

/* Pivots of up to n unknowns: their record, and what is needed beside it. */
static size_t size_of_pivots(size_t n)
{
    const size_t N = n + 6;
    return doubles_of(sizeof(mbsri_open_record)) + doubles_of(sizeof(mbsri_pivots)) + 4 * n +
           N * N + n * n + n;
}

/* Groups of parts first .. parts - 1 that share rows; the most unknowns of one. */
static int group_parts(plan *p, int i, int first)
{
    const bool closes = p->tree->body[i].flags & MBSRI_CLOSES;
    int most = 0;
    for (int k = first; k < p->parts; ++k) {
        p->group[k] = k;
        p->unknowns[k] = 0;
        for (int l = 0; l < p->part[k].count; ++l) {
            int *seen = p->last + p->part[k].id[l];
            if (*seen >= 0) p->group[root_of_group(p->group, *seen)] = k;
            *seen = k;
        }
    }
    for (int k = first; k < p->parts; ++k)
        p->unknowns[root_of_group(p->group, k)] += 2 * p->part[k].count;
    for (int k = first; k < p->parts; ++k) {
        if (p->unknowns[k] > most) most = p->unknowns[k];
        if (closes && p->unknowns[k] > 0 && p->unknowns[k] <= MOST_UNKNOWNS)
            p->loops->kept += size_of_pivots((size_t)p->unknowns[k]);
    }
    return most;
}

/* The rows that are open behind body i, each once. */
static int find_open(plan *p, int i, int first, int *open)
{
    int count = 0;
    for (int k = first; k < p->parts; ++k) {
        for (int l = 0; l < p->part[k].count; ++l) {
            const int id = p->part[k].id[l];
            if (p->last[id] >= 0 && p->loops->closes[id] < i) open[count++] = id;
            p->last[id] = -1;
        }
    }
    return count;
}

static void note_most(plan *p, int first, int most, int open)
{
    mbsri_sweep_loops *w = p->loops;
    const size_t N = (size_t)most + 6, meeting = (size_t)(p->parts - first),
                 needed = p->waiting + 2 * room_of(open) + N * N;
    if (needed > w->waiting) w->waiting = needed;
    if (meeting > w->groups) w->groups = meeting;
    if ((size_t)p->parts > w->parts) w->parts = (size_t)p->parts;
}

/* Parts first .. parts - 1 meet at body i: one part is left with the rows that are open. */
static void plan_meeting(plan *p, int i, int first, int *open)
{
    const int most = group_parts(p, i, first), count = find_open(p, i, first, open);
    if (most > MOST_UNKNOWNS) p->serves = false;
    note_most(p, first, most, count);
    while (p->parts > first) {
        const planned_part *part = p->part + --p->parts;
        p->waiting -= room_of(part->count);
        p->names = part->id;
    }
    if (count == 0) return;
    const mbsri_body *body = p->m->body + i;
    p->part[p->parts] = (planned_part){body->parent, count, p->names};
    memcpy(p->part[p->parts++].id, open, (size_t)count * sizeof *open);
    p->names += count;
    p->waiting += room_of(count);
    const size_t rates = body->n > 1 ? (size_t)body->n : 1;
    p->loops->kept += doubles_of(sizeof(mbsri_open_record)) + 2 * (size_t)count * (rates + 1);
}

static void run_plan(plan *p, int *open)
{
    for (int i = p->tree->bodies; i >= 0 && p->serves; --i) {
        int first = p->parts;
        while (first > 0 && p->part[first - 1].body == i) --first;
        open_ends(p, i);
        if (first < p->parts) plan_meeting(p, i, first, open);
    }
}

static bool make_plan(const mbsri_sweeps *tree, const mbsr_model *m, bool *serves)
{
    mbsri_sweep_loops *w = tree->loops;
    const size_t rows = (size_t)m->rows, ends = m->closures.count * MOST_ENDS,
                 parts = (size_t)tree->bodies + 1 + ends, names = rows * (2 * MOST_ENDS + 2);
    planned_part *part = mbsri_allocate(&m->allocator, parts * sizeof *part);
    int *ints = mbsri_allocate(&m->allocator, (names + rows + 2 * parts) * sizeof *ints);
    if (part && ints) {
        plan p = {.tree = tree, .m = m, .loops = w, .part = part, .names = ints, .serves = true};
        p.last = ints + names;
        p.group = p.last + rows;
        p.unknowns = p.group + parts;
        for (size_t k = 0; k < rows; ++k) p.last[k] = -1;
        run_plan(&p, ints + names - rows);
        *serves = p.serves;
    }
    const bool memory = part && ints;
    mbsri_release(&m->allocator, part);
    mbsri_release(&m->allocator, ints);
    return memory;
}

static void measure_loops(mbsri_sweeps *tree)
{
    mbsri_sweep_loops *w = tree->loops;
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        w->reach = fmax(w->reach, mbsri_norm3(b->x));
        w->slides = w->slides || b->flags & (MBSRI_SLIDES | MBSRI_MULTI);
    }
}

static size_t size_of_store(const mbsr_model *m, const mbsri_sweep_loops *w)
{
    const size_t rows = (size_t)m->rows, unknowns = rows + (size_t)m->nu,
                 ints = 2 * unknowns + 2 * w->groups;
    return 2 * unknowns + 2 * rows + doubles_of(w->parts * sizeof(mbsri_open_part)) +
           doubles_of(ints * sizeof(int)) + w->waiting + w->kept;
}

bool mbsri_sweeps_plan_loops(mbsri_sweeps *tree, const mbsr_model *m)
{
    const size_t bodies = (size_t)tree->bodies + 1, rows = (size_t)m->rows,
                 ends = m->closures.count * MOST_ENDS;
    mbsri_sweep_loops *w = mbsri_allocate(&m->allocator, sizeof *w + ends * sizeof *w->end +
                                                             (bodies + rows) * sizeof(int));
    bool serves = false;
    tree->loops = w;
    if (!w) return false;
    *w = (mbsri_sweep_loops){.end = (mbsri_sweep_loop_end *)(void *)(w + 1)};
    w->first_end = (int *)(void *)(w->end + ends);
    w->closes = w->first_end + bodies;
    list_loop_ends(tree, m);
    measure_loops(tree);
    if (!make_plan(tree, m, &serves)) return false;
    if (serves)
        w->doubles = size_of_store(m, w);
    else
        mbsri_sweeps_release_loops(m, tree);
    return true;
}

void mbsri_sweeps_release_loops(const mbsr_model *m, mbsri_sweeps *tree)
{
    mbsri_release(&m->allocator, tree->loops);
    tree->loops = NULL;
}

/* ---- an evaluation ---- */

static double *next_doubles(double **at, size_t count)
{
    double *place = *at;
    *at += count;
    return place;
}

/* The longest lever between neighbours; of rows see loops_meet.c. */
static double lever_of(const mbsri_sweep_run *run)
{
    const mbsri_sweep_loops *w = run->tree->loops;
    double lever = fmax(run->model->typical.length, w->reach);
    for (int i = 1; i <= run->tree->bodies && w->slides; ++i)
        lever = fmax(lever, mbsri_norm3(run->state[i].rho));
    return lever;
}

static void clear_spring_rows(const mbsr_model *m, double *row)
{
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k)) row[c->row + k] = 0.0;
        }
    }
}

void mbsri_open_loops_place(mbsri_loop_run *w, const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    const mbsri_sweep_loops *loops = run->tree->loops;
    const size_t rows = (size_t)m->rows, unknowns = rows + (size_t)m->nu;
    *w = (mbsri_loop_run){.run = run, .loops = loops};
    double *at = run->data->loop_store;
    w->part =
        (mbsri_open_part *)(void *)next_doubles(&at, doubles_of(loops->parts * sizeof *w->part));
    w->s = next_doubles(&at, unknowns);
    w->v = next_doubles(&at, unknowns);
    w->rest = next_doubles(&at, rows);
    w->share = next_doubles(&at, rows);
    w->slot = (int *)(void *)next_doubles(
        &at, doubles_of((2 * unknowns + 2 * loops->groups) * sizeof(int)));
    w->set = w->slot + unknowns;
    w->group = w->set + unknowns;
    w->mate = w->group + loops->groups;
    w->room = at;
    for (size_t k = 0; k < unknowns; ++k) w->slot[k] = -1;
    mbsri_zero(rows, w->v);
}

void mbsri_open_loops_begin(mbsri_loop_run *w)
{
    if (w->loops->springs) clear_spring_rows(w->run->model, w->rest);
    w->size = mbsri_largest(w->run->model->rows, w->rest);
    w->lever = lever_of(w->run);
}

void mbsri_open_loops_start(mbsri_loop_run *w)
{
    for (int k = 0; k < w->run->model->rows; ++k) {
        w->s[k] = -w->rest[k];
        w->share[k] = 0.0;
    }
    w->parts = 0;
    w->top = w->room;
    w->store = w->room + w->loops->waiting;
    w->last = NULL;
    w->stuck = false;
}

void *mbsri_open_loops_keep(mbsri_loop_run *w, int body, size_t size)
{
    mbsri_open_record *kept = (mbsri_open_record *)(void *)w->store;
    *kept = (mbsri_open_record){.before = w->last, .body = body};
    w->last = kept;
    w->store += doubles_of(sizeof *kept) + doubles_of(size);
    return kept + 1;
}

/* One row and column of zeros more; the target begins behind the source. */
static void widen(size_t n, const double *from, double *to)
{
    for (size_t l = 0; l <= n; ++l) to[n * (n + 1) + l] = 0.0;
    for (size_t k = n; k-- > 0;) {
        to[k * (n + 1) + n] = 0.0;
        for (size_t l = n; l-- > 0;) to[k * (n + 1) + l] = from[k * n + l];
    }
}

mbsri_open mbsri_open_loops_append(mbsri_loop_run *w, int id)
{
    mbsri_open_part *part = w->part + w->parts - 1;
    const mbsri_open from = mbsri_open_at(part);
    const size_t n = (size_t)from.count;
    ++part->count;
    const mbsri_open to = mbsri_open_at(part);
    memmove(to.id, from.id, n * sizeof *to.id);
    to.id[n] = id;
    widen(n, from.sizes, to.sizes);
    widen(n, from.F, to.F);
    memmove(to.lengths, from.lengths, 8 * n * sizeof *to.lengths);
    mbsri_zero(8, to.lengths + 8 * n);
    mbsri_zero(8, to.Q + 8 * n);
    w->top = part->at + mbsri_open_size(n + 1);
    return to;
}
