/* The mass matrix of a body in a pose, and what goes with it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_INERTIA_H
#define MBSRI_INERTIA_H

#include "algebra/twofold.h"
#include "model/record.h"

/* M (d x d) in the pose p; zero for inertias by function. */
void mbsri_inertia_mass(const mbsri_body *b, const double *p, double *M);

/* y += factor M x, where M is that of the pose p; small moments of rigid bodies beside large ones
 * keep their digits. */
void mbsri_inertia_times(const mbsri_body *b, const double *p, const double *M, double factor,
                         const double *x, double *y);

/* The same in twofold precision, `exact`, at M (d x d). unsure (d): the diagonal matrix that M is
 * wrong by in units of the machine precision, because its entries were given rounded; else the body
 * is one whose points have moved by rounding. */
void mbsri_inertia_exact(const mbsri_body *b, const double *p, const double *M, mbsri_two *exact,
                         double *unsure);

/* M' along V, but for inertias by function. */
void mbsri_inertia_mass_rate(const mbsri_body *b, const double *p, const double *V, const double *M,
                             double *Mdot);

/* Gyroscopic force h (d); for inertias by function M, too. What the function returned. */
int mbsri_inertia_velocity(const mbsri_body *b, double t, const double *p, const double *V,
                           double *M, double *h);

#endif
