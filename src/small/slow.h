/* Directions that are lightly damped: where the slow motion is.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_SLOW_H
#define MBSRI_SMALL_SLOW_H

#include "small/record.h"

/* Takes the start s->y, s->yp of the reduced model to the slow motion in such directions, and notes
 * their rates there for mbsri_small_settle. Needs the directions measured, and the factorisation of
 * mbsri_small_measure. */
int mbsri_small_slow(mbsr_small_masses *s);

/* In passes: their rates are those of the positions that they have later and earlier, from s->y,
 * s->yp, and these are taken to the slow motion with them. */
int mbsri_small_refine(mbsr_small_masses *s);

#endif
