/* Joint-space mass matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MASS_MATRIX_H
#define MBSRI_MASS_MATRIX_H

#include "recursion/data.h"

/* matrix (nu x nu, by the caller's order) at the positions, inertias by function at the velocities.
 * The backward recursion must run again afterwards. */
void mbsri_mass_matrix(const mbsr_model *m, mbsr_data *d, double *matrix);

/* Its diagonal (nu) alone, in O(N): the inertia that each joint rate moves while the joints behind
 * it are locked. The backward recursion must run again afterwards. */
void mbsri_mass_diagonal(const mbsr_model *m, mbsr_data *d, double *diagonal);

/* result (nu) = the matrix times x (nu), both in the order of the sweeps; work: 2 size_v. */
void mbsri_mass_product(const mbsr_model *m, const mbsr_data *d, const double *x, double *result,
                        double *work);

#endif
