/* Of second moments A = int a b^T (3 x 3, column-major).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_AXIAL_H
#define MBSRI_AXIAL_H

/* int a x b */
static inline void mbsri_axial3(const double A[9], double x[3])
{
    x[0] = A[7] - A[5];
    x[1] = A[2] - A[6];
    x[2] = A[3] - A[1];
}

static inline double mbsri_trace3(const double A[9])
{
    return A[0] + A[4] + A[8];
}

/* I = tr(A) 1 - A */
static inline void mbsri_tensor3(const double A[9], double I[9])
{
    const double trace = mbsri_trace3(A);
    for (int k = 0; k < 9; ++k) I[k] = (k % 4 == 0 ? trace : 0.0) - A[k];
}

#endif
