/* Greedy orders of elimination.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONTS_ORDER_H
#define MBSRI_FRONTS_ORDER_H

#include "fronts/plan.h"

/* Which vertex is next, of those that may be. */
typedef enum mbsri_order_choice {
    MBSRI_ORDER_TREE,   /* closures, then the body with the greatest number */
    MBSRI_ORDER_BORDER, /* the one with the least border */
    MBSRI_ORDER_GROWTH  /* the one whose border, squared, grows least beyond those that it joins */
} mbsri_order_choice;

/* When the forces of a closure may go: see plan.h. */
typedef enum mbsri_order_moment {
    MBSRI_ORDER_WHOLE,
    MBSRI_ORDER_EARLY,
    MBSRI_ORDER_FAR
} mbsri_order_moment;

typedef struct mbsri_order_rule {
    mbsri_order_choice choice;
    mbsri_order_moment moment;
    int more; /* rates to be passed beyond the rows of a closure before its forces go early */
} mbsri_order_rule;

typedef struct mbsri_order mbsri_order;

/* What all orders of a model have in common; NULL: there is no memory. */
mbsri_order *mbsri_order_open(const mbsr_model *m);
void mbsri_order_close(mbsri_order *order);

/* Fills steps, `child` and `when` of a plan with room for bodies + closures steps; stops when
 * `operations` is above `most`. False: there is no memory. */
bool mbsri_order_make(mbsri_order *order, mbsri_order_rule rule, double most, mbsri_plan *plan);

#endif
