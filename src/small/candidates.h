/* Which masses are looked at, and which joint rates have their inertia.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_CANDIDATES_H
#define MBSRI_SMALL_CANDIDATES_H

#include "small/record.h"

/* Lists candidates of the options in s->candidate, allocated here; a status with s->error. */
int mbsri_small_candidates(mbsr_small_masses *s);

/* How many bodies of directions, and directions, the candidates have; with s->pushed and
 * s->direction it lists them. */
void mbsri_small_directions(mbsr_small_masses *s, int *pushes, int *directions);

#endif
