/* Closures in the elimination on the tree: which unknowns are carried where.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The multipliers of a closure act on its bodies, and its rows read what these do: they are carried
 * from there towards the root, and are eliminated where the last of its bodies is reached, at the
 * nearest common predecessor. Loops that close on one body by the same successors make one closing
 * front, others another, so that many loops on one body cost no more than each by itself. A closure
 * that reads joint coordinates of that body closes on the one before it; one whose forces are not
 * balanced there, on the root: such as one that reaches past a POINT, which hands on no moments.
 *
 * Directions that a joint's inertia does not determine, and that loops may hold, are delayed:
 * carried on as unknowns with their rows until the loops close. No more of them are carried than
 * there are multipliers lambda to hold them. */
#ifndef MBSRI_CARRIED_H
#define MBSRI_CARRIED_H

#include "newton/carried/record.h"

/* What is carried, as far as the model says; about how many multiplications that takes. Then the
 * memory for it. False: there is none. Bodies are numbered. */
bool mbsri_carried_plan(mbsr_newton *w);
double mbsri_carried_operations(const mbsr_newton *w);
bool mbsri_carried_create(mbsr_newton *w);
void mbsri_carried_destroy(mbsr_newton *w);

/* Before an elimination: the derivatives of all closures at the state. A status. */
int mbsri_carried_open(mbsr_newton *w, mbsr_data *d, double c);

/* The place of the name in a list of `count`; -1: it is not there. */
static inline int mbsri_carried_find(const int *list, int count, int name)
{
    for (int k = 0; k < count; ++k) {
        if (list[k] == name) return k;
    }
    return -1;
}

/* The place of a name in a pool, which it joins. */
int mbsri_carried_join(mbsr_newton *w, mbsri_pool *pool, int name);

/* Pool k. */
static inline mbsri_pool *mbsri_carried_at(const mbsr_newton *w, int k)
{
    return w->carried.lane_pool + k;
}

/* In vector code: what of the rows of the loops that close at front k stands in their multipliers
 * alone, when these are in its pool. */
void mbsri_carried_diagonal(mbsr_newton *w, const mbsr_data *d, int k, double c);

/* Whether what eta moves along position rows of the loops that close at front k is more than
 * rounding: MBSR_LOOP_SINGULAR where it is not, MBSRI_NOT_SERVED where that is for the front to
 * judge. After mbsri_carried_diagonal. */
int mbsri_carried_judge(const mbsr_newton *w, mbsr_data *d, int k, double c);

/* When all names have come to the pool at which closures are eliminated: where their rows stand. */
void mbsri_carried_seat(mbsr_newton *w, int k);

/* The front at which a name may go. */
static inline int mbsri_carried_level(const mbsr_newton *w, int name)
{
    const mbsri_carried *v = &w->carried;
    return name < v->multipliers ? v->loop[v->closure[name]].level : 0;
}

/* The names of lambda, eta and w of a closure's row. */
static inline int mbsri_name_lambda(const mbsri_closure *c, int k)
{
    return c->row + k;
}

static inline int mbsri_name_eta(const mbsr_model *m, const mbsri_closure *c, int k)
{
    return m->rows + c->position_row + k;
}

/* Of unknown k of a joint, or of the group of that head. */
static inline int mbsri_name_own(const mbsr_newton *w, int i, int k)
{
    return w->carried.multipliers + (int)w->node[i].v + k;
}

#endif
