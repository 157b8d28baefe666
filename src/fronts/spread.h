/* The diagonal of the inverse of the equations of motion with loops.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The matrix is K = L B L^T, and the way back, x = L^-T y, goes from the root to the leaves. So
 * K^-1 = L^-T B^-1 L^-1 is what variances of y, D^+ at joints and -F^-1 of pivots, independent of
 * each other, become on that way: a front needs those of the unknowns that its step has left, which
 * the front that takes these has (Takahashi 1973 for sparse matrices in general). */
#ifndef MBSRI_FRONTS_SPREAD_H
#define MBSRI_FRONTS_SPREAD_H

#include "fronts/fronts.h"

/* After mbsri_fronts_factor: the entries of joint rates into w->e (nu, in the order of the sweeps),
 * and of rows less their signs into `row` (rows, 0 in those left out; NULL: not wanted). Overwrites
 * s and v. False: no memory. */
bool mbsri_fronts_spread(mbsri_fronts *w, double *row);

#endif
