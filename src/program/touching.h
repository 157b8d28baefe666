/* A model whose shapes touch.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_TOUCHING_H
#define MBSRANK_TOUCHING_H

#include "program/program.h"

struct mbsr_contact_point;

typedef struct touching {
    struct mbsr_contacts *contacts; /* NULL: nothing touches */
    mbsr_model *model; /* a copy with the element, finished; NULL likewise. The caller's */
    int force;         /* the element */
    int count, room;   /* points of the last state that was asked for */
    struct mbsr_contact_point *point;
} touching;

/* In place of a body: any. */
enum { ANY_BODY = -3 };

#ifdef MBSR_WITH_CONTACT
/* Makes it of the shapes for contact of a file, those left out that are drawn into each other at q,
 * or where it is not `on` nothing; says what it did unless `quiet`. A code. */
int touching_make(const program_model *m, const double *q, bool on, bool quiet, touching *t);
void touching_free(touching *t); /* the object, after the model */

/* Likewise, and the model with the element and data of it are those of m. */
int touching_put(program_model *m, const double *q, bool on, bool quiet, touching *t);

/* Takes the points at the state of the data, which is at mbsr_stage_velocities. A code. */
int touching_look(touching *t, mbsr_data *data);

/* Of a point: where it is (m), and the force on that one of its bodies that has the larger id (N),
 * world axes. */
void touching_arrow(const touching *t, int k, float place[3], float force[3]);

/* Of the points of a body, with another one or ANY_BODY: the sum of the forces on it (N), and where
 * they act, on average by normal forces (m); without points 0 and `none`. */
void touching_load(const touching *t, int body, int other, const double none[3], double value[6]);
#else
static inline int touching_make(const program_model *m, const double *q, bool on, bool quiet,
                                touching *t)
{
    (void)m, (void)q;
    *t = (touching){.contacts = NULL};
    if (on && !quiet)
        say(stderr, "nothing touches: this program is without the component contact\n");
    return DONE;
}

static inline int touching_put(program_model *m, const double *q, bool on, bool quiet, touching *t)
{
    return touching_make(m, q, on, quiet, t);
}

static inline void touching_free(touching *t)
{
    (void)t;
}

static inline int touching_look(touching *t, mbsr_data *data)
{
    (void)t, (void)data;
    return DONE;
}

static inline void touching_arrow(const touching *t, int k, float place[3], float force[3])
{
    (void)t, (void)k, (void)place, (void)force;
}

static inline void touching_load(const touching *t, int body, int other, const double none[3],
                                 double value[6])
{
    (void)t, (void)body, (void)other, (void)none, (void)value;
}
#endif

#endif
