/* Rotation vectors: see rotation.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/rotation.h"

#include "algebra/space3.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

/* From (w, v), or its negative, which is the same rotation: 2 atan2(|v|, w) v / |v| */
void mbsri_quaternion_vector(const double quaternion[4], double theta[3])
{
    const double sign = quaternion[0] < 0.0 ? -1.0 : 1.0, w = fabs(quaternion[0]);
    const double size = mbsri_norm3(quaternion + 1);
    const double factor = sign * (size > 0.0 ? 2.0 * atan2(size, w) / size : 2.0 / w);
    for (int k = 0; k < 3; ++k) theta[k] = factor * quaternion[1 + k];
}

bool mbsri_turn_is_half(const double quaternion[4], const double theta[3], const double *stiffness)
{
    static const double rounding = 8.0 * DBL_EPSILON, nothing = 1e-8;
    double counts = 0.0, most = 0.0;
    if (fabs(quaternion[0]) > rounding * mbsri_norm3(quaternion + 1)) return false;
    for (int k = 0; k < 3; ++k) {
        counts = fmax(counts, stiffness[k] * fabs(theta[k]));
        most = fmax(most, stiffness[k]);
    }
    return counts > nothing * most;
}

double mbsri_turn_side(const double theta[3])
{
    static const double quarter = 1.5707963267948966;
    int k = fabs(theta[1]) > fabs(theta[0]) ? 1 : 0;
    if (fabs(theta[2]) > fabs(theta[k])) k = 2;
    if (!(mbsri_norm3(theta) > quarter)) return 0.0;
    return theta[k] > 0.0 ? k + 1.0 : -k - 1.0;
}

/* s and its derivative with respect to |theta|^2; the series where the closed form cancels,
 * their errors are below 1e-16 there and 1e-13. */
double mbsri_turn_factor(double square, double *slope)
{
    const double half = 0.5 * sqrt(square);
    if (square < 0.01) {
        if (slope) {
            *slope = 1.0 / 720.0 +
                     square * (1.0 / 15120.0 + square * (1.0 / 403200.0 + square / 11975040.0));
        }
        return 1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square / 1209600.0));
    }
    const double cotangent = cos(half) / sin(half), s = (1.0 - half * cotangent) / square;
    /* with h = |theta| / 2:  d(h cot h)/dh = cot h - h (1 + cot^2 h),  dh/d|theta|^2 = 1/(8 h) */
    if (slope) {
        *slope = ((half * (1.0 + cotangent * cotangent) - cotangent) / (8.0 * half) - s) / square;
    }
    return s;
}

void mbsri_unturn(const double theta[3], const double x[3], double y[3])
{
    const double s = mbsri_turn_factor(mbsri_dot3(theta, theta), NULL);
    double once[3], twice[3];
    mbsri_cross3(theta, x, once);
    mbsri_cross3(theta, once, twice);
    for (int k = 0; k < 3; ++k) y[k] = x[k] + 0.5 * once[k] + s * twice[k];
}

/* dy for dtheta and dx, y = J^-T(theta) x */
static void unturn_slope(const double theta[3], const double dtheta[3], const double x[3],
                         const double dx[3], double dy[3])
{
    double slope, once[3], twice[3], donce[3], dtwice[3];
    const double s = mbsri_turn_factor(mbsri_dot3(theta, theta), &slope),
                 ds = 2.0 * slope * mbsri_dot3(theta, dtheta);
    mbsri_cross3(theta, x, once);
    mbsri_cross3(theta, once, twice);
    mbsri_cross3(dtheta, x, donce);
    mbsri_add_cross3(theta, dx, donce);
    mbsri_cross3(dtheta, once, dtwice);
    mbsri_add_cross3(theta, donce, dtwice);
    for (int k = 0; k < 3; ++k) dy[k] = dx[k] + 0.5 * donce[k] + s * dtwice[k] + ds * twice[k];
}

void mbsri_turning_stiffness(const double theta[3], const double *stiffness, double T[9])
{
    double back[3], x[3];
    for (int k = 0; k < 3; ++k) {
        back[k] = -theta[k];
        x[k] = stiffness[k] * theta[k];
    }
    for (int j = 0; j < 3; ++j) {
        double phi[3] = {0.0}, dtheta[3], dx[3];
        phi[j] = 1.0;
        mbsri_unturn(back, phi, dtheta);
        for (int k = 0; k < 3; ++k) dx[k] = stiffness[k] * dtheta[k];
        unturn_slope(theta, dtheta, x, dx, T + 3 * j);
    }
}
