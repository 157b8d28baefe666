/* Cubic finite elements of beams: shape functions, dofs and quadrature.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BEAM_ELEMENTS_H
#define MBSRI_BEAM_ELEMENTS_H

#include "algebra/dense.h"

enum { MBSRI_BEAM_POINTS = 5 };

/* Cubic shape functions of deflection, slope, deflection, slope at z in 0 .. 1 of an element of
 * length h: order 0 values, 1 slopes, 2 curvatures. */
static inline void mbsri_hermite(double z, double h, int order, double N[4])
{
    const double value[3][4] = {{1.0 - 3.0 * z * z + 2.0 * z * z * z,
                                 h * (z - 2.0 * z * z + z * z * z), 3.0 * z * z - 2.0 * z * z * z,
                                 h * (z * z * z - z * z)},
                                {(-6.0 * z + 6.0 * z * z) / h, 1.0 - 4.0 * z + 3.0 * z * z,
                                 (6.0 * z - 6.0 * z * z) / h, 3.0 * z * z - 2.0 * z},
                                {(-6.0 + 12.0 * z) / (h * h), (-4.0 + 6.0 * z) / h,
                                 (6.0 - 12.0 * z) / (h * h), (6.0 * z - 2.0) / h}};
    mbsri_copy(4, value[order], N);
}

/* Dofs of an element that bending about z and about y have, and their signs: w' = -rotation about
 * y. */
static const int mbsri_bends_z[4] = {1, 5, 7, 11}, mbsri_bends_y[4] = {2, 4, 8, 10};
static const double mbsri_bends_y_sign[4] = {1.0, -1.0, 1.0, -1.0};

/* Gauss's five points on 0 .. 1, in ascending order. */
static inline double mbsri_gauss(int k, double *weight)
{
    static const double x[3] = {0.0, 0.5384693101056831, 0.9061798459386640},
                        w[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    const int l = k < 2 ? 2 - k : k - 2;
    *weight = 0.5 * w[l];
    return 0.5 * (1.0 + (k < 2 ? -x[l] : x[l]));
}

#endif
