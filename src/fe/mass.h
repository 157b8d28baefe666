/* Where the mass is: its definiteness, and fields integrated over it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_MASS_H
#define MBSRI_FE_MASS_H

#include "fe/body.h"

typedef struct mbsri_fe_mass {
    bool solid;      /* M = Ms x 1 */
    mbsri_sparse Ms; /* solid: nodes x nodes */
    double *lumped; /* nodes x 10: mass of a node, and 3 x 3 roots of the distribution of mass about
                       it, n_l in columns with sum n_l n_l^T = int d d^T */
} mbsri_fe_mass;

/* Finds out, and refuses M that is indefinite or differs along the axes. */
int mbsri_fe_mass_make(const mbsri_fe_body *body, mbsr_fe_solver solver, mbsri_fe_mass *mass);

/* G ((4 + 3 c) x (4 + 3 c)) = int g g^T with g = (1, x, Phi_1, ..., Phi_c), the fields of modes Z
 * (n x c). */
int mbsri_fe_gram(const mbsri_fe_body *body, const mbsri_fe_mass *mass, int c, const double *Z,
                  double *G);

#endif
