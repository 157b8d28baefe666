/* Neglected inertia forces, and loads as columns for the Newton matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_LOADS_H
#define MBSRI_SMALL_LOADS_H

#include "small/record.h"

/* force of each candidate, M A + h less the weight, of the mass that is neglected, at a state of
 * the reduced model's momentum form. */
int mbsri_small_forces(mbsr_small_masses *s, double t, const double *y, const double *yp);

/* rest and mean of each candidate at y: its force less the part by acceleration, and that part by
 * the mean acceleration over the time h since the last call (h = 0: that of mbsri_small_forces). */
int mbsri_small_split(mbsr_small_masses *s, double t, const double *y, double h);

/* impulse of each candidate: the neglected mass times (velocity of the start given - that at y). */
int mbsri_small_impulses(mbsr_small_masses *s, double t, const double *y);

/* F without any load at (t, y, yp), into s->F. */
int mbsri_small_unloaded(mbsr_small_masses *s, const mbsri_twin *twin, double t, const double *y,
                         const double *yp);

/* column (size): what n numbers x on a load add to F, at the state of mbsri_small_unloaded. */
int mbsri_small_column(mbsr_small_masses *s, const mbsri_twin *twin, double t, const double *y,
                       const double *yp, mbsri_small_load *load, const double *x, double *column);

#endif
