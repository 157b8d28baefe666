/* Typical sizes of coordinates and of their rates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SCALES_H
#define MBSRI_SCALES_H

#include "massless/null_space.h"

/* Length and rate typical of the tree at a state, w->size and w->rate_of_tree, and from them
 * q_scale, u_scale and span of every coordinate. The data is at mbsri_forces of the state.
 *
 * The length is the largest among the distances of origins from those of the predecessors, centres
 * of mass, radii of gyration and displacements; the rate the largest among the angular rates,
 * velocities over the length, and the root of force over mass and length. Angles count as 1. What
 * nothing is known of counts as 1 as well. */
void mbsri_null_scales(mbsri_null_space *w, const double *q, const double *u);

/* Clears the directions and their twists of entries that are rounding beside the others, velocities
 * compared with angular rates times the typical length. */
void mbsri_null_clean(mbsri_null_space *w);

/* The least multiple of x that changes one of the coordinates y by its size and scale. */
double mbsri_unit_step(int n, const double *x, const double *y, const double *scale);

#endif
