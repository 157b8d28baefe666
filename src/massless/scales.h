/* Typical sizes of coordinates and of their rates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SCALES_H
#define MBSRI_SCALES_H

#include "massless/null_space.h"
#include "recursion/spans.h"

/* Length and rate typical of the tree at a state, w->size and w->rate_of_tree, and from the length
 * q_scale and span of every coordinate. The data is at mbsri_forces of the state.
 *
 * The length is the largest among the distances of origins from those of the predecessors, centres
 * of mass, radii of gyration, displacements and the points that stock force elements act at; the
 * rate the largest among the angular rates, velocities over the length, and the root of force over
 * mass and length. Coordinates count as far as recursion/spans.h says with that length. */
void mbsri_null_scales(mbsri_null_space *w, const double *q, const double *u);

/* u_scale by the rate; where that is next to nothing beside the `natural` one of springs and masses
 * (0: not known), as at rest, the natural one takes its place. */
void mbsri_null_rate_scales(mbsri_null_space *w, double natural);

/* Spans with the typical length. */
mbsri_spans mbsri_null_spans(const mbsri_null_space *w);

/* The largest rate of direction l, by typical sizes. */
double mbsri_direction_size(const mbsri_null_space *w, int l);

/* Size of the twist of body i among all (size_v), velocities over the typical length. */
double mbsri_twist_size(const mbsri_null_space *w, int i, const double *twist);

/* The least multiple of x that changes one of the coordinates y by its size and scale. */
double mbsri_unit_step(int n, const double *x, const double *y, const double *scale);

#endif
