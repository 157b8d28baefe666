/* The plan of an elimination of models with loops: in which order joints are passed and loop forces
 * eliminated, and what meets where.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Vertices are bodies and closures. Passing the joint of a body replaces its motion by that of its
 * predecessor and the joint's rates, which are eliminated; a closure's forces are eliminated in a
 * step of their own. What a step leaves, its border, are motions of bodies and forces of closures
 * that later steps eliminate: one of them takes it. A border may have the motions of several
 * bodies, so that branches that loops tie go up side by side.
 *
 * The forces of a closure go
 *   when all its paths have been passed up to the body where these meet,
 *   or earlier, when all its ends have entered and as many rates have been passed as it has rows,
 *       and some more,
 *   or when one end has entered, twice as many have been passed, or all of its path, and the motion
 *       of the other is taken into the border.
 * Several orders are made by greedy rules (order.c), and the one with the fewest multiplications is
 * kept (choose.c). */
#ifndef MBSRI_FRONTS_PLAN_H
#define MBSRI_FRONTS_PLAN_H

#include "model/record.h"

enum { MBSRI_ENDS = MBSR_CLOSURE_BODIES + 1 }; /* of a closure */

typedef struct mbsri_plan_step {
    int body;            /* whose joint is passed; 0: none */
    int closure;         /* whose forces are eliminated; -1: none */
    int next;            /* the step that takes what is left; -1: nothing is */
    int first, children; /* steps that this one takes from: places in `child` */
    int complete, waiting, motions,
        own;      /* unknowns of its front, as far as none is late (names.h) */
    int leaves;   /* of these that go on, with the motion of a predecessor */
    size_t names; /* their place in `name` */
} mbsri_plan_step;

typedef struct mbsri_plan {
    int steps;
    mbsri_plan_step *step;
    int *child; /* steps */
    int *when;  /* bodies + 1 + closures: the step of each; that of the root is the last */
    bool far;   /* borders have motions of far ends */
    struct mbsri_plan *near;   /* where far: the plan without; NULL elsewhere */
    double operations;         /* multiplications */
    int widest;                /* numbers in the widest front */
    int *first_end, *next_end; /* ends of closures at a body (closure * MBSRI_ENDS + l), -1: none */
    int *eliminated;           /* rows: in which step */
    int *name;                 /* unknowns of all fronts, one front after the other */
    int most;                  /* unknowns of the widest front */
    size_t bytes;              /* memory of a factorisation in which no unknown is late */
} mbsri_plan;

/* Whether the closure reads its body number l, and that may move. */
static inline bool mbsri_plan_reads(const mbsri_closure *c, int l)
{
    return c->body[l] > 0 && c->column[l] >= 0;
}

#endif
