/* Mass matrix and gyroscopic force of a flexible body in a pose (R, r, s), and their derivatives.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * V = (omega, v, s'), world axes; d = 6 + n. For M and Ct0, Cr see flex.h. */
#ifndef MBSRI_FLEX_MASS_H
#define MBSRI_FLEX_MASS_H

#include "flexible/data.h"

/* M (d x d) along the axes of R (3 x 3), which may be the unit matrix. */
void mbsri_flex_mass(const mbsr_flex *f, const double R[9], const double *s, double *M);

/* Gyroscopic force h (d) of M A + h; M of the same pose. */
void mbsri_flex_gyration(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                         const double *M, double *h);

/* M' along V. */
void mbsri_flex_mass_rate(const mbsr_flex *f, const double R[9], const double *s, const double *V,
                          const double *M, double *Mdot);

/* E_a = int rho Phi_a^T of all shapes along the body's axes, 3 x 3 one after the other, from s^
 * (shapes); and their rates from s^'. */
void mbsri_flex_all_E(const mbsr_flex *f, const double *all, double *E);
void mbsri_flex_all_E_rates(const mbsr_flex *f, const double *all_rate, double *E);

#endif
