/* The plan of an elimination: in which order bodies are passed, and what meets where.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A step passes one body, successors before predecessors: all that is known of the motion x of the
 * body, its own equations, elements and closures on it, and the fronts of earlier steps that read
 * x, make one dense matrix, its front. With x = X z, z = (x of the predecessor, dq, du), the front
 * no longer reads x; what of the joint's unknowns and of multipliers has a pivot is eliminated, the
 * rest is carried on by the next step that passes a body of its border. So a border has the
 * predecessor, and those bodies on the other side of elements and closures that have not been
 * passed. */
#ifndef MBSRI_FRONT_PLAN_H
#define MBSRI_FRONT_PLAN_H

#include "newton/front/source.h"

/* Unknowns, beside those of open groups, that all fronts that wait for one body may hand on to it:
 * else what each of many might has its place there. */
enum { MBSRI_FRONT_ROOM = 128 };

typedef struct mbsri_front_step {
    int body;
    int first_child,
        children; /* range in `child`: steps whose contribution blocks are added here */
    int first_element, elements; /* range in `element`: k: force k; forces + k: closure k; forces +
                                  * closures + k: pair k */
    int first_border, borders;   /* range in `border`: bodies, as they are passed */
    int next;     /* the step that takes in the contribution block; -1: there is none */
    int unknowns; /* the most that may be eliminated: of the joint, multipliers, delayed ones */
    int rates;    /* joint rates of the body */
    int rows, columns;               /* the most of the front */
    int border_rows, border_columns; /* of the bodies of the border */
    int carried;                     /* the most unknowns that are left to step `next` */
    bool crowded;   /* whether the steps before may not all hand on as many as each of them may */
    int room;       /* how many more they may now, beside those of open groups */
    bool axes;      /* whether axes_step.h may pass it */
    bool may_float; /* whether its body floats by its model (floating.h), */
    bool floats;    /* and at the present ranks */
    int delayed;    /* the most of these for want of a pivot, open groups apart */
    size_t matrix;  /* offset of the contribution block in `matrices` of the front */
    size_t LU;      /* offset in its `LU`: factors, then d(M u) and dp' of the joint */
    size_t numbers; /* offset in its `numbers`: of rows, then of columns */
} mbsri_front_step;

/* A body of a border. */
typedef struct mbsri_front_border {
    int body;
    bool whole; /* its impulse is among the rows: a joint passes it, elements do not load it */
} mbsri_front_border;

typedef struct mbsri_front_plan {
    int steps, entries, children, elements; /* lengths of step, border, child and element */
    mbsri_front_step *step;
    int *position; /* N + 1: the step of a body */
    int *child, *element;
    mbsri_front_border *border;
    bool crowded;      /* whether a step is */
    bool *coordinates; /* N + 1: whether what acts on several bodies reads its joint coordinates */
    int most_rows, most_columns;    /* of all steps */
    size_t matrices, doubles, ints; /* lengths of `matrices`, `LU` and `numbers` of the front */
    double operations;              /* multiplications of a factorisation, about */
} mbsri_front_plan;

/* The cheapest of some plans. served (N + 1; NULL: all): the bodies that are passed, in their
 * order, beside others that something else passes; their elements are added pair by pair
 * (newton/slopes/relation.h). False: there is no memory. */
bool mbsri_front_plan_create(const mbsri_front_source *from, const bool *served,
                             mbsri_front_plan *plan);
void mbsri_front_plan_destroy(const mbsr_allocator *allocator, mbsri_front_plan *plan);
size_t mbsri_front_plan_bytes(const mbsri_front_source *from, const mbsri_front_plan *plan);

#endif
