/* What a run writes: columns by name.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_COLUMNS_H
#define MBSRANK_COLUMNS_H

#include "program/touching.h"

typedef enum column_kind {
    COLUMN_Q,
    COLUMN_U,
    COLUMN_POSITION,
    COLUMN_SENSOR,
    COLUMN_KINETIC,
    COLUMN_POTENTIAL,
    COLUMN_CONTACT
} column_kind;

typedef struct column {
    char name[200];
    const char *unit; /* such as "rad/s"; "1" */
    column_kind kind;
    int at, part; /* place in q or u; or body and axis; or sensor and which of its numbers */
    int other;    /* CONTACT: the second body */
} column;

typedef struct columns {
    const mbsr_file *file; /* file that has the sensors */
    column *list;
    int count;
    touching *touching; /* of CONTACT, while there are values */
} columns;

/* Of names between commas: a joint (its q), NAME.rate (its u), NAME.pos of a body (its origin), a
 * sensor, energy, state (all joints, then all their rates), NAME.contact of a body and
 * NAME:NAME.contact of two (`world` is the ground), contacts (of all bodies with shapes that
 * touch); NULL: all joints. A code. */
int columns_make(const program_model *m, const char *names, columns *c);

/* All there are, sensors before positions of bodies. A code. */
int columns_all(const program_model *m, columns *c);

/* Their numbers at this state, at which the data is at mbsr_stage_accelerations. A status, whose
 * text the data has. */
int columns_values(const columns *c, const mbsr_model *model, mbsr_data *data, double t,
                   const double *q, const double *u, double *value);

bool columns_have_contacts(const columns *c);

/* The first line of CSV: t and the names. */
void columns_head(const columns *c, FILE *to);

#endif
