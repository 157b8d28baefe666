/* Modal data of a basis.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_DATA_H
#define MBSRI_FE_DATA_H

#include "fe/basis.h"
#include "fe/mass.h"

/* Makes *flex, and the inertia of modes as the matrices have it: B (6 + count) x (6 + count) = [T
 * Z]^T M [T Z]. */
int mbsri_fe_make_data(const mbsri_fe_body *body, const mbsri_fe_mass *mass,
                       const mbsri_fe_basis *basis, mbsr_flex **flex, double *B);

#endif
