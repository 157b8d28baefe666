/* The backward recursion for masses in twofold precision, where double precision does not tell
 * which joint directions have inertia.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_EXACT_RECURSION_H
#define MBSRI_EXACT_RECURSION_H

#include "recursion/group.h"

/* Everything that mbsri_backward_masses writes. MBSR_NOT_FINITE, too, where products of twofold
 * numbers overflow and others do not. */
int mbsri_exact_masses(const mbsr_model *m, mbsr_data *d);

/* Whether masses were given with errors (mbsr_inertia.lost, matrices), at the positions of the
 * data. */
bool mbsri_given_with_errors(const mbsr_model *m, mbsr_data *d);

/* The joint-space mass matrix (nu x nu, by the caller's order) by composite inertias, each number
 * right to all its digits; overwrites Mbar. At the positions, and velocities where inertias by
 * function need them. */
void mbsri_exact_mass_matrix(const mbsr_model *m, mbsr_data *d, double *matrix);

/* Length of exact_work of the data. */
size_t mbsri_exact_room(const mbsr_model *m);

#endif
