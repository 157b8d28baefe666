/* Which directions that move no mass may act on which: see couplings.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The force gamma_k along direction k is the power of forces on bodies that move along it. It
 * changes to the first order with direction l only if l moves
 *
 *   a body that k moves, one of their predecessors or successors, or one of a group with them, as
 *       these
 *   make the direction what it is,
 *   a body of an element that acts on a body that k moves,
 *   or a body that counts for a direction that begins at one of these: k keeps clear of it.
 *
 * Columns of a matrix of differences whose rows do not meet are found with one displacement
 * (Curtis, Powell and Reid, J. Inst. Maths Applics 13, 1974). */
#include "massless/couplings.h"

#include "algebra/numbers.h"
#include "recursion/group.h"

#include <string.h>

/* Whether direction l moves body i; its joint. */
static bool moves(const mbsri_null_space *w, int l, int i)
{
    const mbsri_body *b = w->m->body + i;
    return mbsri_largest(b->d, w->twist + (size_t)l * w->m->size.v + b->v) > 0.0;
}

static bool turns(const mbsri_null_space *w, int l, int i)
{
    const mbsri_body *b = w->m->body + i;
    return mbsri_largest(b->n, w->direction + (size_t)l * (size_t)w->m->nu + b->u) > 0.0;
}

/* y = y or x */
static void join(int count, const bool *x, bool *y)
{
    for (int k = 0; k < count; ++k) y[k] = y[k] || x[k];
}

/* What counts for every direction that moves a body; all arrays bodies x k, those of a body in a
 * row. */
typedef struct tables {
    bool *displaced, *rotated, *changed; /* the body; its joint; one of them */
    bool *depends;
} tables;

/* Bodies that make the directions what they are. */
static void find_bodies(const mbsri_null_space *w, const tables *t)
{
    const mbsr_model *m = w->m;
    const int k = w->k;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const bool *changed = t->changed + (size_t)i * (size_t)k;
        const mbsri_group g = mbsri_group_in_model(m, b->group.head);
        for (int n = 0; n < g.members; ++n)
            join(k, changed, t->depends + (size_t)g.member[n] * (size_t)k);
        join(k, changed, t->depends + (size_t)b->parent * (size_t)k);
        join(k, t->displaced + (size_t)b->parent * (size_t)k, t->depends + (size_t)i * (size_t)k);
    }
}

/* Bodies of elements that act on a body that moves. */
static void find_elements(const mbsri_null_space *w, const tables *t)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = m->forces.data;
    for (size_t n = 0; n < m->forces.count; ++n, ++force) {
        const int *list = m->stored.list_index + force->list;
        const bool joint = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
        const bool *sees = joint ? t->rotated : t->changed;
        for (int a = 0; a < force->def.bodies; ++a) {
            for (int b = 0; b < force->def.bodies; ++b)
                join(w->k, sees + (size_t)list[a] * (size_t)w->k,
                     t->depends + (size_t)list[b] * (size_t)w->k);
        }
    }
}

/* The same of bodies that are closed to one. */
static void find_closures(const mbsri_null_space *w, const tables *t)
{
    const mbsri_closure *c = w->m->closures.data;
    for (size_t n = 0; n < w->m->closures.count; ++n, ++c) {
        for (int a = 0; a < c->bodies; ++a) {
            for (int b = 0; b < c->bodies; ++b)
                join(w->k, t->changed + (size_t)c->body[a] * (size_t)w->k,
                     t->depends + (size_t)c->body[b] * (size_t)w->k);
        }
    }
}

/* Directions that begin at a body of another one, the last one first. */
static void find_directions(const mbsri_null_space *w, const tables *t)
{
    const int k = w->k;
    const size_t rows = (size_t)w->m->bodies + 1;
    for (int l = k - 1; l >= 0; --l) {
        const bool *at_head = t->depends + (size_t)w->head[l] * (size_t)k;
        for (int a = 0; a < k; ++a) {
            if (a == l || !at_head[a] || w->head[a] > w->head[l]) continue;
            for (size_t i = 1; i < rows; ++i) {
                bool *row = t->depends + i * (size_t)k;
                row[a] = row[a] || row[l];
            }
        }
    }
}

/* Greedy: each direction gets the first colour that none of those it affects has seen; seen: k x k.
 */
static void give_colours(mbsri_null_space *w, bool *seen)
{
    const int k = w->k;
    w->difference.colours = 0;
    for (int l = 0; l < k; ++l) {
        const bool *affects = w->difference.affects + (size_t)l * (size_t)k;
        int c = 0;
        for (; c < w->difference.colours; ++c) {
            const bool *used = seen + (size_t)c * (size_t)k;
            int a = 0;
            while (a < k && !(affects[a] && used[a])) ++a;
            if (a == k) break;
        }
        if (c == w->difference.colours)
            memset(seen + (size_t)w->difference.colours++ * (size_t)k, 0, (size_t)k);
        join(k, affects, seen + (size_t)c * (size_t)k);
        w->difference.colour[l] = c;
    }
}

void mbsri_null_couple(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    const size_t k = (size_t)w->k, rows = (size_t)m->bodies + 1, size = rows * k;
    bool *const place = w->difference.tables;
    const tables t = {place, place + size, place + 2 * size, place + 3 * size};
    memset(place, 0, 4 * size);
    memset(w->difference.affects, 0, k * k);
    for (int l = 0; l < w->k; ++l) {
        for (int i = 1; i <= m->bodies; ++i) {
            const size_t at = (size_t)i * k + (size_t)l;
            t.displaced[at] = moves(w, l, i);
            t.rotated[at] = turns(w, l, i);
            t.changed[at] = t.displaced[at] || t.rotated[at];
        }
    }
    find_bodies(w, &t);
    find_elements(w, &t);
    find_closures(w, &t);
    find_directions(w, &t);
    for (int l = 0; l < w->k; ++l) {
        for (size_t i = 1; i < rows; ++i) {
            if (t.changed[i * k + (size_t)l])
                join(w->k, t.depends + i * k, w->difference.affects + (size_t)l * k);
        }
    }
    give_colours(w, place + 4 * size);
}
