/* Orders of elimination: see order.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Minimum degree, as of sparse matrices: bodies that elements, closures or fronts have in common
 * are cliques; passing a body joins the cliques that it belongs to, with its predecessor, in one.
 */
#include "newton/front/order.h"

#include "base/heap.h"

/* ---- by depth ---- */

void mbsri_front_order_by_depth(const mbsr_model *m, int *order, int *work)
{
    int *depth = work, *behind = work + m->bodies + 1; /* how many are deeper than that */
    depth[0] = 0;
    for (int i = 0; i <= m->bodies; ++i) behind[i] = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        depth[i] = depth[m->body[i].parent] + 1;
        ++behind[depth[i] - 1];
    }
    for (int k = m->bodies; k > 0; --k) behind[k - 1] += behind[k];
    for (int i = 1; i <= m->bodies; ++i) order[behind[depth[i]]++] = i;
}

/* ---- by border ---- */

typedef struct link {
    int clique, next; /* the next of the same body; -1: none */
} link;

typedef struct graph {
    const mbsr_model *m;
    const mbsri_front_source *from;
    mbsri_array members, links, heap; /* int, link, key */
    int *first, *count;               /* of cliques in `members`; count -1: joined to another */
    int cliques;
    int *first_link; /* N + 1 */
    int *left;       /* N + 1: successors that have not been passed; -1: the body itself has */
    int *marked, mark;
} graph;

static bool add_member(graph *g, int body)
{
    if (body == 0 || g->left[body] < 0 || g->marked[body] == g->mark) return true;
    g->marked[body] = g->mark;
    if (!mbsri_reserve(g->from->allocator, &g->members, 1, sizeof(int))) return false;
    ((int *)g->members.data)[g->members.count++] = body;
    return true;
}

/* The clique of the members from `first` on. */
static bool close_clique(graph *g, size_t first)
{
    const int clique = g->cliques++;
    g->first[clique] = (int)first;
    g->count[clique] = (int)(g->members.count - first);
    for (int k = 0; k < g->count[clique]; ++k) {
        const int body = ((int *)g->members.data)[first + (size_t)k];
        if (!mbsri_reserve(g->from->allocator, &g->links, 1, sizeof(link))) return false;
        ((link *)g->links.data)[g->links.count] = (link){clique, g->first_link[body]};
        g->first_link[body] = (int)g->links.count++;
    }
    return true;
}

/* How many bodies the border has when body i is passed. */
static int degree(graph *g, int i)
{
    int sum = 0;
    const int *members = g->members.data;
    ++g->mark;
    g->marked[i] = g->mark;
    const int parent = g->m->body[i].parent;
    if (parent > 0) ++sum, g->marked[parent] = g->mark;
    for (int k = g->first_link[i]; k >= 0; k = ((link *)g->links.data)[k].next) {
        const int clique = ((link *)g->links.data)[k].clique;
        for (int l = 0; l < g->count[clique]; ++l) {
            const int body = members[g->first[clique] + l];
            if (g->left[body] < 0 || g->marked[body] == g->mark) continue;
            g->marked[body] = g->mark;
            ++sum;
        }
    }
    return sum;
}

/* Passes body i: its cliques become one. */
static bool pass(graph *g, int i)
{
    const size_t first = g->members.count;
    bool room = true;
    ++g->mark;
    g->left[i] = -1;
    room = add_member(g, g->m->body[i].parent);
    for (int k = g->first_link[i]; k >= 0 && room; k = ((link *)g->links.data)[k].next) {
        const int clique = ((link *)g->links.data)[k].clique;
        for (int l = 0; l < g->count[clique] && room; ++l)
            room = add_member(g, ((int *)g->members.data)[g->first[clique] + l]);
        g->count[clique] = -1;
    }
    return room && close_clique(g, first);
}

/* Body i may be the next to be passed. */
static bool push(graph *g, int i)
{
    return mbsri_heap_insert(g->from->allocator, &g->heap, (mbsri_key){degree(g, i), i, 0});
}

static bool begin_graph(graph *g)
{
    const mbsr_model *m = g->m;
    const int elements = mbsri_front_elements(g->from);
    for (int i = 0; i <= m->bodies; ++i) g->left[i] = g->marked[i] = 0, g->first_link[i] = -1;
    for (int i = 1; i <= m->bodies; ++i) ++g->left[m->body[i].parent];
    for (int k = 0; k < elements; ++k) {
        const int *list, count = mbsri_front_bodies(g->from, k, &list);
        const size_t first = g->members.count;
        ++g->mark;
        for (int l = 0; l < count && !mbsri_front_is_apart(g->from, k); ++l) {
            if (!add_member(g, list[l])) return false;
        }
        if (!close_clique(g, first)) return false;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (g->left[i] == 0 && !push(g, i)) return false;
    }
    return true;
}

static bool order_all(graph *g, int *order)
{
    int used = 0;
    if (!begin_graph(g)) return false;
    while (used < g->m->bodies) {
        const mbsri_key now = mbsri_heap_take(&g->heap);
        if (degree(g, now.vertex) > now.score) { /* it has grown since */
            if (!push(g, now.vertex)) return false;
            continue;
        }
        order[used++] = now.vertex;
        if (!pass(g, now.vertex)) return false;
        const int parent = g->m->body[now.vertex].parent;
        if (parent > 0 && --g->left[parent] == 0 && !push(g, parent)) return false;
    }
    return true;
}

bool mbsri_front_order_by_border(const mbsri_front_source *from, int *order)
{
    const size_t bodies = (size_t)from->model->bodies + 1,
                 cliques = bodies + (size_t)mbsri_front_elements(from);
    int *memory = mbsri_allocate(from->allocator, (2 * cliques + 3 * bodies) * sizeof(int));
    graph g = {.m = from->model, .from = from};
    bool made = memory != NULL;
    if (made) {
        g.first = memory;
        g.count = g.first + cliques;
        g.first_link = g.count + cliques;
        g.left = g.first_link + bodies;
        g.marked = g.left + bodies;
        made = order_all(&g, order);
        mbsri_release(from->allocator, memory);
    }
    void *const arrays[] = {g.members.data, g.links.data, g.heap.data};
    for (size_t k = 0; k < 3; ++k) {
        if (arrays[k]) mbsri_release(from->allocator, arrays[k]);
    }
    return made;
}
