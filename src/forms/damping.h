/* Whether the slopes of forces determine velocities, in spite of the errors in them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DAMPING_H
#define MBSRI_DAMPING_H

#include <stdbool.h>

/* A (n x n) becomes its inverse; E has the sizes of the errors of its entries, with which another
 * matrix could be in its place. False where one of those is singular, or nearly: then A is lost and
 * *weakest is a column that is, more than others, a combination of the rest. E is overwritten.
 * pivots: n ints, work: 6 n doubles. The verdict does not depend on the units of rows and columns.
 */
bool mbsri_invert_within(int n, double *A, double *E, int *pivots, double *work, int *weakest);

/* A slope from difference quotients with `count` steps a decade apart, the first being `share`
 * times `unit`; sizes are those of the forces differenced; every `stride`-th number of slopes and
 * sizes counts. Zero where none exceeds what rounding makes of a zero; *error is that of the slope.
 */
double mbsri_best_slope(int count, int stride, const double *slopes, const double *sizes,
                        double share, double unit, double *error);

#endif
