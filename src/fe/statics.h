/* Deflections of a body that nothing holds, by one factor of K.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_STATICS_H
#define MBSRI_FE_STATICS_H

#include "fe/body.h"
#include "fe/factor.h"

/* Loads f are balanced and deflections u seen from a reference,
 *
 *   f - L T^T f,    u - T L^T u,     T^T L = 1
 *
 * with L = C, the root's, or L = M T (T^T M T)^-1, inertia relief. */
typedef struct mbsri_fe_statics {
    const mbsri_fe_body *body;
    mbsri_factor *factor;
    mbsr_fe_solver solver;
    double *C, *relief; /* n x 6; relief NULL where the body has no mass to balance with */
    int solves;
    double *six; /* 6 x most columns */
    int most;    /* columns at a time */
} mbsri_fe_statics;

/* Factor of K, with errors for indefinite K and mechanisms; columns: at most, of what follows. */
int mbsri_fe_statics_make(const mbsri_fe_body *body, int columns, mbsri_fe_statics *statics);

/* U (n x c) <- U - T L^T U */
void mbsri_fe_see_from(mbsri_fe_statics *statics, const double *L, int c, double *U);

/* X (n x c), loads, become deflections, both by the reference L; false: no memory. */
bool mbsri_fe_deflect(mbsri_fe_statics *statics, const double *L, int c, double *X);

#endif
