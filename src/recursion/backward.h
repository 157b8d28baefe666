/* The backward recursion (17): articulated-body inertia Mbar and bias force fbar, leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BACKWARD_H
#define MBSRI_BACKWARD_H

#include "recursion/rank.h"

/* The stage: both halves below. */
int mbsri_backward(const mbsr_model *m, mbsr_data *d);

/* The steps for one body, whose successors are done. Its Mbar, W and fbar hold M, 0 and f with what
 * the successors passed on: D, its rank, U and G; e and mu, whose -H^T mu goes to fbar of the
 * predecessor; Mbar^a and its errors, which go to the predecessor's Mbar and W. Joints of a group
 * (group.h) are eliminated with its head. way, by_pivots: as in rank.h, of the head. */
int mbsri_eliminate_joint(const mbsr_model *m, mbsr_data *d, int i, mbsri_rank_way way);
void mbsri_load_joint(const mbsr_model *m, mbsr_data *d, int i);
void mbsri_pass_masses(const mbsr_model *m, mbsr_data *d, int i, bool by_pivots);

/* After it: again, with the groups of joints taken apart that are not coupled (group.h), as the
 * Newton systems eliminate them; the stage then counts as not run. */
int mbsri_backward_apart(const mbsr_model *m, mbsr_data *d);

/* Mbar, D and what follows from masses alone (needs mbsri_velocities); then fbar, e, mu from
 * forces. */
int mbsri_backward_masses(const mbsr_model *m, mbsr_data *d);
void mbsri_backward_loads(const mbsr_model *m, mbsr_data *d);

#endif
