/* The cheapest of several orders of elimination: see choose.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/choose.h"

#include "base/memory.h"
#include "fronts/names.h"
#include "fronts/order.h"

#include <string.h>

/* Forces that are eliminated when just as many rates have been passed as there are rows leave
 * little of their pivots, and digits get lost from loop to loop: a plan that waits for some more
 * may cost so much more. */
static const double careful = 0.6;
enum { MORE = 5 };

/* Those that are linear most often first, so that others stop early; of equals the last one counts.
 */
static const mbsri_order_rule rules[] = {
    {MBSRI_ORDER_BORDER, MBSRI_ORDER_FAR, MORE},   {MBSRI_ORDER_GROWTH, MBSRI_ORDER_FAR, MORE},
    {MBSRI_ORDER_BORDER, MBSRI_ORDER_EARLY, 0},    {MBSRI_ORDER_BORDER, MBSRI_ORDER_EARLY, MORE},
    {MBSRI_ORDER_GROWTH, MBSRI_ORDER_EARLY, MORE}, {MBSRI_ORDER_TREE, MBSRI_ORDER_EARLY, 0},
    {MBSRI_ORDER_TREE, MBSRI_ORDER_EARLY, MORE},   {MBSRI_ORDER_TREE, MBSRI_ORDER_WHOLE, 0}};

void mbsri_plan_destroy(const mbsr_model *m, mbsri_plan *plan)
{
    if (plan) {
        mbsri_plan_destroy(m, plan->near);
        mbsri_release(&m->allocator, plan->name);
    }
    mbsri_release(&m->allocator, plan);
}

static mbsri_plan *allocate_plan(const mbsr_model *m)
{
    const size_t bodies = (size_t)m->bodies + 1, vertices = bodies + m->closures.count,
                 steps = vertices, ends = m->closures.count * MBSRI_ENDS,
                 ints = steps + vertices + bodies + ends + (size_t)m->rows;
    mbsri_plan *plan = mbsri_allocate(&m->allocator, sizeof *plan + steps * sizeof *plan->step +
                                                         ints * sizeof(int));
    if (!plan) return NULL;
    *plan = (mbsri_plan){.step = (mbsri_plan_step *)(void *)(plan + 1)};
    plan->child = (int *)(void *)(plan->step + steps);
    plan->when = plan->child + steps;
    plan->first_end = plan->when + vertices;
    plan->next_end = plan->first_end + bodies;
    plan->eliminated = plan->next_end + ends;
    return plan;
}

static void copy(const mbsr_model *m, const mbsri_plan *from, mbsri_plan *to)
{
    const size_t vertices = (size_t)m->bodies + 1 + m->closures.count;
    to->steps = from->steps;
    to->operations = from->operations;
    to->widest = from->widest;
    memcpy(to->step, from->step, vertices * sizeof *to->step);
    memcpy(to->child, from->child, vertices * sizeof *to->child);
    memcpy(to->when, from->when, vertices * sizeof *to->when);
}

/* The cheapest order into `best`; false: there is no memory. */
static bool choose_order(const mbsr_model *m, bool far, mbsri_order *order, mbsri_plan *best,
                         mbsri_plan *other)
{
    const int steps = m->bodies + (int)m->closures.count;
    double least = 1e300; /* operations, of careful plans their share */
    const size_t all = sizeof rules / sizeof rules[0], count = m->rows > 0 ? all : 1;
    for (size_t k = all - count; k < all; ++k) {
        const double share =
            rules[k].more > 0 || rules[k].moment == MBSRI_ORDER_WHOLE ? careful : 1.0;
        if (rules[k].moment == MBSRI_ORDER_FAR && !far) continue;
        if (!mbsri_order_make(order, rules[k], least / share, other)) return false;
        if (other->steps < steps || other->operations * share > least) continue;
        least = other->operations * share;
        copy(m, other, best);
        best->far = rules[k].moment == MBSRI_ORDER_FAR;
    }
    return true;
}

/* The root is the last step; it takes what is left anywhere. */
static void add_root(mbsri_plan *plan)
{
    mbsri_plan_step *root = plan->step + plan->steps;
    int used = 0;
    for (int k = 0; k < plan->steps; ++k) used += plan->step[k].children;
    *root = (mbsri_plan_step){.closure = -1, .next = -1, .first = used};
    for (int k = 0; k < plan->steps; ++k) {
        if (plan->step[k].next >= 0) continue;
        plan->step[k].next = plan->steps;
        plan->child[used++] = k;
    }
    root->children = used - root->first;
    plan->when[0] = plan->steps++;
}

bool mbsri_plan_create(const mbsr_model *m, bool far, mbsri_plan **plan)
{
    mbsri_order *order = mbsri_order_open(m);
    mbsri_plan *best = allocate_plan(m), *other = allocate_plan(m);
    bool made = order && best && other && choose_order(m, far, order, best, other);
    if (made) add_root(best);
    made = made && mbsri_fronts_plan_names(m, best);
    made = made && (!best->far || mbsri_plan_create(m, false, &best->near));
    if (order) mbsri_order_close(order);
    mbsri_plan_destroy(m, other);
    if (!made) mbsri_plan_destroy(m, best);
    *plan = made ? best : NULL;
    return made;
}
