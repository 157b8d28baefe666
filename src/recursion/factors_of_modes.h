/* The parts of flexible_factors.h: what the factors are, and how they are found.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FACTORS_OF_MODES_H
#define MBSRI_FACTORS_OF_MODES_H

#include "flexible/data.h"
#include "recursion/group.h"
#include "recursion/modal.h"

/* Where the factors of a body stand, columns of n numbers: in D the rows of V, then Diag(D); in
 * Dinv V1 R and Q, then T^-1; in U the Cholesky factor of B. */
typedef struct mbsri_factors {
    const mbsr_flex *flex;
    int n, d, rows, kept, others; /* kept: of massless modes; others: rows without these */
    double *V, *diagonal, *V1, *Q, *T, *B;
} mbsri_factors;

static inline mbsri_factors mbsri_factors_of(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n, rows = d->factors.rows[i];
    mbsri_factors f = {.flex = b->inertia.flex, .n = n, .d = b->d, .rows = rows};
    f.kept = d->rank[i] - f.flex->massive;
    f.others = rows - f.kept;
    f.V = d->D + b->nn;
    f.diagonal = f.V + n * rows;
    f.V1 = d->Dinv + b->nn;
    f.Q = f.V1 + n * f.kept;
    f.T = f.V1 + n * rows;
    f.B = d->U + b->dg;
    return f;
}

/* Scratch behind what mbsri_null_part and mbsri_null_force need. */
static inline double *mbsri_factors_work(const mbsr_model *m, const mbsr_data *d)
{
    return d->scratch + m->most.d;
}

/* Rank and factors of body i, as far as they are known to be those of D; else false. */
bool mbsri_factors_find_rank(const mbsr_model *m, mbsr_data *d, int i);

#endif
