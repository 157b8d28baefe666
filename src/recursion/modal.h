/* Joints of flexible bodies in the recursion: a mount (joints/flexible.c) has
 *
 *   J = [ Jt ; -1 ],   H = [ Ht ; 0 ]
 *
 * with six rows above, so that products with them take n^2 and not n^3 numbers for n modes. Of
 * other joints J and H may have any entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MODAL_H
#define MBSRI_MODAL_H

#include "algebra/dense.h"
#include "model/record.h"

enum { MBSRI_FRAME_ROWS = 6 };

/* Leading rows of J, H that are not those of -1 and 0. */
static inline int mbsri_upper_rows(const mbsri_body *b)
{
    return b->flexible.modal ? MBSRI_FRAME_ROWS : b->d;
}

/* y (d) = A times column k of J, A d x d */
static inline void mbsri_along_rate(const mbsri_body *b, const double *A, const double *J, int k,
                                    double *y)
{
    const int d = b->d, rows = mbsri_upper_rows(b);
    mbsri_zero((size_t)d, y);
    if (!b->flexible.upright) mbsri_ax_often(d, rows, 1.0, A, J + (size_t)k * (size_t)d, y);
    if (!b->flexible.modal) return;
    const double *column = A + (size_t)(rows + k) * (size_t)d;
    for (int l = 0; l < d; ++l) y[l] -= column[l];
}

/* Column k of J times y (d). */
static inline double mbsri_rate_of(const mbsri_body *b, const double *J, int k, const double *y)
{
    const int rows = mbsri_upper_rows(b);
    if (b->flexible.upright) return -y[rows + k];
    const double *column = J + (size_t)k * (size_t)b->d,
                 sum = rows == 6 ? mbsri_dot_six(column, y) : mbsri_dot(rows, column, y);
    return b->flexible.modal ? sum - y[rows + k] : sum;
}

/* x (n) += J^T y (d);  and J'^T y */
static inline void mbsri_add_rates(const mbsri_body *b, const double *J, const double *y, double *x)
{
    if (!b->flexible.modal) {
        mbsri_atx_often(b->d, b->n, 1.0, J, y, x);
        return;
    }
    for (int k = 0; k < b->n; ++k) x[k] += mbsri_rate_of(b, J, k, y);
}

static inline void mbsri_add_rates_dot(const mbsri_body *b, const double *Jdot, const double *y,
                                       double *x)
{
    if (b->flexible.upright) return;
    const int rows = mbsri_upper_rows(b);
    for (int k = 0; k < b->n; ++k) x[k] += mbsri_dot(rows, Jdot + (size_t)k * (size_t)b->d, y);
}

/* y (d) += s J u (n) */
static inline void mbsri_add_along(const mbsri_body *b, double s, const double *J, const double *u,
                                   double *y)
{
    if (!b->flexible.modal) {
        mbsri_ax_often(b->d, b->n, s, J, u, y);
        return;
    }
    for (int k = 0; k < b->n; ++k) {
        if (!b->flexible.upright)
            mbsri_ax(MBSRI_FRAME_ROWS, 1, s * u[k], J + k * b->d, &(double){1.0}, y);
        y[MBSRI_FRAME_ROWS + k] -= s * u[k];
    }
}

/* (Column k of J)^T A (column k of J) of a symmetric A; work: d. */
static inline double mbsri_along_itself(const mbsri_body *b, const double *A, const double *J,
                                        int k, double *work)
{
    if (b->flexible.upright) return A[(size_t)(MBSRI_FRAME_ROWS + k) * (size_t)(b->d + 1)];
    mbsri_along_rate(b, A, J, k, work);
    return mbsri_rate_of(b, J, k, work);
}

/* B (r x c) = the first r rows of A (d x c) */
static inline void mbsri_upper(int r, int d, int c, const double *A, double *B)
{
    for (int k = 0; k < c; ++k)
        mbsri_copy((size_t)r, A + (size_t)k * (size_t)d, B + (size_t)k * (size_t)r);
}

#endif
