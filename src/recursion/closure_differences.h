/* Derivatives of closures by differences, where the table has none.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURE_DIFFERENCES_H
#define MBSRI_CLOSURE_DIFFERENCES_H

#include "recursion/closure_view.h"

/* The derivatives of the position rows with respect to V and u: C (rows x columns). Of `work`
 * columns + rows numbers. */
int mbsri_closure_slopes(const mbsr_model *m, const mbsri_closure *c,
                         const mbsri_closure_view *view, double *work, double *C);

/* That of the position rows with respect to time, into the first of `rate`; likewise. */
int mbsri_closure_drift(const mbsr_model *m, const mbsri_closure *c, const mbsri_closure_view *view,
                        double *work, double *rate);

/* The time derivative of the velocity rows where the accelerations of bodies and joints are zero.
 */
int mbsri_closure_curvature(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                            const mbsri_closure_view *view, double *bias);

/* Derivatives along displacements of the bodies and of their joints, the columns of C one by one,
 * where lambda (rows), V and u are held: S (columns x columns) of C^T lambda, slope (rows x
 * columns) of C (V, u) + g_t; zero along a root. At the velocities. work: columns (4 + rows). */
int mbsri_closure_tangent(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                          const double *lambda, double *work, double *S, double *slope);

/* Derivatives of the second time derivatives of the velocity rows, C a + (bias where accelerations
 * are zero), with the accelerations a (columns) held: along displacements and along V and u (rows x
 * columns each, zero along a root). At the velocities. work: columns (3 + rows). */
int mbsri_closure_acceleration_tangent(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                                       const double *a, double *work, double *by_place,
                                       double *by_rate);

#endif
