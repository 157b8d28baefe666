/* The modes of the reduced body: normal and static ones, diagonal in K and M.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_BASIS_H
#define MBSRI_FE_BASIS_H

#include "fe/modes.h"

typedef struct mbsri_fe_basis {
    int count;
    double *Z;     /* n x count, seen from the root; mass 1, or K = 1 without mass; by frequency */
    double *mu;    /* count: 1 / omega^2, 0: there is no mass at all */
    int *massless; /* count */
    double cutoff; /* rad/s: what is above it is massless */
    int loads, dependent;
} mbsri_fe_basis;

/* From the normal modes, which are used up. */
int mbsri_fe_make_basis(mbsri_fe_statics *statics, const mbsri_fe_modes *modes,
                        mbsri_fe_basis *basis);

#endif
