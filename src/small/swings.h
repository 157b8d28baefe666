/* The fast motion along a run, and the steps that masses cost.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_SWINGS_H
#define MBSRI_SMALL_SWINGS_H

#include "small/record.h"

/* At the start, with the forces and the amplitudes there. */
int mbsri_small_swings_begin(mbsr_small_masses *s);

/* To the next state of a run, with the forces there. */
int mbsri_small_swings_follow(mbsr_small_masses *s, double t, const double *y);

/* Whether a direction counts as fast beside the slow motion. */
bool mbsri_small_is_fast(const mbsr_small_direction *x);

/* An amplitude of direction l in tolerances of the integrator. */
double mbsri_small_swing_size(const mbsr_small_masses *s, int l, double amplitude);

/* Steps of BDF of order 5 through a swing of a direction that goes from the size `first` to `last`
 * in a time, or dies out earlier. */
double mbsri_small_swing_steps(const mbsr_small_direction *x, double first, double last,
                               double time);

#endif
