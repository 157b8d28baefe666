/* Displaced poses: see pose.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/pose.h"

#include "algebra/dense.h"
#include "algebra/space3.h"

#include <math.h>

/* dR = [x]x R */
static void rotation_change(const double *R, const double *dR, double x[3])
{
    double W[9];
    mbsri_multiply_transposed3(dR, R, W);
    x[0] = 0.5 * (W[5] - W[7]);
    x[1] = 0.5 * (W[6] - W[2]);
    x[2] = 0.5 * (W[1] - W[3]);
}

void mbsri_pose_change(mbsr_space space, int np, const double *p, const double *dp, double *x)
{
    if (!mbsri_turns(space)) {
        mbsri_copy((size_t)np, dp, x);
        return;
    }
    rotation_change(p + MBSR_POSE_R, dp + MBSR_POSE_R, x);
    mbsri_copy((size_t)np - MBSR_POSE_X, dp + MBSR_POSE_X, x + 3);
}

void mbsri_pose_unit(mbsr_space space, int k, const double *p, double *dp)
{
    if (!mbsri_turns(space)) {
        dp[k] = 1.0;
    } else if (k >= 3) {
        dp[MBSR_POSE_X + k - 3] = 1.0;
    } else {
        double axis[3] = {0.0, 0.0, 0.0};
        axis[k] = 1.0;
        for (int j = 0; j < 9; j += 3)
            mbsri_cross3(axis, p + MBSR_POSE_R + j, dp + MBSR_POSE_R + j);
    }
}

/* T = exp([x]x) R for a small x. */
static void turn_little(const double x[3], const double R[9], double T[9])
{
    const double angle = mbsri_norm3(x), half = 0.5 * angle;
    if (angle == 0.0) {
        mbsri_copy(9, R, T);
        return;
    }
    const double sine = sin(angle) / angle, ratio = sin(half) / half, versine = 0.5 * ratio * ratio;
    for (int j = 0; j < 9; j += 3) {
        double once[3], twice[3];
        mbsri_cross3(x, R + j, once);
        mbsri_cross3(x, once, twice);
        for (int k = 0; k < 3; ++k) T[j + k] = R[j + k] + sine * once[k] + versine * twice[k];
    }
}

void mbsri_pose_move(mbsr_space space, int np, const double *p, const double *dp, double h,
                     double *moved)
{
    if (!mbsri_turns(space)) {
        for (int k = 0; k < np; ++k) moved[k] = p[k] + h * dp[k];
        return;
    }
    double x[3];
    rotation_change(p + MBSR_POSE_R, dp + MBSR_POSE_R, x);
    for (int k = 0; k < 3; ++k) x[k] *= h;
    for (int k = MBSR_POSE_X; k < np; ++k) moved[k] = p[k] + h * dp[k];
    turn_little(x, p + MBSR_POSE_R, moved + MBSR_POSE_R);
}

void mbsri_pose_rate(mbsr_space space, int np, const double *p, const double *V, double *dp)
{
    if (!mbsri_turns(space)) {
        mbsri_copy((size_t)np, V, dp);
        return;
    }
    for (int j = 0; j < 9; j += 3) mbsri_cross3(V, p + MBSR_POSE_R + j, dp + MBSR_POSE_R + j);
    mbsri_copy((size_t)np - MBSR_POSE_X, V + 3, dp + MBSR_POSE_X);
}
