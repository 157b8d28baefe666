/* How a marker of a flexible body moves with it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The marker's twist is B V with the body's V = (omega, v, s'),
 *
 *   B = [ 1  0  G Psi ;  -[a]x  1  L Phi ],   a = R rho,   G = R T(psi),   L = R,   psi = Psi s
 *
 * with T of exp([psi]x)' = [T psi']x exp([psi]x). Dependent shapes (dependent.h) are in rho and
 * psi, and in Phi and Psi here and below as what they change with a mode at s, Phi + chi (Y s). So
 * B stands in (a, G, L) and s, its derivatives in those of them. */
#ifndef MBSRI_FLEXIBLE_MARKER_H
#define MBSRI_FLEXIBLE_MARKER_H

#include "flexible/data.h"
#include "flexible/rotation_vector.h"

typedef struct mbsri_flex_arm {
    double a[3], G[9], L[9];
} mbsri_flex_arm;

/* A marker in a state. What is not asked for is not set; vectors of modes are the caller's. */
typedef struct mbsri_flex_view {
    const mbsr_flex *flex;
    const mbsr_flex_marker *marker;
    bool rests; /* psi is 0, and rho constant */
    const double *s, *sdot, *ds, *dsdot;
    double R[9], rho[3], psi[3];
    mbsri_rotation_vector rotation; /* by psi */
    mbsri_flex_arm at;
    double omega[3], psid[3], u[3];  /* psi', (Phi s + ..)' */
    double psi_second[3], second[3]; /* chi s'^T Y s', of rotation and displacement */
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

/* How the marker turns in the body with a change of s: G dpsi. */
void mbsri_flex_turn(const mbsri_flex_view *view, const double *ds, double x[3]);

/* What of B a column is wanted of. */
typedef enum mbsri_flex_part {
    MBSRI_FLEX_AT,
    MBSRI_FLEX_RATE,
    MBSRI_FLEX_CHANGE,
    MBSRI_FLEX_RATE_CHANGE
} mbsri_flex_part;

/* The column of mode k of B or of a derivative: G Psi_k, L Phi_k. */
void mbsri_flex_column(const mbsri_flex_view *view, mbsri_flex_part part, int k, double angular[3],
                       double linear[3]);

#endif
