/* How well loops hold the directions of a tree that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_STRETCH_H
#define MBSRI_LOOPS_STRETCH_H

#include "loops/ranking.h"

/* The smallest over the largest singular value of the rows that are not left out (scale: to what
 * each is compared), on the directions without mass that they hold: *stretch, 1 where there are
 * none; *row: that which has most part in it, or -1. After mbsri_backward at rest and the
 * derivatives of the closures; overwrites Az and closure_w. In time with the bodies that
 * the directions move; directions that rows couple are taken together in dense matrices. */
int mbsri_loops_stretch(mbsri_ranking *w, const double *scale, double *stretch, int *row);

#endif
