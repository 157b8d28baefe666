/* Steps of solving with the elimination of factor.c (newton/tree.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SOLVE_H
#define MBSRI_SOLVE_H

#include "newton/blocks/record.h"

/* Body i before anything is eliminated: r of its joint and the load on it, or nothing. */
void mbsri_tree_load(mbsr_newton *w, int i, const double *r, const double *load);
void mbsri_tree_clear_load(mbsr_newton *w, int i);

/* Leaves to root, joint i: what it hands on is added to the predecessor's in w->b and w->wbar. tau:
 * the changes of the joint forces in the order of the sweeps, or NULL. */
void mbsri_tree_reduce(mbsr_newton *w, int i, const double *tau);

/* Root to leaves, joint i: from the predecessor's perturbation in w->x to the body's. */
void mbsri_tree_substitute(mbsr_newton *w, int i, const double *tau, double *delta);

/* The same of the motions alone; of all members, if it is the head of a group. */
void mbsri_tree_move(mbsr_newton *w, int i);

#endif
