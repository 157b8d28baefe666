/* Basis vectors of the directions that move no mass, freed of each other's large rates.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A vector begins with a rate of some joint and continues to the leaves so that no mass moves.
 * Where a rod turns almost about its own axis, or a mass stands almost on one, that takes rates
 * many times as large, and several vectors may end in the same ones: they differ by what is small
 * in all of them, which C would hold squared. Therefore such a rate is left to one vector, and a
 * multiple of that is subtracted from the others. */
#ifndef MBSRI_SHORTEN_H
#define MBSRI_SHORTEN_H

#include "massless/null_space.h"

/* Changes directions, twists, q_rate, C, S and their errors at a state, and notes in
 * w->sums.weights what the vectors are made of now, so that gamma follows. Leaves all as it is, and
 * w->sums.on false, where no vector has grown. */
int mbsri_null_shorten(mbsri_null_space *w, double t, const double *q, const double *u);

#endif
