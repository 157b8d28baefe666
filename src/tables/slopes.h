/* Slopes at the points of a table.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_TABLE_SLOPES_H
#define MBSRI_TABLE_SLOPES_H

/* Slopes of the lines that begin at each of n >= 2 points; at the last, of that which ends there.
 * Shapes as below. */
void mbsri_secants(int n, int stride, const double *x, const double *v, double *m);

/* m[k * stride] of n >= 2 values v[k * stride] at x[k]. */
void mbsri_monotone_slopes(int n, int stride, const double *x, const double *v, double *m);

/* The same; work: n numbers. */
void mbsri_spline_slopes(int n, int stride, const double *x, const double *v, double *m,
                         double *work);

#endif
