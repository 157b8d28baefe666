/* Dependent shapes: see dependent.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "flexible/dependent.h"

#include "algebra/dense.h"

static const double *matrix(const mbsr_flex *f, int k)
{
    return f->Y + (size_t)(f->n * f->n) * (size_t)k;
}

double mbsri_dependent(const mbsr_flex *f, int k, const double *x, const double *y)
{
    const double *Y = matrix(f, k);
    double sum = 0.0;
    for (int a = 0; a < f->n; ++a) sum += x[a] * mbsri_dot(f->n, Y + f->n * a, y);
    return sum;
}

void mbsri_shapes(const mbsr_flex *f, const double *s, double *all)
{
    mbsri_copy((size_t)f->n, s, all);
    for (int k = 0; k < f->r; ++k) all[f->n + k] = 0.5 * mbsri_dependent(f, k, s, s);
}

void mbsri_shapes_along(const mbsr_flex *f, const double *s, const double *ds, double *along)
{
    mbsri_copy((size_t)f->n, ds, along);
    for (int k = 0; k < f->r; ++k) along[f->n + k] = mbsri_dependent(f, k, s, ds);
}

void mbsri_dependences(const mbsr_flex *f, const double *x, double *Z)
{
    mbsri_zero((size_t)(f->n * f->r), Z);
    for (int k = 0; k < f->r; ++k) mbsri_ax(f->n, f->n, 1.0, matrix(f, k), x, Z + f->n * k);
}
