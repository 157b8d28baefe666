/* Slopes at the points of a table.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "tables/slopes.h"

#include <math.h>
#include <stddef.h>

static double width(const double *x, int k)
{
    return x[k + 1] - x[k];
}

/* Secant of piece k. */
static double secant(int stride, const double *x, const double *v, int k)
{
    const ptrdiff_t at = (ptrdiff_t)k * stride;
    return (v[at + stride] - v[at]) / width(x, k);
}

void mbsri_secants(int n, int stride, const double *x, const double *v, double *m)
{
    for (int k = 0; k < n; ++k)
        m[(ptrdiff_t)k * stride] = secant(stride, x, v, k < n - 1 ? k : n - 2);
}

/* ---- monotone: harmonic means of the secants on both sides ---- */

/* At an end: the parabola through three points, kept from turning. h, d of the piece there and of
 * the next one. */
static double end_slope(double h0, double h1, double d0, double d1)
{
    const double m = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if (m * d0 <= 0.0) return 0.0;
    return d0 * d1 <= 0.0 && fabs(m) > 3.0 * fabs(d0) ? 3.0 * d0 : m;
}

void mbsri_monotone_slopes(int n, int stride, const double *x, const double *v, double *m)
{
    if (n == 2) {
        m[0] = m[stride] = secant(stride, x, v, 0);
        return;
    }
    for (int k = 1; k < n - 1; ++k) {
        const double h0 = width(x, k - 1), h1 = width(x, k), d0 = secant(stride, x, v, k - 1),
                     d1 = secant(stride, x, v, k), w0 = 2.0 * h1 + h0, w1 = h1 + 2.0 * h0;
        m[(ptrdiff_t)k * stride] = (d0 > 0.0) == (d1 > 0.0) && d0 != 0.0 && d1 != 0.0
                                       ? (w0 + w1) / (w0 / d0 + w1 / d1)
                                       : 0.0;
    }
    const double first = secant(stride, x, v, 0), last = secant(stride, x, v, n - 2);
    m[0] = end_slope(width(x, 0), width(x, 1), first, secant(stride, x, v, 1));
    m[(ptrdiff_t)(n - 1) * stride] =
        end_slope(width(x, n - 2), width(x, n - 3), last, secant(stride, x, v, n - 3));
}

/* ---- spline: the second derivative is continuous at inner points,
 *
 *   h_k m_(k-1) + 2 (h_(k-1) + h_k) m_k + h_(k-1) m_(k+1) = 3 (h_k d_(k-1) + h_(k-1) d_k),
 *
 * and the third at the first and the last of them, which with the row beside makes
 *
 *   h_1 m_0 + (h_0 + h_1) m_1 = ((h_0 + 2 (h_0 + h_1)) h_1 d_0 + h_0^2 d_1) / (h_0 + h_1) ---- */

static double end_row(double h0, double h1, double d0, double d1)
{
    return ((h0 + 2.0 * (h0 + h1)) * h1 * d0 + h0 * h0 * d1) / (h0 + h1);
}

/* The slope at an end of the parabola through three points. */
static double parabola(double h0, double h1, double d0, double d1)
{
    return d0 + h0 / (h0 + h1) * (d0 - d1);
}

void mbsri_spline_slopes(int n, int stride, const double *x, const double *v, double *m,
                         double *work)
{
    const double h0 = width(x, 0), d0 = secant(stride, x, v, 0);
    if (n == 2) {
        m[0] = m[stride] = d0;
        return;
    }
    const double h1 = width(x, 1), d1 = secant(stride, x, v, 1);
    if (n == 3) {
        m[0] = parabola(h0, h1, d0, d1);
        m[stride] = (h1 * d0 + h0 * d1) / (h0 + h1);
        m[2 * (ptrdiff_t)stride] = parabola(h1, h0, d1, d0);
        return;
    }
    /* work: what stands above the diagonal after division by it */
    m[0] = end_row(h0, h1, d0, d1) / h1;
    work[0] = (h0 + h1) / h1;
    for (int k = 1; k < n - 1; ++k) {
        const double a = width(x, k),
                     b = width(x, k - 1), *const before = m + (ptrdiff_t)(k - 1) * stride;
        const double pivot = 2.0 * (a + b) - a * work[k - 1],
                     right = 3.0 * (a * secant(stride, x, v, k - 1) + b * secant(stride, x, v, k));
        m[(ptrdiff_t)k * stride] = (right - a * *before) / pivot;
        work[k] = b / pivot;
    }
    const int e = n - 2;
    const double b0 = width(x, e), b1 = width(x, e - 1),
                 right = end_row(b0, b1, secant(stride, x, v, e), secant(stride, x, v, e - 1));
    double *const last = m + (ptrdiff_t)(n - 1) * stride;
    *last = (right - (b0 + b1) * last[-(ptrdiff_t)stride]) / (b1 - (b0 + b1) * work[e]);
    for (int k = n - 2; k >= 0; --k)
        m[(ptrdiff_t)k * stride] -= work[k] * m[(ptrdiff_t)(k + 1) * stride];
}
