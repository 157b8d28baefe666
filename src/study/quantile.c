/* Quantiles of distributions: see quantile.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "study/quantile.h"

#include <math.h>

/* By Newton's method for log Phi, which is concave: from the second step on it comes from the left.
 */
double mbsri_normal_quantile(double z)
{
    const double small = z < 0.5 ? z : 1.0 - z, wanted = log(small), root = sqrt(0.5);
    double x = -sqrt(-2.0 * wanted);
    for (int k = 0; k < 40; ++k) {
        const double Phi = 0.5 * erfc(-x * root), phi = 0.3989422804014327 * exp(-0.5 * x * x),
                     change = (wanted - log(Phi)) * Phi / phi;
        x += change;
        if (fabs(change) <= 1e-15 * (1.0 + fabs(x))) break;
    }
    return z < 0.5 ? x : -x;
}

/* Abramowitz and Stegun 26.7.5; n = 1, 2 in closed form. */
double mbsri_student_quantile(double z, int n)
{
    if (n == 1) return tan(3.141592653589793 * (z - 0.5));
    if (n == 2) return (2.0 * z - 1.0) * sqrt(2.0 / (4.0 * z * (1.0 - z)));
    const double x = mbsri_normal_quantile(z), y = x * x, k = 1.0 / n, g1 = (y + 1.0) / 4.0,
                 g2 = ((5.0 * y + 16.0) * y + 3.0) / 96.0,
                 g3 = (((3.0 * y + 19.0) * y + 17.0) * y - 15.0) / 384.0,
                 g4 = ((((79.0 * y + 776.0) * y + 1482.0) * y - 1920.0) * y - 945.0) / 92160.0;
    return x * (1.0 + k * (g1 + k * (g2 + k * (g3 + k * g4))));
}
