/* Solutions that are refined with products.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_REFINE_H
#define MBSRI_FRONT_REFINE_H

#include "newton/front/front.h"

/* A system, or its transpose: x from the factors, false as mbsri_front_solve; A x; what is left of
 * r, at most, beside terms that are there in any model. */
typedef struct mbsri_front_way {
    bool (*solve)(mbsri_front *f, const double *r, double *x);
    void (*product)(const mbsri_linear *w, const double *x, mbsri_vectors *v, double *r);
    double (*share)(const mbsri_front *f, const double *r, const double *x, const double *left);
} mbsri_front_way;

/* x from r, not the same; where derivatives are kept, refined as long as that makes what is left
 * smaller. False: see mbsri_front_solve. */
bool mbsri_front_refine(mbsri_front *f, const mbsri_front_way *way, const double *r, double *x);

#endif
