/* Closures in the elimination on the tree: see carried.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/carried.h"

#include "algebra/dense.h"
#include "base/memory.h"
#include "newton/blocks/swept.h"
#include "newton/slopes/closure_slopes.h"
#include "recursion/closures.h"
#include "recursion/group.h"
#include "sweeps/tree.h"

#include <math.h>

static const mbsri_closure *closure_of(const mbsr_newton *w, int k)
{
    return (const mbsri_closure *)w->model->closures.data + k;
}

static int closures_of(const mbsr_newton *w)
{
    return (int)w->model->closures.count;
}

/* Those that the definition names; a root that moves may stand behind them. */
static int bodies_of(const mbsri_closure *c)
{
    return c->def.bodies;
}

/* ---- where a closure closes ---- */

/* The successor of `body` behind which body i stands, or is. */
static int successor(const mbsr_model *m, int body, int i)
{
    while (m->body[i].parent != body) i = m->body[i].parent;
    return i;
}

static int find(int *set, int i)
{
    while (set[i] != i) i = set[i] = set[set[i]];
    return i;
}

/* Successors that a loop ties together become one set; ones that none does are sets of 0. */
static void tie(const mbsr_newton *w, int k, int body, int *set)
{
    const mbsri_closure *c = closure_of(w, k);
    int first = 0;
    for (int l = 0; l < bodies_of(c); ++l) {
        if (c->body[l] == body) continue;
        const int i = successor(w->model, body, c->body[l]);
        if (set[i] == 0) set[i] = i;
        if (first == 0) first = i;
        set[find(set, i)] = find(set, first);
    }
}

static void number_fronts(mbsr_newton *w, int *set)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    for (int i = 0; i <= m->bodies; ++i) set[i] = v->first_closing[i] = 0;
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        v->loop[k].level = 2 * c->meets + 1;
        tie(w, k, c->meets, set);
    }
    v->fronts = m->bodies + 1;
    for (int i = 0; i <= m->bodies; ++i) {
        v->front[i] = (mbsri_front){.level = 2 * i};
        v->pool[i] = (mbsri_pool){.body = i, .up = i > 0 ? m->body[i].parent : 0};
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const int parent = m->body[i].parent;
        if (set[i] == 0) continue;
        mbsri_pool *head = v->pool + find(set, i); /* which need not be the first of the set */
        if (head->up <= m->bodies) {
            const int k = v->fronts++;
            v->front[k] = (mbsri_front){.level = 2 * parent + 1, .next = v->first_closing[parent]};
            v->pool[k] = (mbsri_pool){.body = parent, .up = parent};
            v->first_closing[parent] = k;
            head->up = k;
        }
        v->pool[i].up = head->up;
    }
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        const int body = c->meets;
        v->loop[k].pool = body;
        for (int l = 0; l < bodies_of(c); ++l) {
            if (c->body[l] != body) v->loop[k].pool = v->pool[successor(m, body, c->body[l])].up;
        }
    }
}

static void list_ends(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    int used = 0;
    for (int i = 0; i <= w->model->bodies; ++i) v->first_end[i] = -1;
    for (int k = closures_of(w) - 1; k >= 0; --k) {
        const mbsri_closure *c = closure_of(w, k);
        for (int l = bodies_of(c) - 1; l >= 0; --l) {
            const int body = c->body[l];
            if (body == 0) continue;
            v->end[used] = (mbsri_loop_end){
                .closure = k, .slot = l, .next = v->first_end[body], .d = w->model->body[body].d};
            v->first_end[body] = used++;
        }
    }
}

/* ---- names ---- */

/* What crosses the tree of the derivatives of its forces has this rank at most. */
static int crossing(const mbsri_closure *c)
{
    bool own = (c->def.table->flags & MBSR_CLOSURE_OWN) != 0;
    for (int k = 0; k < c->rows && !mbsri_is_coupling(c); ++k) own = own && !mbsri_is_stiff(c, k);
    return own || bodies_of(c) < 2 ? 0 : c->columns;
}

static void name_all(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    v->multipliers = m->rows + m->held;
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        v->loop[k].across = v->multipliers;
        v->loop[k].most = crossing(c);
        v->multipliers += v->loop[k].most;
    }
    v->names = v->multipliers + (int)w->size_n;
}

static void list_names(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        for (int l = 0; l < c->rows; ++l) v->closure[mbsri_name_lambda(c, l)] = k;
        for (int l = 0; l < c->held; ++l) v->closure[mbsri_name_eta(m, c, l)] = k;
        for (int l = 0; l < v->loop[k].most; ++l) v->closure[v->loop[k].across + l] = k;
    }
}

/* ---- how much is carried ---- */

/* Adds closure k to what front i and those above carry; seen: the last closure that did. lambda: rows
 * lambda that a front hands on. */
static void count_path(mbsr_newton *w, int k, int i, int *seen, int *lambda)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *c = closure_of(w, k);
    const int unknowns = c->rows + c->held + v->loop[k].most, last = v->loop[k].pool;
    while (seen[i] != k + 1) {
        seen[i] = k + 1;
        v->pool[i].most += unknowns;
        if (i == last) return;
        v->front[i].passes = true;
        lambda[i] += c->rows;
        i = v->pool[i].up;
    }
}

/* What front i may delay, joints of `n` rates; adds it to the pool above. */
static void count_delayed(mbsri_carried *v, int i, int n, const int *lambda)
{
    mbsri_front *front = v->front + i;
    const int all = front->delayed + n; /* so far: what comes from behind */
    v->pool[i].most += front->delayed;
    v->pool[i].loose = front->delayed > 0;
    front->delayed = all < lambda[i] ? all : lambda[i];
    v->front[v->pool[i].up].delayed += front->delayed;
}

static void count_carried(mbsr_newton *w, int *seen, int *lambda)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    for (int i = 0; i < v->fronts; ++i) seen[i] = lambda[i] = 0;
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        for (int l = 0; l < bodies_of(c); ++l) {
            const int body = c->body[l];
            const bool closed = body == v->loop[k].level / 2;
            if (!closed || v->loop[k].pool == body) count_path(w, k, body, seen, lambda);
            if (closed) count_path(w, k, v->loop[k].pool, seen, lambda);
        }
    }
    for (int i = m->bodies; i >= 0; --i) {
        for (int k = v->first_closing[i]; k > 0; k = v->front[k].next)
            count_delayed(v, k, 0, lambda);
        if (i > 0) count_delayed(v, i, m->body[i].n, lambda);
    }
    for (int i = 0; i < v->fronts; ++i) {
        if (v->pool[i].most > 0) v->used[v->uses++] = i;
    }
    for (int i = 0; i <= m->bodies; ++i) v->served[i] = i > 0 && v->pool[i].most > 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_group g = mbsri_group_in_model(m, m->body[i].head);
        bool any = false;
        for (int k = 0; k < g.members; ++k) any = any || v->served[g.member[k]];
        for (int k = 0; k < g.members; ++k) v->served[g.member[k]] = any;
    }
}

/* ---- memory ---- */

static size_t take(size_t *used, size_t count)
{
    const size_t at = *used;
    *used += count;
    return at;
}

static void place_pool(mbsri_pool *pool, size_t *doubles, size_t *ints)
{
    const size_t most = (size_t)pool->most;
    pool->column = take(ints, 2 * most);
    pool->place = take(ints, most);
    pool->Q = *doubles;
    *doubles = mbsri_pool_end(pool);
    pool->right = take(doubles, most);
}

static void shape_pools(mbsr_newton *w)
{
    const mbsri_sweeps *tree = w->model->whole;
    for (int k = 0; k < w->carried.fronts; ++k) {
        mbsri_pool *pool = w->carried.pool + k, *swept = w->carried.swept + k;
        const int body = pool->body, d = w->model->body[body].d;
        pool->stride = (short)(3 * d);
        pool->motions = (short)(w->node[body].e + 2 * d);
        *swept = (mbsri_pool){.body = body,
                              .up = pool->up,
                              .loose = pool->loose,
                              .swept = body > 0 && !(tree->body[body].flags & MBSRI_BLOCK),
                              .stride = MBSRI_SWEPT_ACTIONS,
                              .motions = MBSRI_SWEPT_MOTIONS};
    }
    for (int i = 1; i <= w->model->bodies; ++i) { /* loops that close on the root, as before it */
        const int up = w->carried.pool[i].up;
        if (up > w->model->bodies) w->carried.swept[up].swept = w->carried.swept[i].swept;
    }
    mbsri_carried *v = &w->carried;
    for (int k = 0; k < v->uses; ++k) {
        const int i = v->used[k];
        if (v->swept[i].swept) continue;
        v->used[k] = v->used[v->apart];
        v->used[v->apart++] = i;
    }
}

/* Unknowns of pools that the front of joint i may read; those of its group, where it is the head. */
static int unknowns_behind(const mbsr_newton *w, int i)
{
    const mbsr_model *m = w->model;
    const mbsri_carried *v = &w->carried;
    if (m->body[i].members < 2) return v->pool[i].most;
    const mbsri_group g = mbsri_group_in_model(m, i);
    int sum = 0;
    for (int k = 0; k < g.members; ++k) {
        sum += v->pool[g.member[k]].most;
        for (int l = v->first_closing[g.member[k]]; l > 0; l = v->front[l].next)
            sum += v->pool[l].most;
    }
    return sum;
}

static void widen(mbsri_carried *v, size_t work)
{
    if (work > v->widest) v->widest = work;
}

static void place_front(const mbsr_newton *w, int i, size_t *doubles, size_t *ints)
{
    mbsri_carried *v = (mbsri_carried *)&w->carried;
    mbsri_front *front = v->front + i;
    const mbsr_model *m = w->model;
    const int up = v->pool[i].up;
    const bool joint = i <= m->bodies;
    const mbsri_body *b = m->body + i, *above = m->body + v->pool[up].body;
    const size_t n = joint ? (size_t)b->group_n : 0, nq = joint ? (size_t)b->group_nq : 0,
                 k = (size_t)(joint ? unknowns_behind(w, i) : v->pool[i].most), size = 2 * n + k,
                 d = (size_t)above->d, x = (size_t)w->node[v->pool[up].body].e + 2 * d;
    const bool swept = v->swept[up].swept;
    const size_t rows = size + (swept ? MBSRI_SWEPT_ACTIONS : 3 * d),
                 motions = swept ? MBSRI_SWEPT_MOTIONS : x;
    front->most = (int)size;
    front->column = take(ints, k);
    front->row = take(ints, k);
    front->swap_column = take(ints, size);
    front->swap_row = take(ints, size);
    front->place = take(ints, size);
    front->LU = take(doubles, size * (rows + size + motions));
    if (rows * (size + motions) > v->largest) v->largest = rows * (size + motions);
    front->Mq = take(doubles, (size + 3 * d) * nq);
    front->along = take(doubles, nq * k);
    front->momentum = take(doubles, n * k);
    front->rate = take(doubles, n * k);
    front->right = take(doubles, rows);
    /* work, see front.c */
    const size_t columns = x + nq + 2 * n, members = joint ? (size_t)m->body[i].members + 1 : 0,
                 width = k + columns + 5 * n + 4 * d + members * 4 * (size_t)m->max_d;
    widen(v, k * (width + MBSRI_SWEPT_FORCES) + 2 * columns + 4 * (rows + n));
    if ((int)size > v->most) v->most = (int)size;
}

static void place_slopes(mbsr_newton *w, size_t *doubles)
{
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        mbsri_loop *loop = w->carried.loop + k;
        const size_t columns = (size_t)c->columns, most = (size_t)loop->most;
        loop->S = take(doubles, columns * columns);
        loop->slope = take(doubles, (size_t)c->rows * columns);
        loop->left = take(doubles, columns * most);
        loop->read = take(doubles, columns * most);
        widen(&w->carried, mbsri_closure_tangents_work(c));
    }
}

/* Of closures whose derivatives do not move they stay zero. */
static void clear_slopes(mbsr_newton *w)
{
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = closure_of(w, k);
        const mbsri_loop *loop = w->carried.loop + k;
        const size_t columns = (size_t)c->columns;
        if (!mbsri_closure_is_constant(c)) continue;
        mbsri_zero(columns * columns, w->carried.store + loop->S);
        mbsri_zero((size_t)c->rows * columns, w->carried.store + loop->slope);
    }
}

static bool place_all(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    size_t doubles = 0, ints = 0;
    shape_pools(w);
    for (int i = 1; i < v->fronts; ++i) {
        if (i <= m->bodies && !v->served[i]) continue;
        place_pool(v->pool + i, &doubles, &ints);
        place_front(w, i, &doubles, &ints);
    }
    if (!mbsri_swept_place(w, &doubles, &ints)) return false;
    place_slopes(w, &doubles);
    const size_t value = take(&doubles, (size_t)v->names), work = take(&doubles, v->widest),
                 matrix = take(&doubles, v->largest), list = take(&ints, 4 * (size_t)v->most);
    v->bytes += doubles * sizeof(double) + ints * sizeof(int);
    v->store = mbsri_allocate(&m->allocator, doubles * sizeof(double) + ints * sizeof(int) + 8);
    if (!v->store) return false;
    v->numbers = (int *)(void *)(v->store + doubles);
    v->value = v->store + value;
    v->work = v->store + work;
    v->matrix = v->store + matrix;
    v->list = v->numbers + list;
    clear_slopes(w);
    return true;
}

/* The next `count` records of that size of a block, which begin at lines of the cache. */
static void *records(void *memory, size_t *used, size_t count, size_t size)
{
    const size_t line = MBSR_DATA_ALIGNMENT;
    void *place = memory ? (unsigned char *)memory + *used : NULL;
    *used += (count * size + line - 1) / line * line;
    return place;
}

static size_t place_records(mbsr_newton *w, void *memory, int **scratch)
{
    mbsri_carried *v = &w->carried;
    size_t used = 0, ends = 0;
    const size_t bodies = (size_t)w->model->bodies + 1, closures = (size_t)closures_of(w),
                 fronts = bodies + closures;
    for (int k = 0; k < closures_of(w); ++k) ends += (size_t)bodies_of(closure_of(w, k));
    v->loop = records(memory, &used, closures, sizeof *v->loop);
    v->end = records(memory, &used, ends, sizeof *v->end);
    v->first_end = records(memory, &used, bodies, sizeof(int));
    v->first_closing = records(memory, &used, bodies, sizeof(int));
    v->served = records(memory, &used, bodies, sizeof(bool));
    v->used = records(memory, &used, fronts, sizeof(int));
    v->multiplier =
        records(memory, &used, (size_t)(w->model->rows + w->model->held), sizeof *v->multiplier);
    v->pool = records(memory, &used, fronts, sizeof *v->pool);
    v->swept = records(memory, &used, fronts, sizeof *v->swept);
    v->front = records(memory, &used, fronts, sizeof *v->front);
    *scratch = records(memory, &used, 2 * fronts, sizeof(int));
    return used;
}

bool mbsri_carried_create(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    const mbsr_allocator *allocator = &w->model->allocator;
    int *scratch;
    const size_t bytes = place_records(w, NULL, &scratch);
    v->memory = mbsri_allocate(allocator, bytes);
    if (!v->memory) return false;
    v->bytes = bytes;
    (void)place_records(w, v->memory, &scratch);
    number_fronts(w, scratch);
    name_all(w);
    count_carried(w, scratch, scratch + v->fronts);
    list_ends(w);
    v->closure = mbsri_allocate(allocator, (size_t)(v->multipliers + 1) * sizeof(int));
    if (!v->closure) return false;
    v->bytes += (size_t)(v->multipliers + 1) * sizeof(int);
    list_names(w);
    return place_all(w);
}

void mbsri_carried_destroy(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    const mbsr_allocator *allocator = &w->model->allocator;
    if (v->store) mbsri_release(allocator, v->store);
    if (v->closure) mbsri_release(allocator, v->closure);
    if (v->memory) mbsri_release(allocator, v->memory);
}

/* ---- pools ---- */

mbsri_pool *mbsri_carried_up(const mbsr_newton *w, int k)
{
    const mbsri_carried *v = &w->carried;
    const int up = v->pool[k].up;
    /* a block hands numbers of its own kind to a body in vector code, multipliers never */
    return v->swept[k].swept ? mbsri_carried_at(w, up) : v->pool + up;
}

int mbsri_carried_motions(const mbsr_newton *w, const mbsri_pool *pool)
{
    if (pool->body == 0) return 0;
    return pool->swept ? MBSRI_SWEPT_MOTIONS
                       : mbsri_motions(w->node + pool->body, w->model->body + pool->body);
}

int mbsri_carried_actions(const mbsr_newton *w, const mbsri_pool *pool)
{
    const int body = pool->body;
    if (body == 0) return 0;
    if (pool->swept) return w->node[body].deep ? MBSRI_SWEPT_ACTIONS : MBSRI_SWEPT_ACTIONS - 8;
    return mbsri_actions(w->node + body, w->model->body + body);
}

/* Place `at` of the pool, with nothing in it. */
static void clear(mbsr_newton *w, const mbsri_pool *pool, int at)
{
    double *store = w->carried.store;
    const int most = pool->most, d = pool->stride / 3;
    mbsri_zero((size_t)pool->stride, store + pool->Q + (size_t)(at * pool->stride));
    mbsri_zero((size_t)d, store + mbsri_pool_kappa(pool) + (size_t)(at * d));
    mbsri_zero((size_t)pool->motions, store + mbsri_pool_R(pool) + (size_t)(at * pool->motions));
    for (int l = 0; l <= at; ++l) {
        store[mbsri_pool_T(pool) + (size_t)(l * most + at)] = 0.0;
        store[mbsri_pool_T(pool) + (size_t)(at * most + l)] = 0.0;
    }
}

int mbsri_carried_join(mbsr_newton *w, mbsri_pool *pool, int name)
{
    int *column = w->carried.numbers + pool->column,
        *row = w->carried.numbers + mbsri_pool_row(pool);
    int at = mbsri_carried_find(column, pool->count, name);
    if (at >= 0) return at;
    at = pool->count++;
    column[at] = row[at] = name;
    clear(w, pool, at);
    return at;
}

/* ---- what a closure is at a body ---- */

/* The place of the body's columns in matrices over all of the closure. */
typedef struct site {
    const mbsri_closure *c;
    mbsri_loop *loop;
    mbsri_pool *pool;
    int column, d, e;
} site;

/* Adds to row `at` of the pool s times what row k of `from` (rows) reads of the body's columns, from
 * column `to` of x on. */
static void add_row(mbsr_newton *w, const site *s, int at, int to, double factor, int rows,
                    const double *from, int k)
{
    double *R = w->carried.store + mbsri_pool_R(s->pool);
    for (int l = 0; l < s->d; ++l)
        R[at * s->pool->motions + to + l] +=
            factor * from[(size_t)(s->column + l) * (size_t)rows + (size_t)k];
}

/* Adds a force on the body to column `at` of the pool: entry l is from[l * stride]. */
static void add_force(mbsr_newton *w, const site *s, int at, const double *from, int stride)
{
    const int body = s->pool->body;
    double *Q = w->carried.store + s->pool->Q + (size_t)(at * s->pool->stride);
    for (int l = 0; l < s->d; ++l) {
        Q[s->d + l] -= from[l * stride];
        if (w->node[body].deep) Q[2 * s->d + l] += from[l * stride];
    }
}

static void add_end(mbsr_newton *w, const mbsr_data *d, int closure, int slot)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    const mbsri_closure *c = closure_of(w, closure);
    const int body = c->body[slot];
    site s = {.c = c, .loop = v->loop + closure, .column = c->column[slot]};
    if (body == 0) return;
    const int number = body == s.loop->level / 2 ? s.loop->pool : body;
    if (w->mixed && v->swept[number].swept) return; /* see swept.h */
    s.pool = v->pool + number;
    s.d = m->body[body].d;
    s.e = w->node[body].e;
    const double *C = d->closure_C + c->at, *slope = v->store + s.loop->slope;
    for (int k = 0; k < c->rows; ++k) {
        if (d->dropped[c->row + k] && !mbsri_is_stiff(c, k)) continue;
        const int lambda = mbsri_carried_join(w, s.pool, mbsri_name_lambda(c, k));
        const double *row = C + (size_t)s.column * (size_t)c->rows + k;
        add_force(w, &s, lambda, row, c->rows);
        add_row(w, &s, lambda, s.e, 1.0, c->rows, C, k);
        add_row(w, &s, lambda, 0, 1.0, c->rows, slope, k);
        if (k >= c->held || d->dropped[c->row + k]) continue;
        const int eta = mbsri_carried_join(w, s.pool, mbsri_name_eta(m, c, k));
        double *kappa = v->store + mbsri_pool_kappa(s.pool) + (size_t)(eta * s.d);
        for (int l = 0; l < s.d; ++l) kappa[l] += row[l * c->rows];
        add_row(w, &s, eta, 0, 1.0, c->rows, C, k);
    }
    for (int k = 0; k < s.loop->rank; ++k) {
        const int at = mbsri_carried_join(w, s.pool, s.loop->across + k);
        add_force(w, &s, at, v->store + s.loop->left + (size_t)(k * c->columns + s.column), 1);
        add_row(w, &s, at, 0, -1.0, s.loop->most, v->store + s.loop->read, k);
    }
}

/* What of its rows stands in the multipliers alone. */
static void add_diagonal(mbsr_newton *w, const mbsr_data *d, int number, double c)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *closure = closure_of(w, number);
    mbsri_pool *pool = mbsri_carried_at(w, v->loop[number].pool);
    double *T = v->store + mbsri_pool_T(pool);
    for (int k = 0; k < closure->held; ++k) {
        if (!mbsri_is_stiff(closure, k)) continue;
        const int lambda = mbsri_carried_join(w, pool, mbsri_name_lambda(closure, k));
        const double compliance = 1.0 / (closure->def.stiffness[k] + c * closure->def.damping[k]);
        T[lambda * pool->most + lambda] += c * compliance;
        if (d->dropped[closure->row + k]) continue;
        const int eta = mbsri_carried_join(w, pool, mbsri_name_eta(w->model, closure, k));
        T[lambda * pool->most + eta] += compliance;
    }
    for (int k = 0; k < v->loop[number].rank; ++k) {
        const int at = mbsri_carried_join(w, pool, v->loop[number].across + k);
        T[at * pool->most + at] += 1.0;
    }
}

void mbsri_carried_diagonal(mbsr_newton *w, const mbsr_data *d, int k, double c)
{
    const mbsri_carried *v = &w->carried;
    for (int l = v->front[k].first_loop; l >= 0; l = v->loop[l].next) add_diagonal(w, d, l, c);
}

void mbsri_carried_seat(mbsr_newton *w, int k)
{
    mbsri_carried *v = &w->carried;
    const mbsri_pool *pool = mbsri_carried_at(w, k);
    const int *row = v->numbers + mbsri_pool_row(pool),
              multipliers = w->model->rows + w->model->held;
    for (int l = 0; l < pool->count; ++l) {
        if (row[l] < multipliers && v->loop[v->closure[row[l]]].pool == k)
            v->multiplier[row[l]].right = (ptrdiff_t)pool->right + l;
    }
}

/* Row k of a closure: what r and delta count. Of a stiff one delta counts the force of the spring alone. */
static void open_multipliers(mbsr_newton *w, const mbsri_closure *closure, int k, double c)
{
    mbsri_multiplier *multiplier = w->carried.multiplier;
    const double stiffness = closure->def.stiffness[k], damping = closure->def.damping[k];
    const bool stiff = mbsri_is_stiff(closure, k);
    multiplier[mbsri_name_lambda(closure, k)] = (mbsri_multiplier){
        -1, stiff ? -1.0 : 1.0, stiff ? -stiffness / (stiffness + c * damping) : 1.0 / c};
    if (k < closure->held)
        multiplier[mbsri_name_eta(w->model, closure, k)] = (mbsri_multiplier){-1, 1.0, 1.0 / c};
}

/* The derivatives of closure k. */
static int open_loop(mbsr_newton *w, mbsr_data *d, int k, double factor)
{
    mbsri_carried *v = &w->carried;
    mbsri_loop *loop = v->loop + k;
    const mbsri_closure *c = closure_of(w, k);
    mbsri_closure_tangents out = {v->store + loop->S,
                                  v->store + loop->slope,
                                  v->store + loop->left,
                                  v->store + loop->read,
                                  loop->most,
                                  0};
    int status = MBSR_OK;
    for (int l = 0; l < c->rows; ++l) open_multipliers(w, c, l, factor);
    if (!mbsri_closure_is_constant(c))
        status = mbsri_closure_tangents_of(w->model, d, c, v->work, &out);
    loop->rank = out.rank;
    return status;
}

int mbsri_carried_open(mbsr_newton *w, mbsr_data *d, double c)
{
    mbsri_carried *v = &w->carried;
    for (int k = 0; k < v->uses; ++k) {
        const int i = v->used[k];
        v->pool[i].count = v->swept[i].count = 0;
        v->swept[i].closed = false;
    }
    for (int k = 0; k < closures_of(w); ++k) {
        mbsri_expect_closure(w->model, closure_of(w, k));
        const int status = open_loop(w, d, k, c);
        if (status) return status;
    }
    for (int k = 0; k < closures_of(w); ++k) {
        for (int l = 0; l < bodies_of(closure_of(w, k)); ++l) add_end(w, d, k, l);
    }
    for (int k = 0; k < closures_of(w); ++k) {
        if (!mbsri_carried_at(w, v->loop[k].pool)->swept) add_diagonal(w, d, k, c);
    }
    return MBSR_OK;
}

int mbsri_carried_pool(const mbsr_newton *w, int i, int number, int *at)
{
    const mbsri_carried *v = &w->carried;
    *at = 0;
    if (i > w->model->bodies || !w->node[i].coupled) return number == 0 ? i : -1;
    const mbsri_group g = mbsri_group_in_model(w->model, i);
    for (int k = 0; k < g.members; ++k) {
        *at = k;
        if (number-- == 0) return g.member[k];
        for (int l = v->first_closing[g.member[k]]; l > 0; l = v->front[l].next) {
            if (number-- == 0) return l;
        }
    }
    return -1;
}
