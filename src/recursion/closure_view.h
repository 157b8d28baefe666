/* The bodies of a closure as its functions see them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURE_VIEW_H
#define MBSRI_CLOSURE_VIEW_H

#include "recursion/data.h"

/* Bodies of a closure as its functions see them; velocities where they are asked for. */
typedef struct mbsri_closure_view {
    mbsr_force_body body[MBSR_CLOSURE_BODIES + 1];
    mbsr_closure_args args;
    double *q; /* most.columns of scratch */
} mbsri_closure_view;

/* Asks the memory for closures behind c, and for what is read of their bodies, in large models. */
void mbsri_expect_closure(const mbsr_model *m, const mbsri_closure *c);

void mbsri_view_closure(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                        bool velocities, mbsri_closure_view *view);

/* Adds them to a view without. */
void mbsri_view_velocities(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                           mbsri_closure_view *view);

/* The name of row k by its table, "" where it gives none. */
const char *mbsri_closure_row_name(const mbsr_model *m, const mbsri_closure *c, int k);

/* Whether it acts on joint coordinates alone; V of its bodies need not be there. */
static inline bool mbsri_is_coupling(const mbsri_closure *c)
{
    const unsigned flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES;
    return (c->def.table->flags & flags) == flags;
}

#endif
