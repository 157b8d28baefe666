/* What is known and unknown of loops along the tree, and memory for it: see system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_WAITING_H
#define MBSRI_LOOPS_WAITING_H

#include "algebra/pivots.h"
#include "recursion/data.h"

enum { MBSRI_ENDS = MBSR_CLOSURE_BODIES + 1 }; /* of a closure */

/* What a joint sees of the loops. */
typedef struct mbsri_passing {
    int count, nulls; /* unknowns that pass; its own that move no mass */
    int *id;       /* of both: rows of C, or rows + place of a joint rate (order of the sweeps) */
    double *X, *N; /* n x count, n x nulls */
} mbsri_passing;

/* What waits at a body. */
typedef struct mbsri_waiting {
    int count, *id;
    double *F, *sizes;   /* count x count, and what was added up in it */
    double *Q, *lengths; /* d x count, likewise */
    struct mbsri_waiting *next;
} mbsri_waiting;

typedef struct mbsri_system {
    const mbsr_model *m;
    mbsr_data *d;
    const double
        *armature; /* nu, in the order of the sweeps: of joints without other masses; NULL: M is
                               the mass matrix of the tree */
    mbsri_passing **joint;     /* bodies + 1; NULL: nothing passes */
    mbsri_waiting **behind;    /* bodies + 1: of successors */
    mbsri_pivots **closing;    /* bodies + 1: eliminated there */
    mbsri_waiting **part;      /* bodies + ends: what meets at one body */
    int *first_end, *next_end; /* ends of closures at a body, -1: none */
    int *closes;               /* rows: the body where it is eliminated */
    bool *left_out;            /* rows: without a part in the equations; stiff ones at first */
    int *slot, *set;           /* rows + nu: places of unknowns for a short time, -1; unknowns */
    int *group, *mate;         /* bodies + ends: of parts */
    double *s, *v;             /* rows + nu: right-hand sides, solution */
    double *a, *fbar, *e;      /* size_v, size_v, nu */
    double *share;             /* rows: of rows in norms, see pivots.h */
    int free; /* place of a joint rate whose motion nothing determines, -1: there is none */
    void *memory;
    struct mbsri_chunk *chunks; /* of the factors */
} mbsri_system;

/* Takes memory from the model's allocator; mbsri_system_close gives it back, after a failure too. */
int mbsri_system_open(mbsri_system *w, const mbsr_model *m, mbsr_data *d, const char *function);
void mbsri_system_close(mbsri_system *w);

/* Memory for the factors, NULL where there is none. */
void *mbsri_system_allocate(mbsri_system *w, size_t size);

/* Of `count` unknowns at a body of d velocities: all zero. NULL: no memory. */
mbsri_waiting *mbsri_open_waiting(mbsri_system *w, int count, int d);

#endif
