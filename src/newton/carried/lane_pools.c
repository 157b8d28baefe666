/* Pools of bodies in vector code: see lane_pools.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/lane_pools.h"

#include "base/memory.h"
#include "recursion/closures.h"

/* Of matrices of strands; `most` unknowns each. */
typedef struct slot {
    int most;
    size_t at;
} slot;

typedef struct strand {
    int most;
    int slot; /* -1: none yet */
    size_t names, right;
} strand;

typedef struct plan {
    mbsr_newton *w;
    mbsri_carried *v;
    strand *strand;
    slot *slot;
    int *of;   /* pools: their strand, -1: none */
    int *free; /* slots that no strand has now */
    int strands, slots, unused;
    size_t *doubles, *ints;
} plan;

static size_t take(size_t *used, size_t count)
{
    const size_t at = *used;
    *used += count;
    return at;
}

/* The same of whole lines of the cache. */
static size_t take_lines(size_t *doubles, size_t count)
{
    const size_t line = MBSR_DATA_ALIGNMENT / sizeof(double);
    *doubles = (*doubles + line - 1) / line * line;
    return take(doubles, count);
}

static bool has_lanes(const plan *p, int k)
{
    return p->v->lane_pool[k].in_lanes && p->v->pool[k].most > 0;
}

/* Calls `visit` for all fronts in the order of the sweep. */
static void run(plan *p, void (*visit)(plan *p, int k))
{
    const mbsri_carried *v = p->v;
    for (int i = p->w->model->bodies; i >= 0; --i) {
        for (int k = v->first_closing[i]; k > 0; k = v->front[k].next) visit(p, k);
        if (i > 0) visit(p, i);
    }
}

static void begin_pool(plan *p, int k)
{
    if (p->of[k] >= 0) return;
    p->of[k] = p->strands;
    p->strand[p->strands++] = (strand){.slot = -1};
}

/* Which pools are a strand, and what it counts. */
static void tie(plan *p, int k)
{
    mbsri_carried *v = p->v;
    mbsri_pool *pool = v->lane_pool + k;
    const int up = pool->up;
    if (!has_lanes(p, k)) return;
    begin_pool(p, k);
    strand *s = p->strand + p->of[k];
    const int most = mbsri_lane_span(v->pool[k].most + 1);
    if (most > s->most) s->most = most;
    pool->in_place = k <= p->w->model->bodies && has_lanes(p, up) && p->of[up] < 0;
    if (pool->in_place)
        p->of[up] = p->of[k];
    else if (has_lanes(p, up))
        begin_pool(p, up);
}

static size_t size_of(int most)
{
    const size_t one = MBSRI_LANE_MOTIONS + MBSRI_LANE_ACTIONS + MBSRI_LANE_FORCES;
    return (size_t)most * (one + (size_t)most);
}

/* A slot for strand s, lists and right-hand sides. */
static void open_strand(plan *p, strand *s)
{
    const size_t most = (size_t)s->most;
    if (s->slot >= 0) return;
    for (int k = p->unused - 1; k >= 0 && s->slot < 0; --k) {
        const int at = p->free[k];
        if (p->slot[at].most < s->most) continue;
        s->slot = at;
        p->free[k] = p->free[--p->unused];
    }
    if (s->slot < 0) {
        s->slot = p->slots++;
        p->slot[s->slot] = (slot){s->most, take_lines(p->doubles, size_of(s->most))};
    }
    s->names = take(p->ints, 2 * most);
    s->right = take(&p->v->right_count, most);
}

static void place_pool(const plan *p, int k)
{
    const strand *s = p->strand + p->of[k];
    mbsri_pool *pool = p->v->lane_pool + k;
    pool->most = s->most;
    pool->Q = p->slot[s->slot].at;
    pool->column = s->names;
    pool->right = s->right; /* from the first of all */
}

/* What the solution needs of front k; see newton/sweeps/fronts.h and closing.h. */
static void place_record(const plan *p, int k)
{
    mbsri_pool *pool = p->v->lane_pool + k;
    const int most = p->v->pool[k].most;
    if (k <= p->w->model->bodies) {
        const int n = p->w->model->body[k].n, span = mbsri_lane_span(most + n);
        pool->record = take_lines(p->doubles, (size_t)(MBSRI_LANE_RECORD * span * (n > 1 ? n : 1)));
        const size_t scratch = 5 * (size_t)(n * p->strand[p->of[k]].most);
        if (p->v->widest < scratch) p->v->widest = scratch; /* balances and couplings */
        if (!pool->in_place) pool->place = take(p->ints, (size_t)(most + n));
        return;
    }
    pool->record = take_lines(p->doubles, mbsri_closing_size(most));
    pool->place = take(p->ints, (size_t)pool->most + 2 * (size_t)most);
}

static void place_front(plan *p, int k)
{
    const int up = p->v->pool[k].up;
    if (!has_lanes(p, k)) return;
    strand *s = p->strand + p->of[k];
    open_strand(p, s);
    place_pool(p, k);
    place_record(p, k);
    if (p->v->lane_pool[k].in_place) return;
    if (has_lanes(p, up)) open_strand(p, p->strand + p->of[up]);
    p->free[p->unused++] = s->slot;
}

/* Loops that close at a front, of those that have something on its diagonal. */
static void list_loops(const mbsr_newton *w, mbsri_carried *v)
{
    const mbsri_closure *c = w->model->closures.data;
    for (int k = 0; k < (int)w->model->closures.count; ++k) {
        mbsri_loop *loop = v->loop + k;
        bool any = loop->most > 0, rigid = false;
        for (int l = 0; l < c[k].position_rows; ++l) {
            any = any || mbsri_is_stiff(c + k, l);
            rigid = rigid || !mbsri_is_stiff(c + k, l);
        }
        if (rigid && !mbsri_is_coupling(c + k)) v->front[loop->pool].judged = true;
        loop->next = -1;
        if (!any) continue;
        loop->next = v->front[loop->pool].first_loop;
        v->front[loop->pool].first_loop = k;
    }
}

bool mbsri_place_lane_pools(mbsr_newton *w, size_t *doubles, size_t *ints)
{
    mbsri_carried *v = &w->carried;
    const mbsr_allocator *allocator = &w->model->allocator;
    const size_t fronts = (size_t)v->fronts;
    plan p = {.w = w, .v = v, .doubles = doubles, .ints = ints};
    for (int k = 0; k < v->fronts; ++k) {
        v->front[k].first_loop = -1;
        v->front[k].judged = false;
    }
    list_loops(w, v);
    p.strand =
        mbsri_allocate(allocator, fronts * (sizeof *p.strand + sizeof *p.slot + 2 * sizeof(int)));
    if (!p.strand) return false;
    p.slot = (slot *)(void *)(p.strand + fronts);
    p.of = (int *)(void *)(p.slot + fronts);
    p.free = p.of + fronts;
    for (int k = 0; k < v->fronts; ++k) p.of[k] = -1;
    v->right_count = 0;
    run(&p, tie);
    run(&p, place_front);
    mbsri_release(allocator, p.strand);
    v->right = take(doubles, v->right_count);
    for (int k = 0; k < v->fronts; ++k) v->lane_pool[k].right += v->right;
    return true;
}
