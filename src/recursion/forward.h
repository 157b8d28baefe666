/* The forward recursion (18)-(25), root to leaves, that skips rank-deficient bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FORWARD_H
#define MBSRI_FORWARD_H

#include "recursion/group.h"

/* residual (25) for given u', both in the caller's order, at the state of mbsri_backward. */
void mbsri_forward(const mbsr_model *m, mbsr_data *d, const double *udot, double *residual);

/* u' (nu, the caller's order) becomes that of the equations of motion, residual (25) = 0, its null
 * components being kept; residual (nu): scratch. At the state of mbsri_backward. */
void mbsri_forward_with_null(const mbsr_model *m, mbsr_data *d, double *udot, double *residual);

/* All stages, then u' of a tree whose joint blocks are regular (the articulated-body algorithm);
 * data is left at mbsri_backward. */
int mbsri_forward_by_stages(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u, const double *tau, double *udot);

/* A0 of the bodies of a group, its load w = e - U^T H A0_pi and rate = D^+ w; n numbers each. */
void mbsri_known_part(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, double *w,
                      double *rate);

/* One step of the recursion that carries null rates z to the leaves,
 *   Az_i = -H_i Az_pi - J_i (z_i - D_i^+ J_i^T Mbar_i H_i Az_pi),
 * for accelerations, velocities or directions alike; Az and carries are in the data. The first
 * gives x = H Az_pi of body i, or false where that is zero. The second takes x of the head of a
 * group and z (n) where `own` is set, zero otherwise, leaves z - G^T x in it, and writes Az; x gets
 * lost. */
bool mbsri_null_below(const mbsr_model *m, const mbsr_data *d, int i, double *x);
void mbsri_null_pass(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, bool own, bool below,
                     double *x, double *z);

/* Az of body i, of whose group z - G^T x is known; x = H Az_pi, or NULL where that is zero. A body
 * whose own mass is regular stands still, unless that mass is so small beside others that the rank
 * decision took it for zero: then more is left of x + J z than rounding. */
void mbsri_null_velocity(const mbsr_model *m, mbsr_data *d, int i, const double *x,
                         const double *z);

#endif
