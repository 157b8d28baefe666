/* What plans are made of: elements, closures and pairs, with their bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_SOURCE_H
#define MBSRI_FRONT_SOURCE_H

#include "newton/linear/linear.h"

/* What a plan is made of: the model's elements and closures, and the pairs that act at a state.
 * NULL: elements by pairs act on all their bodies at once. */
typedef struct mbsri_front_source {
    const mbsr_model *model;
    const mbsri_pairs *pairs;
    const bool *apart; /* pairs whose bodies the plan does not tie (crowd.h); NULL: none */
    const mbsr_allocator *allocator;
} mbsri_front_source;

/* Forces, closures and pairs. */
int mbsri_front_elements(const mbsri_front_source *from);

bool mbsri_front_is_apart(const mbsri_front_source *from, int element);

/* The bodies of an element, closure or pair, by index, the root and repetitions among them. */
int mbsri_front_bodies(const mbsri_front_source *from, int element, const int **list);

#endif
