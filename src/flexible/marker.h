/* How a marker of a flexible body moves with it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The marker's twist is B V with the body's V = (omega, v, s'),
 *
 *   B = [ 1  0  G Psi ;  -[a]x  1  L Phi ],   a = R rho,   G = R T(psi),   L = R,   psi = Psi s
 *
 * with T of exp([psi]x)' = [T psi']x exp([psi]x). All of B stands in (a, G, L), its derivatives in
 * those of them. */
#ifndef MBSRI_FLEXIBLE_MARKER_H
#define MBSRI_FLEXIBLE_MARKER_H

#include "flexible/data.h"

typedef struct mbsri_flex_arm {
    double a[3], G[9], L[9];
} mbsri_flex_arm;

/* A marker in a state. What is not asked for is not set. */
typedef struct mbsri_flex_view {
    const mbsr_flex *flex;
    const mbsr_flex_marker *marker;
    double R[9], rho[3], psi[3];
    mbsri_flex_arm at;
    double omega[3], psid[3], u[3]; /* Psi s', Phi s' */
    mbsri_flex_arm rate;
    double bias[6]; /* B' V */
    double turn[3], dpsi[3], drho[3];
    mbsri_flex_arm change; /* of `at` */
    mbsri_flex_arm rate_change;
    double bias_change[6];
} mbsri_flex_view;

/* In these steps, each of which reads what those before have set.
 * The pose: R, s. */
void mbsri_flex_see(const mbsr_flex *flex, int marker, const double R[9], const double *s,
                    mbsri_flex_view *view);
/* Velocities: rate and bias. */
void mbsri_flex_see_rate(mbsri_flex_view *view, const double omega[3], const double *sdot);
/* A change of the pose, R by a small rotation `turn`, s by ds: change. */
void mbsri_flex_see_change(mbsri_flex_view *view, const double turn[3], const double *ds);
/* With a change of velocities besides: rate_change, bias_change. */
void mbsri_flex_see_rate_change(mbsri_flex_view *view, const double domega[3], const double *dsdot);

/* Axes of the marker in the body: exp([psi]x) R0. */
void mbsri_flex_axes(const mbsri_flex_view *view, double E[9]);

/* Columns of B of mode k, of (a, G, L) or of derivatives of these: G Psi_k, L Phi_k. */
void mbsri_flex_column(const mbsri_flex_view *view, const mbsri_flex_arm *arm, int k,
                       double angular[3], double linear[3]);

#endif
