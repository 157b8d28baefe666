/* Dependent shapes: how y_k = 1/2 s^T Y_k s follow the modes, s^ = (s, y).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   ds^ = Z ds,   Z = [1 ; s^T Y_k],   s^'' = Z s'' + (0, s'^T Y_k s') */
#ifndef MBSRI_FLEX_DEPENDENT_H
#define MBSRI_FLEX_DEPENDENT_H

#include "flexible/data.h"

/* x^T Y_k y */
double mbsri_dependent(const mbsr_flex *f, int k, const double *x, const double *y);

/* s^ (shapes) */
void mbsri_shapes(const mbsr_flex *f, const double *s, double *all);
/* Z ds (shapes) at s. */
void mbsri_shapes_along(const mbsr_flex *f, const double *s, const double *ds, double *along);

/* Z (modes x dependent): Y_k x in its columns; of x = s the rows of dependent shapes in Z, of
 * x = s' those of Z'. */
void mbsri_dependences(const mbsr_flex *f, const double *x, double *Z);

/* y (modes) += factor Z x (dependent) */
static inline void mbsri_dependences_add(const mbsr_flex *f, const double *Z, double factor,
                                         const double *x, double *y)
{
    for (int k = 0; k < f->r; ++k) {
        for (int a = 0; a < f->n; ++a) y[a] += factor * x[k] * Z[f->n * k + a];
    }
}

#endif
