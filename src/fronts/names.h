/* Which unknowns meet in a step.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Unknowns have numbers: rows, then joint rates, then motions of bodies, body after body. As long
 * as all rows are eliminated in their own steps, the unknowns of each front are those of the plan;
 * where some are late, or left out, they are found again. */
#ifndef MBSRI_FRONTS_NAMES_H
#define MBSRI_FRONTS_NAMES_H

#include "algebra/pivots.h"
#include "fronts/plan.h"

/* What a step leaves to another one. */
typedef struct mbsri_part {
    int count, *id;
    bool planned;      /* these are as in the plan */
    double *A, *sizes; /* count x count, and what was added up in it */
    int step;          /* of the sizes of memory */
} mbsri_part;

/* What a joint sees of the loops. */
typedef struct mbsri_passing {
    int count, nulls; /* unknowns that pass; its own that move no mass */
    int *id;          /* of both */
    double *X, *N;    /* n x count, n x nulls */
} mbsri_passing;

typedef struct mbsri_front_unknowns {
    const mbsr_model *m;
    const mbsri_plan *plan;
    mbsri_part *const *part; /* steps: left by each; NULL: nothing */
    const bool *left_out;    /* rows */
    int *slot, *set;         /* unknowns: places, -1 before; numbers */
} mbsri_front_unknowns;

/* Numbers of those complete, rows that wait, motions of other bodies and of its own. */
typedef struct mbsri_census {
    int complete, waiting, motions, own;
    bool rows; /* some of those complete are rows */
} mbsri_census;

/* Those of step k, in this order into `set`, with their slots. */
mbsri_census mbsri_fronts_names(const mbsri_front_unknowns *x, int k);

/* Fills what a plan has of unknowns, and `bytes`. False: no memory. */
bool mbsri_fronts_plan_names(const mbsr_model *m, mbsri_plan *plan);

/* Whether step k takes the end of a closure on its own body, or of its own closure on a body that
 * is not passed. */
static inline bool mbsri_takes_end(const mbsr_model *m, const mbsri_plan *plan, int k, int closure,
                                   int body)
{
    const int gone = plan->when[m->bodies + 1 + closure];
    return plan->step[k].body == body ? gone > k : gone == k && plan->when[body] > k;
}

static inline int mbsri_motion_name(const mbsr_model *m, const mbsri_body *b)
{
    return m->rows + m->nu + (int)b->v;
}

/* Bytes of memory, rounded up; of a part of so many unknowns, by steps of sizes, *step which. */
static inline size_t mbsri_rounded(size_t size)
{
    return (size + 31) / 32 * 32;
}

size_t mbsri_part_room(int count, int *step);

#endif
