/* A consistent start of a model with closures, front by front.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_TREE_START_H
#define MBSRI_LOOPS_TREE_START_H

#include "loops/ranking.h"
#include "massless/closed_start.h"

/* Starts of a model that differ in their gaps; stiff rows count as rigid ones. */
typedef struct mbsri_tree_start {
    const mbsr_model *m;
    mbsr_data *d;
    mbsri_ranking w;          /* closes loops, finds ranks */
    mbsri_closed_start start; /* where something moves no mass */
    bool ranked;              /* the rows that depend on others are known */
    const double *stiffness;  /* rows: of those that share what others bear, 0: of these; NULL: none
                                 does */
    double *borne, *tau;      /* rows, nu: what such rows do without being in the equations */
} mbsri_tree_start;

/* Takes memory from the model's allocator; to be closed after a failure too. */
int mbsri_tree_start_open(mbsri_tree_start *s, const mbsr_model *m, mbsr_data *d);
void mbsri_tree_start_close(mbsri_tree_start *s);

/* q, u are brought to a state that the closures allow; u' and loop forces (rows; of stiff rows too)
 * are found. The rows that the data leaves out are chosen. In O(bodies + local loops). The gaps
 * become `offset` (position rows; NULL: zero, as at first). */
int mbsri_tree_start_find(mbsri_tree_start *s, double t, const double *offset, double *q, double *u,
                          double *udot, double *lambda, const mbsr_consistent_opt *opt,
                          mbsr_consistent_info *info);

/* The same for any model, stiff rows by a copy of it in which they are rigid (stiff_tree_start.c).
 * q and u are not as they were after a failure. */
int mbsri_stiff_tree_start(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                           double *udot, double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info);

#endif
