/* Bodies that force elements tie across the tree, in the elimination.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An element between bodies that are no neighbours makes the forces on body i depend on the motion of body j,
 *
 *   y_i = P_i x_i + sum over j of A_ij x_j + b_i
 *
 * When joint i is eliminated, x_i = X x_pi + (what x_j of all j it is tied to move), and this stands in
 * A_pj, A_jp and A_jk of the predecessor p and of the others: the bodies tied to i, and p, become tied
 * among each other. As in sparse elimination of any kind the pattern of ties depends on the model alone. What a column of
 * forces on i becomes and how i moves is asked of the elimination, whichever it is: the steps of a solution
 * with that load, and with that motion of p.
 *
 * Bodies count x and y as their elimination does: blocks pose and V, and (m, sigma, mu); those in vector code
 * groups of four (newton/blocks/swept.h). */
#ifndef MBSRI_LINKED_H
#define MBSRI_LINKED_H

#include "newton/blocks/record.h"

/* Numbers of a load on a body in vector code, with those of the recursion for L r_u; of L, p, N, F. */
enum { MBSRI_TIED_LOAD = 32, MBSRI_TIED_SUMS = 16 };

/* Whether bodies are tied in the elimination: `forced` wherever that serves, else if it costs less than a correction
 * of low rank. False: there is no memory. */
bool mbsri_links_create(mbsr_newton *w, bool forced);
void mbsri_links_destroy(mbsr_newton *w);

/* The body that is eliminated after k others. */
static inline int mbsri_links_turn(const mbsr_newton *w, int k)
{
    return w->linked ? w->links.order[k] : w->model->bodies - k;
}

/* ---- factoring ---- */

/* Before the first joint; a status. passes: of a tree with bodies in vector code, or NULL. */
int mbsri_links_open(mbsr_newton *w, mbsr_data *d, const mbsri_link_passes *passes);

/* What bodies that were eliminated before add to y over x of body i, columns of mbsri_links_stride numbers. */
double *mbsri_links_own(const mbsr_newton *w, int i);
int mbsri_links_stride(const mbsr_newton *w, int i);

/* Joint i, when it is eliminated. */
void mbsri_links_pass(mbsr_newton *w, int i);

/* ---- solving ---- */

/* Before the first joint, when b of blocks is cleared. */
void mbsri_links_clear(mbsr_newton *w);

/* Leaves to root, joint i when it is done: what its part of the solution does to the bodies it is tied to. */
void mbsri_links_reduce(mbsr_newton *w, int i, const double *r);

/* Root to leaves, joint i before it moves: what these do to it. */
void mbsri_links_substitute(mbsr_newton *w, int i);

/* Of a body in vector code: the load on it; where its motion goes. */
double *mbsri_links_load(const mbsr_newton *w, int i);
double *mbsri_links_motion(const mbsr_newton *w, int i);

#endif
