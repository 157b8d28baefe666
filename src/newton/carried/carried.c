/* Closures in the elimination on the tree: see carried.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/carried.h"

#include "algebra/dense.h"
#include "base/memory.h"
#include "newton/carried/closing_order.h"
#include "newton/carried/lane_pools.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/slopes/closure_turn.h"
#include "recursion/closures.h"

#include <math.h>

static int closures_of(const mbsr_newton *w)
{
    return (int)w->model->closures.count;
}

/* Those that the definition names; a root that moves may stand behind them. */
static int bodies_of(const mbsri_closure *c)
{
    return c->def.bodies;
}

/* ---- names ---- */

static void list_ends(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    int used = 0;
    for (int i = 0; i <= w->model->bodies; ++i) v->first_end[i] = -1;
    for (int k = closures_of(w) - 1; k >= 0; --k) {
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
        for (int l = bodies_of(c) - 1; l >= 0; --l) {
            const int body = c->body[l];
            if (body == 0) continue;
            v->end[used] = (mbsri_loop_end){
                .closure = k, .slot = l, .next = v->first_end[body], .d = w->model->body[body].d};
            v->first_end[body] = used++;
        }
    }
}

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
    v->multipliers = m->rows + m->position_rows;
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
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
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
        for (int l = 0; l < c->rows; ++l) v->closure[mbsri_name_lambda(c, l)] = k;
        for (int l = 0; l < c->position_rows; ++l) v->closure[mbsri_name_eta(m, c, l)] = k;
        for (int l = 0; l < v->loop[k].most; ++l) v->closure[v->loop[k].across + l] = k;
    }
}

/* ---- how much is carried ---- */

/* Adds closure k to what front i and those above carry, at most and of multipliers; seen: the last
 * closure that did. lambda: rows lambda that a front hands on. */
static void count_path(mbsr_newton *w, int k, int i, int *seen, int *lambda)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
    const int multipliers = c->rows + c->position_rows, last = v->loop[k].pool;
    while (seen[i] != k + 1) {
        seen[i] = k + 1;
        v->pool[i].most += multipliers + v->loop[k].most;
        v->pool[i].count += multipliers;
        if (i == last) return;
        v->front[i].passes = true;
        lambda[i] += c->rows;
        i = v->pool[i].up;
    }
}

/* What front i may delay, joints of `n` rates; adds it to the pool above. */
static void count_delayed(mbsri_carried *v, int i, int n, const int *lambda)
{
    mbsri_carried_front *front = v->front + i;
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
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
        for (int l = 0; l < bodies_of(c); ++l) {
            const int body = c->body[l];
            const bool closed = body == v->pool[v->loop[k].pool].body;
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
}

/* ---- memory ---- */

static size_t take(size_t *used, size_t count)
{
    const size_t at = *used;
    *used += count;
    return at;
}

static void shape_pools(mbsr_newton *w)
{
    for (int k = 0; k < w->carried.fronts; ++k) {
        const mbsri_pool *pool = w->carried.pool + k;
        w->carried.lane_pool[k] = (mbsri_pool){.body = pool->body,
                                               .up = pool->up,
                                               .loose = pool->loose,
                                               .in_lanes = k > 0,
                                               .stride = MBSRI_LANE_ACTIONS,
                                               .motions = MBSRI_LANE_MOTIONS};
    }
}

static void widen(mbsri_carried *v, size_t work)
{
    if (work > v->widest) v->widest = work;
}

/* A closing front. */
static void place_front(mbsri_carried *v, int k, size_t *ints)
{
    mbsri_carried_front *front = v->front + k;
    const size_t size = (size_t)v->pool[k].most, span = (size_t)mbsri_lane_span((int)size);
    front->place = take(ints, size);
    widen(v, size * MBSRI_LANE_MOTIONS + span * (size + 2)); /* W, or exponents */
    if ((int)size > v->most) v->most = (int)size;
}

static void place_slopes(mbsr_newton *w, size_t *doubles)
{
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
        mbsri_loop *loop = w->carried.loop + k;
        const size_t columns = (size_t)c->columns, most = (size_t)loop->most;
        loop->S = take(doubles, columns * columns);
        loop->slope = take(doubles, (size_t)c->rows * columns);
        loop->left = take(doubles, columns * most);
        loop->read = take(doubles, columns * most);
        loop->turn = take(doubles, most > 0 ? mbsri_closure_turn_size(c) : 0);
        widen(&w->carried, mbsri_closure_tangents_work(c));
    }
}

/* Of closures whose derivatives do not move they stay zero. */
static void clear_slopes(mbsr_newton *w)
{
    for (int k = 0; k < closures_of(w); ++k) {
        const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
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
    for (int k = m->bodies + 1; k < v->fronts; ++k) place_front(v, k, &ints);
    if (!mbsri_place_lane_pools(w, &doubles, &ints)) return false;
    place_slopes(w, &doubles);
    const size_t value = take(&doubles, (size_t)v->names), work = take(&doubles, v->widest),
                 list = take(&ints, 4 * (size_t)v->most);
    v->bytes += doubles * sizeof(double) + ints * sizeof(int);
    v->store = mbsri_allocate(&m->allocator, doubles * sizeof(double) + ints * sizeof(int) + 8);
    if (!v->store) return false;
    v->numbers = (int *)(void *)(v->store + doubles);
    v->value = v->store + value;
    v->work = v->store + work;
    v->list = v->numbers + list;
    clear_slopes(w);
    return true;
}

static size_t place_records(mbsr_newton *w, void *memory, int **scratch)
{
    mbsri_carried *v = &w->carried;
    size_t used = 0, ends = 0;
    const size_t bodies = (size_t)w->model->bodies + 1, closures = (size_t)closures_of(w),
                 fronts = bodies + closures;
    for (int k = 0; k < closures_of(w); ++k)
        ends += (size_t)bodies_of(mbsri_closure_at(w->model, (size_t)k));
    v->loop = mbsri_take_bytes(memory, &used, closures * sizeof *v->loop);
    v->end = mbsri_take_bytes(memory, &used, ends * sizeof *v->end);
    v->first_end = mbsri_take_bytes(memory, &used, bodies * sizeof(int));
    v->first_closing = mbsri_take_bytes(memory, &used, bodies * sizeof(int));
    v->last_closing = mbsri_take_bytes(memory, &used, bodies * sizeof(int));
    v->served = mbsri_take_bytes(memory, &used, bodies * sizeof(bool));
    v->used = mbsri_take_bytes(memory, &used, fronts * sizeof(int));
    const size_t rows = (size_t)(w->model->rows + w->model->position_rows);
    v->multiplier = mbsri_take_bytes(memory, &used, rows * sizeof *v->multiplier);
    v->pool = mbsri_take_bytes(memory, &used, fronts * sizeof *v->pool);
    v->lane_pool = mbsri_take_bytes(memory, &used, fronts * sizeof *v->lane_pool);
    v->front = mbsri_take_bytes(memory, &used, fronts * sizeof *v->front);
    *scratch = mbsri_take_bytes(memory, &used, 2 * fronts * sizeof(int));
    return used;
}

bool mbsri_carried_plan(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    int *scratch;
    const size_t bytes = place_records(w, NULL, &scratch);
    v->memory = mbsri_allocate(&w->model->allocator, bytes);
    if (!v->memory) return false;
    v->bytes = bytes;
    (void)place_records(w, v->memory, &scratch);
    name_all(w);
    if (!mbsri_closing_order(w)) return false;
    count_carried(w, scratch, scratch + v->fronts);
    return true;
}

/* By multipliers alone: of the rest there is seldom any. */
double mbsri_carried_operations(const mbsr_newton *w)
{
    const mbsri_carried *v = &w->carried;
    double sum = 0.0;
    for (int k = 1; k < v->fronts; ++k) {
        const double size = v->pool[k].count;
        sum += k > w->model->bodies ? size * size * (size + 20.0) : size * (size + 40.0);
    }
    return sum;
}

static double least_mobility(const mbsr_model *m)
{
    const double length = m->typical.length > 0.0 ? m->typical.length : 1.0;
    double least = INFINITY;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsr_coordinate_kind kind[MBSR_MAX_D];
        mbsr_body_coordinate_kinds(m, b->id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            const bool turns = kind[k] == MBSR_COORDINATE_ROTATION;
            const double weight = m->typical.weight[b->iu + k];
            least = fmin(least, turns ? length * length * weight : weight);
        }
    }
    return least < INFINITY ? least : 0.0;
}

bool mbsri_carried_create(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    const size_t bytes = (size_t)(v->multipliers + 1) * sizeof(int);
    list_ends(w);
    v->closure = mbsri_allocate(&w->model->allocator, bytes);
    if (!v->closure) return false;
    v->bytes += bytes;
    list_names(w);
    v->mobility = least_mobility(w->model);
    return place_all(w);
}

void mbsri_carried_destroy(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    const mbsr_allocator *allocator = &w->model->allocator;
    if (v->store) mbsri_release(allocator, v->store);
    if (v->closure) mbsri_release(allocator, v->closure);
    if (v->memory) mbsri_release(allocator, v->memory);
    *v = (mbsri_carried){0};
}
