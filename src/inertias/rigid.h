/* Mass matrices of bodies in space (V = (omega, v), world axes), in a pose with rotation R.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RIGID_H
#define MBSRI_RIGID_H

#include <mbsrank/inertia.h>

/* M of a rigid body, 6 x 6. */
void mbsri_rigid_mass(const mbsr_inertia *inertia, const double R[9], double *M);

/* y += factor M x, with the digits that a small moment beside large ones needs: the tensor about
 * the centre of mass is applied in body axes and in twofold precision. */
void mbsri_rigid_times(const mbsr_inertia *inertia, const double R[9], double factor,
                       const double x[6], double y[6]);

/* Gyroscopic force of a rigid body: (omega x I omega, omega x (omega x m c)); M as above. */
void mbsri_rigid_gyration(const double *M, const double V[6], double h[6]);

/* M += diag(R, R) A diag(R, R)^T, A 6 x 6 symmetric in body axes. */
void mbsri_rotated_mass(const double *A, const double R[9], double *M);

/* h += the gyroscopic force of a matrix that turns with the body, by Kirchhoff's equations: with
 * (L, p) = M V,  (omega x L + v x p, omega x p) - M (0, omega x v). For a rigid body the same as
 * above, which is more exact at large v. */
void mbsri_rotated_gyration(const double *M, const double V[6], double h[6]);

/* Mdot = M' of a matrix that turns with the body: diag(omega x, omega x) M + its transpose. */
void mbsri_rotated_mass_rate(const double *M, const double omega[3], double *Mdot);

#endif
