/* Greedy orders of elimination: see order.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As minimum degree for sparse matrices. An element is what a step has left: a list of vertices.
 * Eliminating a vertex joins the elements that have it in one. */
#include "fronts/order.h"

#include "base/heap.h"
#include "recursion/closures.h"

enum { EAGER = 64 }; /* vertices of a border whose scores are renewed at once */

typedef struct link {
    int element, next; /* the next one of the same vertex; -1: none */
} link;

struct mbsri_order {
    const mbsr_model *m;
    const mbsri_closure *closure;
    int vertices; /* bodies + 1, then closures */
    mbsri_order_rule rule;
    mbsri_plan *plan;
    mbsri_array members, links, heap; /* int, link, key: of vertices that may be next */
    int *first, *count, *spare; /* of elements, which are steps: their vertices; rates passed less
                                 * rows eliminated; count -1: joined to another */
    int *first_link, *version, *mark, tick; /* vertices */
    bool *gone, *queued;                    /* vertices: eliminated; among the candidates */
    int *behind;                            /* bodies: successors that have not been passed */
    int *first_end, *next_end;              /* ends of closures at a body; -1: none */
    int *first_top, *next_top;  /* at the last body of a path before it meets the others */
    int *ends_left, *tops_left; /* closures: of ends outside the body where they meet */
    void *memory;
};

/* ---- memory ---- */

static int closures_of(const mbsr_model *m)
{
    return (int)m->closures.count;
}

/* The last body on the way from the end to where the closure meets. */
static int top_of(const mbsr_model *m, const mbsri_closure *c, int body)
{
    while (m->body[body].parent != c->meets) body = m->body[body].parent;
    return body;
}

static void list_ends(mbsri_order *g)
{
    const mbsr_model *m = g->m;
    for (int i = 0; i <= m->bodies; ++i) g->first_end[i] = g->first_top[i] = -1;
    for (int k = 0; k < closures_of(m); ++k) {
        const mbsri_closure *c = g->closure + k;
        for (int l = 0; l < c->bodies; ++l) {
            const int end = k * MBSRI_ENDS + l, i = c->body[l];
            if (!mbsri_plan_reads(c, l)) continue;
            g->next_end[end] = g->first_end[i];
            g->first_end[i] = end;
            if (i == c->meets) continue;
            const int top = top_of(m, c, i);
            g->next_top[end] = g->first_top[top];
            g->first_top[top] = end;
        }
    }
}

mbsri_order *mbsri_order_open(const mbsr_model *m)
{
    const size_t bodies = (size_t)m->bodies + 1, closures = m->closures.count,
                 vertices = bodies + closures, ends = closures * MBSRI_ENDS;
    const size_t ints = 6 * vertices + 3 * bodies + 2 * ends + 2 * closures;
    mbsri_order *g =
        mbsri_allocate(&m->allocator, sizeof *g + ints * sizeof(int) + 2 * vertices * sizeof(bool));
    if (!g) return NULL;
    *g = (mbsri_order){.m = m,
                       .closure = mbsri_all_closures(m),
                       .vertices = (int)vertices,
                       .first = (int *)(void *)(g + 1)};
    g->count = g->first + vertices;
    g->spare = g->count + vertices;
    g->first_link = g->spare + vertices;
    g->version = g->first_link + vertices;
    g->mark = g->version + vertices;
    g->behind = g->mark + vertices;
    g->first_end = g->behind + bodies;
    g->first_top = g->first_end + bodies;
    g->next_end = g->first_top + bodies;
    g->next_top = g->next_end + ends;
    g->ends_left = g->next_top + ends;
    g->tops_left = g->ends_left + closures;
    g->gone = (bool *)(g->tops_left + closures);
    g->queued = g->gone + vertices;
    list_ends(g);
    return g;
}

void mbsri_order_close(mbsri_order *g)
{
    void *const arrays[] = {g->members.data, g->links.data, g->heap.data};
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; ++k)
        mbsri_release(&g->m->allocator, arrays[k]);
    mbsri_release(&g->m->allocator, g);
}

static void begin_order(mbsri_order *g)
{
    const mbsr_model *m = g->m;
    g->members.count = g->links.count = g->heap.count = 0;
    g->tick = 0;
    for (int v = 0; v < g->vertices; ++v) {
        g->first_link[v] = -1;
        g->version[v] = g->mark[v] = 0;
        g->gone[v] = g->queued[v] = false;
    }
    for (int i = 0; i <= m->bodies; ++i) g->behind[i] = 0;
    for (int i = 1; i <= m->bodies; ++i) ++g->behind[m->body[i].parent];
    for (int k = 0; k < closures_of(m); ++k) {
        const mbsri_closure *c = g->closure + k;
        int outside = 0;
        for (int l = 0; l < c->bodies; ++l)
            outside += mbsri_plan_reads(c, l) && c->body[l] != c->meets;
        g->ends_left[k] = g->tops_left[k] = outside;
    }
}

/* ---- borders ---- */

static int width_of(const mbsri_order *g, int vertex)
{
    const int bodies = g->m->bodies;
    return vertex <= bodies ? g->m->body[vertex].d : g->closure[vertex - bodies - 1].rows;
}

static bool add_member(mbsri_order *g, int vertex)
{
    if (vertex == 0 || g->gone[vertex] || g->mark[vertex] == g->tick) return true;
    g->mark[vertex] = g->tick;
    if (!mbsri_reserve(&g->m->allocator, &g->members, 1, sizeof(int))) return false;
    ((int *)g->members.data)[g->members.count++] = vertex;
    return true;
}

/* Takes elements that have been joined to others out of the list of a vertex. */
static void clean_links(mbsri_order *g, int vertex)
{
    link *links = g->links.data;
    int *at = g->first_link + vertex;
    while (*at >= 0) {
        if (g->count[links[*at].element] < 0)
            *at = links[*at].next;
        else
            at = &links[*at].next;
    }
}

/* What eliminating the vertex would leave, behind the members in use; *width: numbers in it. */
static bool find_border(mbsri_order *g, int vertex, int *width)
{
    const mbsr_model *m = g->m;
    const size_t first = g->members.count;
    bool room = true;
    ++g->tick;
    g->mark[vertex] = g->tick;
    clean_links(g, vertex);
    for (int k = g->first_link[vertex]; k >= 0 && room; k = ((link *)g->links.data)[k].next) {
        const int e = ((link *)g->links.data)[k].element;
        for (int l = 0; l < g->count[e] && room; ++l)
            room = add_member(g, ((int *)g->members.data)[g->first[e] + l]);
    }
    if (vertex <= m->bodies) {
        for (int end = g->first_end[vertex]; end >= 0 && room; end = g->next_end[end])
            room = add_member(g, m->bodies + 1 + end / MBSRI_ENDS);
        room = room && add_member(g, m->body[vertex].parent);
    } else {
        const mbsri_closure *c = g->closure + vertex - m->bodies - 1;
        for (int l = 0; l < c->bodies && room; ++l)
            room = !mbsri_plan_reads(c, l) || add_member(g, c->body[l]);
    }
    *width = 0;
    for (size_t k = first; k < g->members.count; ++k)
        *width += width_of(g, ((int *)g->members.data)[k]);
    return room;
}

/* ---- which vertices may be next ---- */

/* Rates passed on the paths of the closure, as far as these have been passed in one piece; no more
 * than `enough`. */
static int rates_passed(const mbsri_order *g, const mbsri_closure *c, int enough)
{
    int rates = 0;
    for (int l = 0; l < c->bodies; ++l) {
        for (int i = c->body[l]; mbsri_plan_reads(c, l) && i != c->meets && rates < enough;
             i = g->m->body[i].parent) {
            if (!g->gone[i]) break;
            rates += g->m->body[i].n;
        }
    }
    return rates;
}

/* Rates that are to be passed before the forces of closure k go: twice as many as it has rows where
 * an end has not entered, and some more; or just as many where one of its paths has been passed
 * whole, and no more come there, but the other end's motion may be in the border. */
static int rates_wanted(const mbsri_order *g, int k)
{
    const mbsri_closure *c = g->closure + k;
    int paths = 0;
    for (int l = 0; l < c->bodies; ++l) paths += mbsri_plan_reads(c, l) && c->body[l] != c->meets;
    const bool whole = g->tops_left[k] < paths;
    const bool doubly = g->ends_left[k] > 0 && !whole;
    const int more = whole && g->rule.moment == MBSRI_ORDER_FAR ? 0 : g->rule.more;
    return (doubly ? 2 : 1) * c->rows + more;
}

static bool may_go(mbsri_order *g, int vertex)
{
    const mbsr_model *m = g->m;
    if (vertex <= m->bodies) return g->behind[vertex] == 0;
    const int k = vertex - m->bodies - 1;
    const mbsri_closure *c = g->closure + k;
    if (g->tops_left[k] == 0) return true;
    if (g->rule.moment == MBSRI_ORDER_WHOLE) return false;
    if (g->ends_left[k] > 0 && (g->rule.moment != MBSRI_ORDER_FAR || mbsri_reads_joints(c)))
        return false;
    const int wanted = rates_wanted(g, k);
    if (rates_passed(g, c, wanted) < wanted) return false;
    int spare = 0;
    clean_links(g, vertex);
    for (int l = g->first_link[vertex]; l >= 0; l = ((link *)g->links.data)[l].next)
        spare += g->spare[((link *)g->links.data)[l].element];
    return spare >= wanted;
}

/* Numbers of the elements that have the vertex, squared. */
static double joined(const mbsri_order *g, int vertex)
{
    const int *members = g->members.data;
    double sum = 0.0;
    for (int k = g->first_link[vertex]; k >= 0; k = ((link *)g->links.data)[k].next) {
        const int e = ((link *)g->links.data)[k].element;
        double width = 0.0;
        for (int l = 0; l < g->count[e]; ++l) width += width_of(g, members[g->first[e] + l]);
        sum += width * width;
    }
    return sum;
}

static bool find_score(mbsri_order *g, int vertex, double *score)
{
    const size_t used = g->members.count;
    const bool body = vertex <= g->m->bodies;
    int width = 0;
    if (body && g->rule.choice == MBSRI_ORDER_TREE) {
        *score = 1e9 - vertex;
        return true;
    }
    const bool room = find_border(g, vertex, &width);
    g->members.count = used;
    *score = width + (body ? 0.5 : 0.0);
    if (g->rule.choice == MBSRI_ORDER_GROWTH) *score = (double)width * width - joined(g, vertex);
    return room;
}

/* The vertex becomes a candidate, or its score new. */
static bool offer(mbsri_order *g, int vertex)
{
    double score;
    ++g->version[vertex];
    g->queued[vertex] = false;
    if (vertex == 0 || g->gone[vertex] || !may_go(g, vertex)) return true;
    g->queued[vertex] = true;
    return find_score(g, vertex, &score) &&
           mbsri_heap_insert(&g->m->allocator, &g->heap,
                             (mbsri_key){score, vertex, g->version[vertex]});
}

/* ---- steps ---- */

/* The elements that have the vertex become children of step e. */
static void join_elements(mbsri_order *g, int vertex, int e, int *used)
{
    mbsri_plan *plan = g->plan;
    mbsri_plan_step *s = plan->step + e;
    s->first = *used;
    for (int k = g->first_link[vertex]; k >= 0; k = ((link *)g->links.data)[k].next) {
        const int child = ((link *)g->links.data)[k].element;
        plan->step[child].next = e;
        plan->child[(*used)++] = child;
        g->spare[e] += g->spare[child];
        g->count[child] = -1;
    }
    s->children = *used - s->first;
    for (int k = s->first + 1; k < *used; ++k) { /* in the order of their own steps */
        const int child = plan->child[k];
        int at = k;
        for (; at > s->first && plan->child[at - 1] > child; --at)
            plan->child[at] = plan->child[at - 1];
        plan->child[at] = child;
    }
}

static void pass_body(mbsri_order *g, int i)
{
    --g->behind[g->m->body[i].parent];
    for (int end = g->first_end[i]; end >= 0; end = g->next_end[end])
        g->ends_left[end / MBSRI_ENDS] -= g->closure[end / MBSRI_ENDS].meets != i;
    for (int end = g->first_top[i]; end >= 0; end = g->next_top[end])
        --g->tops_left[end / MBSRI_ENDS];
}

static void count_operations(mbsri_order *g, int vertex, int width)
{
    const bool body = vertex <= g->m->bodies;
    const int own = body ? g->m->body[vertex].n : width_of(g, vertex);
    double sum = 0.0;
    for (int k = 0; k < own; ++k) sum += 0.5 * (width + k) * (width + k + 1);
    if (body) sum += (double)width_of(g, vertex) * (width + own);
    g->plan->operations += sum;
    if (width + own > g->plan->widest) g->plan->widest = width + own;
}

/* What is left becomes an element, unless it is nothing but the inertia that a predecessor gets of
 * a tree. */
static bool close_element(mbsri_order *g, int e, size_t first, bool plain)
{
    g->first[e] = (int)first;
    g->count[e] = plain ? -1 : (int)(g->members.count - first);
    if (plain) g->members.count = first;
    for (size_t k = first; k < g->members.count; ++k) {
        const int vertex = ((int *)g->members.data)[k];
        if (!mbsri_reserve(&g->m->allocator, &g->links, 1, sizeof(link))) return false;
        ((link *)g->links.data)[g->links.count] = (link){e, g->first_link[vertex]};
        g->first_link[vertex] = (int)g->links.count++;
    }
    return true;
}

/* Scores that the step has changed. */
static bool renew(mbsri_order *g, int vertex, int e)
{
    const int bodies = g->m->bodies;
    bool room = true;
    for (int k = 0; k < g->count[e] && room; ++k) {
        const int other = ((int *)g->members.data)[g->first[e] + k];
        const bool fixed = g->rule.choice == MBSRI_ORDER_TREE && other <= bodies;
        if (!fixed && (g->count[e] <= EAGER || !g->queued[other])) room = offer(g, other);
    }
    if (vertex > bodies || !room) return room;
    for (int end = g->first_end[vertex]; end >= 0 && room; end = g->next_end[end])
        room = offer(g, bodies + 1 + end / MBSRI_ENDS);
    for (int end = g->first_top[vertex]; end >= 0 && room; end = g->next_top[end])
        room = offer(g, bodies + 1 + end / MBSRI_ENDS);
    return room && offer(g, g->m->body[vertex].parent);
}

static bool eliminate(mbsri_order *g, int vertex, int e, int *used)
{
    const int bodies = g->m->bodies;
    const size_t first = g->members.count;
    int width;
    if (!find_border(g, vertex, &width)) return false;
    g->spare[e] = 0;
    g->plan->when[vertex] = e;
    g->plan->step[e] = (mbsri_plan_step){.closure = -1, .next = -1};
    join_elements(g, vertex, e, used);
    g->gone[vertex] = true;
    bool plain = g->plan->step[e].children == 0;
    if (vertex <= bodies) {
        g->plan->step[e].body = vertex;
        g->spare[e] += g->m->body[vertex].n;
        for (int end = g->first_end[vertex]; end >= 0; end = g->next_end[end])
            plain = plain && g->gone[bodies + 1 + end / MBSRI_ENDS];
        pass_body(g, vertex);
    } else {
        g->plan->step[e].closure = vertex - bodies - 1;
        g->spare[e] -= width_of(g, vertex);
        plain = false;
    }
    count_operations(g, vertex, width);
    return close_element(g, e, first, plain) && renew(g, vertex, e);
}

bool mbsri_order_make(mbsri_order *g, mbsri_order_rule rule, double most, mbsri_plan *plan)
{
    int used = 0;
    g->rule = rule;
    g->plan = plan;
    plan->steps = plan->widest = 0;
    plan->operations = 0.0;
    begin_order(g);
    for (int v = 1; v < g->vertices; ++v) {
        if (!offer(g, v)) return false;
    }
    while (plan->steps < g->vertices - 1 && plan->operations <= most && g->heap.count > 0) {
        const mbsri_key now = mbsri_heap_take(&g->heap);
        double score;
        if (g->gone[now.vertex] || now.version != g->version[now.vertex]) continue;
        if (!find_score(g, now.vertex, &score)) return false;
        if (score > now.score) { /* it has grown since */
            if (!mbsri_heap_insert(&g->m->allocator, &g->heap,
                                   (mbsri_key){score, now.vertex, now.version}))
                return false;
            continue;
        }
        if (!eliminate(g, now.vertex, plan->steps++, &used)) return false;
    }
    return true;
}
