/* Stiffness, damping and inertia of directions, from the Newton matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_DIRECTIONS_H
#define MBSRI_SMALL_DIRECTIONS_H

#include "small/record.h"

/* Fills the numbers of all directions but their amplitudes, at the start; four factorisations. The
 * reduced twin's solver is left with the one for s->light_c, at which the slow motion does not
 * follow. */
int mbsri_small_measure(mbsr_small_masses *s);

/* offset of each candidate: what its force displaces at once, by that factorisation. */
int mbsri_small_displace(mbsr_small_masses *s);

/* Amplitudes of the fast motion from the start given. */
void mbsri_small_amplitudes(mbsr_small_masses *s);

#endif
