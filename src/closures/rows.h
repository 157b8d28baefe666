/* Rows that springs hold.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURES_ROWS_H
#define MBSRI_CLOSURES_ROWS_H

#include <mbsrank/closure.h>

/* Rigid closures, which stiffnesses make springs. A difference of coordinates, p_a - p_b = rest: */
mbsr_closure_def mbsri_closure_axis(int a, int b, int axis, double rest);
/* the length of the line between two points, |r_P - r_Q| - length; */
mbsr_closure_def mbsri_closure_length(int a, const double point_a[3], int b,
                                      const double point_b[3], double length);
/* of frame B's origin and rotation vector in A, along A's axes, the entries of `count` rows, angles
 * first; the first body is b, so that lambda acts on it along A's axes; */
mbsr_closure_def mbsri_closure_bushing(int a, const double A[12], int b, const double B[12],
                                       int count, const int *entry);
/* the same in the plane: T e, rows of T (count x 3, row by row), e = (x, y, angle). */
mbsr_closure_def mbsri_closure_planar_bushing(int a, const double A[3], int b, const double B[3],
                                              int count, const double *T);

/* Rows of a weld or ball with springs between two bodies that move are along the axes of the
 * second. */
void mbsri_stiff_axes(mbsr_closure_def *def);

#endif
