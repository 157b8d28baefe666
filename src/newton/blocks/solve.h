/* Solving with the elimination of factor.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SOLVE_H
#define MBSRI_SOLVE_H

#include "newton/blocks/record.h"

/* delta from r (NULL: zero; may be delta), and from a change of the forces f (size_v) and tau (nu)
 * at `load` (NULL: none). Leaves the bodies' perturbations in w->x. */
void mbsri_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta);

/* Its steps. Body i before anything is eliminated: r of its joint and the load on it, or nothing. */
void mbsri_tree_load(mbsr_newton *w, int i, const double *r, const double *load);
void mbsri_tree_clear_load(mbsr_newton *w, int i);

/* Leaves to root, joint i: what it hands on is added to the predecessor's in w->b and w->wbar. tau:
 * the changes of the joint forces in the order of the sweeps, or NULL. */
void mbsri_tree_reduce(mbsr_newton *w, int i, const double *tau);

/* Root to leaves, joint i: from the predecessor's perturbation in w->x to the body's. */
void mbsri_tree_substitute(mbsr_newton *w, int i, const double *tau, double *delta);

#endif
