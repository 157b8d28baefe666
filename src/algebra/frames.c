/* Frames and rotations in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/frames.h"

#include "algebra/numbers.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, none[9] = {0.0};

static mbsr_frame frame_from(const double x[3], const double R[9])
{
    mbsr_frame frame = {.x = {0.0, 0.0, 0.0}};
    if (x) memcpy(frame.x, x, sizeof frame.x);
    memcpy(frame.R, R, sizeof frame.R);
    return frame;
}

mbsr_frame mbsr_frame_identity(void)
{
    return frame_from(NULL, unit);
}

mbsr_frame mbsr_frame_at(double x, double y, double z)
{
    const double origin[3] = {x, y, z};
    return frame_from(origin, unit);
}

mbsr_frame mbsr_frame_rotated(const double x[3], const double axis[3], double angle)
{
    double n[3];
    if (!axis || !mbsri_direction3(axis, n)) return frame_from(x, none);
    const double c = cos(0.5 * angle), s = sin(0.5 * angle);
    const double quaternion[4] = {c, s * n[0], s * n[1], s * n[2]};
    return mbsr_frame_quaternion(x, quaternion);
}

mbsr_frame mbsr_frame_quaternion(const double x[3], const double quaternion[4])
{
    double R[9];
    if (!quaternion) return frame_from(x, none);
    mbsr_quaternion_rotation(quaternion, R);
    return frame_from(x, R);
}

/* x axis perpendicular to z and to the coordinate axis that is farthest from z. */
mbsr_frame mbsr_frame_along(const double x[3], const double z[3])
{
    double R[9], helper[3] = {0.0, 0.0, 0.0};
    int least = 0;
    if (!z || !mbsri_direction3(z, R + 6)) return frame_from(x, none);
    for (int k = 1; k < 3; ++k) {
        if (fabs(z[k]) < fabs(z[least])) least = k;
    }
    helper[least] = 1.0;
    mbsri_cross3(helper, R + 6, R);
    const double size = mbsri_norm3(R);
    for (int k = 0; k < 3; ++k) R[k] /= size;
    mbsri_cross3(R + 6, R, R + 3);
    return frame_from(x, R);
}

mbsr_frame mbsr_frame_product(const mbsr_frame *a, const mbsr_frame *b)
{
    const mbsr_frame same = mbsr_frame_identity();
    mbsr_frame c;
    if (!a) a = &same;
    if (!b) b = &same;
    mbsri_rotate3(a->R, b->x, c.x);
    mbsri_add3(1.0, a->x, c.x);
    mbsri_multiply3(a->R, b->R, c.R);
    return c;
}

mbsr_frame mbsr_frame_inverse(const mbsr_frame *a)
{
    mbsr_frame c;
    if (!a) return mbsr_frame_identity();
    mbsri_unrotate3(a->R, a->x, c.x);
    for (int k = 0; k < 3; ++k) c.x[k] = -c.x[k];
    mbsri_multiply_transposed3(unit, a->R, c.R);
    return c;
}

/* R = 1 + 2 (w [v]x + [v]x^2) / |q|^2 */
int mbsr_quaternion_rotation(const double quaternion[4], double R[9])
{
    double n[4], X[9];
    if (!R) return MBSR_ERR_NULL;
    if (!quaternion || !mbsri_scale4(quaternion, n)) {
        memcpy(R, none, sizeof none);
        return MBSR_ZERO_QUATERNION;
    }
    const double w = n[0], *v = n + 1, size = mbsri_dot3(v, v), s = 2.0 / (w * w + size);
    mbsri_cross_matrix3(v, X);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) R[3 * j + k] = s * (w * X[3 * j + k] + v[j] * v[k]);
        R[4 * j] += 1.0 - s * size;
    }
    return mbsri_finite(9, R) ? MBSR_OK : MBSR_NOT_FINITE;
}

/* From the largest of 4 w^2, 4 x^2, 4 y^2, 4 z^2, so that nothing is lost to cancellation. */
int mbsr_rotation_quaternion(const double R[9], double quaternion[4])
{
    if (!R || !quaternion) return MBSR_ERR_NULL;
    const double trace = R[0] + R[4] + R[8];
    int largest = -1;
    double most = trace;
    for (int k = 0; k < 3; ++k) {
        if (R[4 * k] > most) most = R[4 * k], largest = k;
    }
    double q[4];
    if (largest < 0) {
        q[0] = 1.0 + trace;
        q[1] = R[5] - R[7];
        q[2] = R[6] - R[2];
        q[3] = R[1] - R[3];
    } else {
        const int a = largest, b = (a + 1) % 3, c = (a + 2) % 3;
        q[0] = R[3 * b + c] - R[3 * c + b];
        q[1 + a] = 1.0 + R[4 * a] - R[4 * b] - R[4 * c];
        q[1 + b] = R[3 * a + b] + R[3 * b + a];
        q[1 + c] = R[3 * a + c] + R[3 * c + a];
    }
    const double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double sign = q[0] < 0.0 ? -1.0 / size : 1.0 / size;
    for (int k = 0; k < 4; ++k) quaternion[k] = sign * q[k];
    return mbsri_finite(4, quaternion) ? MBSR_OK : MBSR_NOT_FINITE;
}

double mbsri_frame_defect(const double R[9])
{
    double defect = 0.0, cross[3];
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
            const double entry = mbsri_dot3(R + 3 * j, R + 3 * k) - (j == k ? 1.0 : 0.0);
            if (!isfinite(entry)) return INFINITY;
            defect = fmax(defect, fabs(entry));
        }
    }
    mbsri_cross3(R, R + 3, cross);
    return mbsri_dot3(cross, R + 6) > 0.0 ? defect : INFINITY;
}

/* R <- R (3 - R^T R) / 2 doubles the digits to which R is orthonormal. */
void mbsri_store_frame(const mbsr_frame *frame, double param[12])
{
    const mbsr_frame identity = mbsr_frame_identity();
    double *R = param + 3;
    if (!frame) frame = &identity;
    memcpy(param, frame->x, sizeof frame->x);
    memcpy(R, frame->R, sizeof frame->R);
    for (int pass = 0; pass < 2 && mbsri_frame_defect(R) < 1e-6; ++pass) {
        double T[9], product[9];
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k)
                T[3 * j + k] = (j == k ? 1.5 : 0.0) - 0.5 * mbsri_dot3(R + 3 * j, R + 3 * k);
        }
        mbsri_multiply3(R, T, product);
        memcpy(R, product, sizeof product);
    }
}
