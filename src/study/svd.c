/* Singular values of a tall matrix: see svd.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "study/svd.h"

#include <math.h>

static double dot_columns(int m, const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < m; ++i) sum += a[i] * b[i];
    return sum;
}

static void rotate_columns(int m, double *a, double *b, double c, double s)
{
    for (int i = 0; i < m; ++i) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
}

static void swap_columns(int m, double *a, double *b)
{
    for (int i = 0; i < m; ++i) {
        const double x = a[i];
        a[i] = b[i];
        b[i] = x;
    }
}

/* Makes columns p and q orthogonal; 0: they were. */
static int turn_pair(int m, int n, double *A, double *V, int p, int q)
{
    double *a = A + p * m, *b = A + q * m;
    const double aa = dot_columns(m, a, a), bb = dot_columns(m, b, b), ab = dot_columns(m, a, b);
    if (fabs(ab) <= 1e-15 * sqrt(aa * bb) || ab == 0.0) return 0;
    const double zeta = (bb - aa) / (2.0 * ab),
                 t = copysign(1.0, zeta) / (fabs(zeta) + hypot(1.0, zeta)), c = 1.0 / hypot(1.0, t);
    rotate_columns(m, a, b, c, c * t);
    rotate_columns(n, V + p * n, V + q * n, c, c * t);
    return 1;
}

void mbsri_svd(int m, int n, double *A, double *V, double *s)
{
    enum { SWEEPS = 60 };
    for (int k = 0; k < n * n; ++k) V[k] = k % (n + 1) == 0;
    for (int sweep = 0, turned = 1; sweep < SWEEPS && turned; ++sweep) {
        turned = 0;
        for (int p = 0; p < n; ++p)
            for (int q = p + 1; q < n; ++q) turned += turn_pair(m, n, A, V, p, q);
    }
    for (int k = 0; k < n; ++k) s[k] = sqrt(dot_columns(m, A + k * m, A + k * m));
    for (int k = 0; k < n; ++k) {
        int largest = k;
        for (int l = k + 1; l < n; ++l)
            if (s[l] > s[largest]) largest = l;
        if (largest == k) continue;
        swap_columns(m, A + k * m, A + largest * m);
        swap_columns(n, V + k * n, V + largest * n);
        swap_columns(1, s + k, s + largest);
    }
}
