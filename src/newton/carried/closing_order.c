/* Which fronts close the loops that meet on a body: see closing_order.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Branches are the successors of a body behind which its loops have ends, tied where a loop has
 * ends behind both. All loops of branches that hang together may close in one front, with the cube
 * of their number. A train of wheels, or the rungs of a ladder, tie each branch to the next alone:
 * so branches are put into an order, breadth first from one that is far from another (Cuthill and
 * McKee), and loops close when the last of their branches has been reached. What such a group of
 * loops leaves goes to the front of the next loops that it knows. A group that knows no others than
 * that front does is closed there, too. */
#include "newton/carried/closing_order.h"

#include "base/memory.h"
#include "sweeps/tree.h"

enum { FEW = 4 }; /* loops that close in one front in any case */

/* Loops of a body, and their branches; lists by -1. */
typedef struct plan {
    mbsr_newton *w;
    const mbsri_closure *closure;
    int *first_loop, *next_loop;          /* bodies, closures: that meet there */
    int *first_branch;                    /* closures + 1: of `branch`, each once */
    int *branch;                          /* ends */
    int *first_at, *next_at, *closure_at; /* bodies, ends, ends: the loops of a branch */
    int *group_of, *mark;                 /* closures: position of their last branch; scratch */
    struct {
        int *order, *position, *visited, ordered; /* its branches */
        int *loop, loops;                         /* closures: its loops, group by group */
    } component;
    int *first_of, *into, *rest_at,
        *rests;                    /* groups: first of `loop`; merged into; rest; how many */
    int *first_child, *next_child; /* groups: which hand on to it */
    int *first_given, *next_given; /* groups, bodies: branches that do */
    int *rest, used, most;
    int *front_of; /* groups */
    int stamp;
    double *size; /* groups: unknowns of their fronts */
    void *memory;
} plan;

static int find(int *set, int i)
{
    while (set[i] != i) i = set[i] = set[set[i]];
    return i;
}

/* The successor of `body` behind which body i stands, or is. */
static int successor(const mbsr_model *m, int body, int i)
{
    while (m->body[i].parent != body) i = m->body[i].parent;
    return i;
}

/* ---- branches ---- */

static int *take_list(int **at, size_t count)
{
    int *place = *at;
    *at += count;
    return place;
}

static bool open_plan(plan *p, size_t bodies, size_t closures, size_t ends)
{
    const size_t groups = bodies + 1, most = 16 * closures + 64;
    const size_t ints = 6 * bodies + 6 * closures + 3 * ends + 9 * groups + most;
    p->memory =
        mbsri_allocate(&p->w->model->allocator, groups * sizeof(double) + (ints + 2) * sizeof(int));
    if (!p->memory) return false;
    p->size = p->memory;
    int *at = (int *)(void *)(p->size + groups);
    p->first_loop = take_list(&at, bodies), p->next_loop = take_list(&at, closures);
    p->first_branch = take_list(&at, closures + 1), p->branch = take_list(&at, ends);
    p->first_at = take_list(&at, bodies), p->next_at = take_list(&at, ends);
    p->closure_at = take_list(&at, ends);
    p->component.order = take_list(&at, bodies), p->component.position = take_list(&at, bodies),
    p->component.visited = take_list(&at, bodies);
    p->group_of = take_list(&at, closures), p->mark = take_list(&at, closures);
    p->component.loop = take_list(&at, closures);
    p->first_of = take_list(&at, groups + 1), p->into = take_list(&at, groups);
    p->rest_at = take_list(&at, groups), p->rests = take_list(&at, groups);
    p->first_child = take_list(&at, groups), p->next_child = take_list(&at, groups);
    p->first_given = take_list(&at, groups), p->next_given = take_list(&at, bodies);
    p->front_of = take_list(&at, groups);
    p->rest = take_list(&at, most);
    p->most = (int)most;
    return true;
}

static void list_branches(plan *p)
{
    const mbsr_model *m = p->w->model;
    const int bodies = m->bodies, closures = (int)m->closures.count;
    int used = 0;
    for (int i = 0; i <= bodies; ++i)
        p->first_loop[i] = p->first_at[i] = p->component.visited[i] = -1;
    for (int k = closures - 1; k >= 0; --k) {
        p->next_loop[k] = p->first_loop[p->closure[k].meets];
        p->first_loop[p->closure[k].meets] = k;
        p->mark[k] = -1;
    }
    for (int k = 0; k < closures; ++k) {
        const mbsri_closure *c = p->closure + k;
        p->first_branch[k] = used;
        for (int l = 0; l < c->def.bodies; ++l) {
            if (c->body[l] == c->meets) continue;
            const int i = successor(m, c->meets, c->body[l]);
            bool known = false;
            for (int n = p->first_branch[k]; n < used; ++n) known = known || p->branch[n] == i;
            if (known) continue;
            p->branch[used] = i;
            p->closure_at[used] = k;
            p->next_at[used] = p->first_at[i];
            p->first_at[i] = used++;
        }
    }
    p->first_branch[closures] = used;
}

/* All branches that hang together with this one, breadth first; the last one is far from it. */
static void spread(plan *p, int from)
{
    const int stamp = ++p->stamp;
    p->component.ordered = 0;
    p->component.order[p->component.ordered++] = from;
    p->component.visited[from] = stamp;
    for (int l = 0; l < p->component.ordered; ++l) {
        p->component.position[p->component.order[l]] = l;
        for (int e = p->first_at[p->component.order[l]]; e >= 0; e = p->next_at[e]) {
            const int k = p->closure_at[e];
            for (int n = p->first_branch[k]; n < p->first_branch[k + 1]; ++n) {
                const int i = p->branch[n];
                if (p->component.visited[i] == stamp) continue;
                p->component.visited[i] = stamp;
                p->component.order[p->component.ordered++] = i;
            }
        }
    }
}

/* ---- groups ---- */

/* The loops of each branch that is the last of theirs. */
static void group_loops(plan *p)
{
    p->component.loops = 0;
    for (int g = 0; g < p->component.ordered; ++g) {
        p->first_of[g] = p->component.loops;
        for (int e = p->first_at[p->component.order[g]]; e >= 0; e = p->next_at[e]) {
            const int k = p->closure_at[e];
            int last = 0;
            for (int n = p->first_branch[k]; n < p->first_branch[k + 1]; ++n) {
                const int at = p->component.position[p->branch[n]];
                last = at > last ? at : last;
            }
            p->group_of[k] = last;
            if (last == g) p->component.loop[p->component.loops++] = k;
        }
        p->first_child[g] = p->first_given[g] = -1;
        p->into[g] = g;
    }
    p->first_of[p->component.ordered] = p->component.loops;
}

/* Loop k to what group g leaves, if it closes later; false: all of these are too many. */
static bool leave(plan *p, int g, int k)
{
    if (p->group_of[k] == g || p->mark[k] == g) return true;
    if (p->used == p->most) return false;
    p->mark[k] = g;
    p->rest[p->used++] = k;
    return true;
}

/* What each group leaves, and to which it hands that on; false: too many. */
static bool find_rests(plan *p)
{
    p->used = 0;
    for (int l = 0; l < p->component.loops; ++l) p->mark[p->component.loop[l]] = -1;
    for (int l = 0; l < p->component.ordered; ++l) {
        int first = p->component.ordered;
        const int i = p->component.order[l];
        for (int e = p->first_at[i]; e >= 0; e = p->next_at[e]) {
            const int g = p->group_of[p->closure_at[e]];
            first = g < first ? g : first;
        }
        p->next_given[i] = p->first_given[first];
        p->first_given[first] = i;
    }
    for (int g = 0; g < p->component.ordered; ++g) {
        bool fits = true;
        p->rest_at[g] = p->used;
        for (int i = p->first_given[g]; i >= 0; i = p->next_given[i]) {
            for (int e = p->first_at[i]; e >= 0; e = p->next_at[e])
                fits = fits && leave(p, g, p->closure_at[e]);
        }
        for (int h = p->first_child[g]; h >= 0; h = p->next_child[h]) {
            for (int l = 0; l < p->rests[h]; ++l)
                fits = fits && leave(p, g, p->rest[p->rest_at[h] + l]);
        }
        if (!fits) return false;
        int up = p->component.ordered;
        p->rests[g] = p->used - p->rest_at[g];
        for (int l = 0; l < p->rests[g]; ++l) {
            const int h = p->group_of[p->rest[p->rest_at[g] + l]];
            up = h < up ? h : up;
        }
        if (up == p->component.ordered) continue;
        p->next_child[g] = p->first_child[up];
        p->first_child[up] = g;
    }
    return true;
}

/* Groups that know no other loops than the next front does go there. */
static void merge(plan *p)
{
    for (int h = 0; h < p->component.ordered; ++h) {
        const int known = p->first_of[h + 1] - p->first_of[h] + p->rests[h];
        for (int g = p->first_child[h]; g >= 0; g = p->next_child[g]) {
            if (p->rests[g] == known) p->into[g] = h;
        }
    }
}

static double unknowns(const plan *p, int k)
{
    return p->closure[k].rows + p->closure[k].position_rows + p->w->carried.loop[k].most;
}

static double cube(double x)
{
    return x * x * x;
}

/* Whether several fronts cost less than half of one. */
static bool divides(plan *p)
{
    double all = 0.0, sum = 0.0, *size = p->size;
    for (int g = 0; g < p->component.ordered; ++g) size[g] = 0.0;
    for (int g = 0; g < p->component.ordered; ++g) {
        const int h = find(p->into, g);
        for (int l = p->first_of[g]; l < p->first_of[g + 1]; ++l) {
            size[h] += unknowns(p, p->component.loop[l]);
            all += unknowns(p, p->component.loop[l]);
        }
        if (h != g) continue;
        for (int l = 0; l < p->rests[g]; ++l) size[g] += unknowns(p, p->rest[p->rest_at[g] + l]);
    }
    for (int g = 0; g < p->component.ordered; ++g) sum += cube(size[g]);
    return sum < 0.5 * cube(all);
}

/* ---- fronts ---- */

static int add_front(plan *p, int body)
{
    mbsri_carried *v = &p->w->carried;
    const int k = v->fronts++, last = v->last_closing[body];
    v->front[k] = (mbsri_carried_front){.previous = last};
    v->pool[k] = (mbsri_pool){.body = body, .up = body};
    if (last > 0)
        v->front[last].next = k;
    else
        v->first_closing[body] = k;
    v->last_closing[body] = k;
    return k;
}

/* Those of the loops that meet on `body` behind the branches in order. */
static void add_fronts(plan *p, int body, bool several)
{
    mbsri_carried *v = &p->w->carried;
    if (!several) {
        const int k = add_front(p, body);
        for (int l = 0; l < p->component.loops; ++l) v->loop[p->component.loop[l]].pool = k;
        for (int l = 0; l < p->component.ordered; ++l) v->pool[p->component.order[l]].up = k;
        return;
    }
    for (int g = 0; g < p->component.ordered; ++g) {
        const bool own = find(p->into, g) == g && p->first_of[g] < p->first_of[g + 1];
        p->front_of[g] = own ? add_front(p, body) : 0;
    }
    for (int g = 0; g < p->component.ordered; ++g) {
        const int k = p->front_of[find(p->into, g)];
        for (int l = p->first_of[g]; l < p->first_of[g + 1]; ++l)
            v->loop[p->component.loop[l]].pool = k;
        for (int i = p->first_given[g]; i >= 0; i = p->next_given[i]) v->pool[i].up = k;
        for (int h = p->first_child[g]; h >= 0; h = p->next_child[h]) {
            if (find(p->into, h) == h) v->pool[p->front_of[h]].up = k;
        }
    }
}

/* Whether all bodies are in vector code. */
static bool none_by_blocks(const mbsr_model *m)
{
    return m->tree.newton && m->tree.newton->blocks == 0;
}

static void close_on(plan *p, int body)
{
    mbsri_carried *v = &p->w->carried;
    for (int k = p->first_loop[body]; k >= 0; k = p->next_loop[k]) v->loop[k].pool = body;
    for (int k = p->first_loop[body]; k >= 0; k = p->next_loop[k]) {
        if (p->first_branch[k] == p->first_branch[k + 1] || v->loop[k].pool != body) continue;
        spread(p, p->branch[p->first_branch[k]]);
        spread(p, p->component.order[p->component.ordered - 1]);
        group_loops(p);
        bool several = p->component.loops > FEW && none_by_blocks(p->w->model) && find_rests(p);
        if (several) {
            merge(p);
            several = divides(p);
        }
        add_fronts(p, body, several);
    }
}

/* Levels: what closes later has the lower one. */
static void find_levels(mbsr_newton *w)
{
    mbsri_carried *v = &w->carried;
    int level = 0;
    for (int i = 0; i <= w->model->bodies; ++i) {
        v->front[i].level = level++;
        for (int k = v->last_closing[i]; k > 0; k = v->front[k].previous)
            v->front[k].level = level++;
    }
    for (int k = 0; k < (int)w->model->closures.count; ++k)
        v->loop[k].level = v->front[v->loop[k].pool].level;
}

bool mbsri_closing_order(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    plan p = {.w = w, .closure = m->closures.data};
    size_t ends = 0;
    for (int k = 0; k < (int)m->closures.count; ++k) ends += (size_t)p.closure[k].def.bodies;
    if (!open_plan(&p, (size_t)m->bodies + 1, m->closures.count, ends)) return false;
    v->fronts = m->bodies + 1;
    for (int i = 0; i <= m->bodies; ++i) {
        v->front[i] = (mbsri_carried_front){0};
        v->pool[i] = (mbsri_pool){.body = i, .up = i > 0 ? m->body[i].parent : 0};
        v->first_closing[i] = v->last_closing[i] = 0;
    }
    list_branches(&p);
    for (int i = 0; i <= m->bodies; ++i) close_on(&p, i);
    find_levels(w);
    mbsri_release(&m->allocator, p.memory);
    return true;
}
