/* A consistent start of a model with closures, front by front.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_TREE_START_H
#define MBSRI_LOOPS_TREE_START_H

#include "loops/dense.h"
#include "massless/closed_start.h"

/* Starts of a model that differ in their gaps; stiff rows count as rigid ones. */
typedef struct mbsri_tree_start {
    const mbsr_model *m;
    mbsr_data *d;
    mbsri_dense w;            /* closes loops, finds ranks */
    mbsri_closed_start start; /* where something moves no mass */
    bool ranked;              /* the rows that depend on others are known */
    const double *stiffness;  /* rows: of those that share what others bear, 0: of these; NULL: none
                                 does */
    double *borne, *tau;      /* rows, nu: what such rows do without being in the equations */
} mbsri_tree_start;

/* Takes memory from the model's allocator; to be closed after a failure too. */
int mbsri_tree_start_open(mbsri_tree_start *s, const mbsr_model *m, mbsr_data *d);
void mbsri_tree_start_close(mbsri_tree_start *s);

/* As mbsri_loops_dense_start, in O(bodies + local loops). The gaps become `offset` (position rows;
 * NULL: zero, as at first). *served is false where digits get lost on fronts, and motions or forces
 * with them; q is closed then. */
int mbsri_tree_start_find(mbsri_tree_start *s, double t, const double *offset, double *q, double *u,
                          double *udot, double *lambda, const mbsr_consistent_opt *opt,
                          mbsr_consistent_info *info, bool *served);

/* The same for any model, stiff rows by a copy of it in which they are rigid (stiff_tree_start.c).
 * *served is false, too, where a model with stiff rows has no such start, springs are taken as they
 * are, or share a force among rows that depend on each other; q and u are not as they were then. */
int mbsri_stiff_tree_start(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                           double *udot, double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info, bool *served);

#endif
