/* A model whose shapes touch.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_TOUCHING_H
#define MBSRANK_TOUCHING_H

#include "program/program.h"

typedef struct touching {
    struct mbsr_contacts *contacts; /* NULL: nothing touches */
    mbsr_model *model; /* a copy with the element, finished; NULL likewise. The caller's */
} touching;

#ifdef MBSR_WITH_CONTACT
/* Makes it of the shapes for contact of a file, those left out that are drawn into each other at q,
 * or where it is not `on` nothing; says what it did unless `quiet`. A code. */
int touching_make(const program_model *m, const double *q, bool on, bool quiet, touching *t);
void touching_free(touching *t); /* the object, after the model */
#else
static inline int touching_make(const program_model *m, const double *q, bool on, bool quiet,
                                touching *t)
{
    (void)m, (void)q;
    *t = (touching){NULL, NULL};
    if (on && !quiet)
        say(stderr, "nothing touches: this program is without the component contact\n");
    return DONE;
}

static inline void touching_free(touching *t)
{
    (void)t;
}
#endif

#endif
