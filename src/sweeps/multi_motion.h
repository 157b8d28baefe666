/* Kinematics of joints of several axes, of prescribed ones, or with a quaternion, in the vectorised
 * sweeps. The joint's own functions move them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_MULTI_MOTION_H
#define MBSRI_SWEEPS_MULTI_MOTION_H

#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "joints/chain.h"
#include "sweeps/lane.h"
#include "sweeps/multi_arguments.h"

#include <string.h>

/* A FREE body: S = 1, and c = 0. */
static int free_kinematics(const mbsri_sweep_run *run, int i, bool velocity)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_joint *seat = run->tree->joint + b->multi;
    const double *A = seat->chain.param + MBSRI_A, *q = run->q + b->q, *u = run->u + b->u;
    mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const v4 none = splat(0.0);
    double R[9], scaled[4];
    if (!mbsri_scale4(q, scaled)) return MBSR_ZERO_QUATERNION;
    mbsr_quaternion_rotation(scaled, R);
    for (int k = 0; k < 3; ++k) {
        store(s->R + 4 * k, (v4){R[3 * k], R[3 * k + 1], R[3 * k + 2], 0.0});
        store(multi->S[k], (v4){k == 0, k == 1, k == 2, 0.0});
        store(multi->S[k] + 4, none);
        store(multi->S[3 + k], none);
        store(multi->S[3 + k] + 4, (v4){k == 0, k == 1, k == 2, 0.0});
    }
    store(s->rho, (v4){A[0] + q[4], A[1] + q[5], A[2] + q[6], 0.0});
    store(s->omega, (v4){u[0], u[1], u[2], 0.0});
    store(s->A_w, none);
    store(s->A_v, none);
    store(multi->drive, none);
    store(multi->drive + 4, none);
    if (!velocity) return MBSR_OK;
    store(s->v, (v4){u[3], u[4], u[5], 0.0});
    memset(multi->Sdot, 0, sizeof multi->Sdot);
    return MBSR_OK;
}

static int multi_kinematics(const mbsri_sweep_run *run, int i, bool velocity)
{
    if (run->tree->body[i].flags & MBSRI_FREE) return free_kinematics(run, i, velocity);
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *pred = run->state + b->parent;
    mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    double pose_pred[MBSR_POSE_SIZE], V_pred[6], pose[MBSR_POSE_SIZE];
    double S[36], Sdot[36], drive[6], bias[6], swing[3];
    const mbsr_joint_args args = mbsri_multi_arguments(run, i, pose_pred, V_pred);
    const int status = mbsri_chain_motion(&args, pose, S, drive, bias, velocity ? Sdot : NULL);
    if (status) return status;
    if (args.motion && (!mbsri_finite(12, pose) || !mbsri_finite(6, bias))) return MBSR_NOT_FINITE;
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = pose[MBSR_POSE_R + k];
    memcpy(s->rho, pose + MBSR_POSE_X, 3 * sizeof *s->rho);
    s->R[3] = s->R[7] = s->R[11] = s->rho[3] = s->A_w[3] = s->A_v[3] = 0.0;
    mbsri_spread_out(b->n, 1.0, S, multi->S);
    mbsri_spread_out(1, 1.0, drive, &multi->drive);
    /* omega_i = omega_pi + the angular part of S u + drive */
    memcpy(s->omega, pred->omega, sizeof s->omega);
    mbsri_add3(1.0, drive, s->omega);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], multi->S[k], s->omega);
    /* c = -kII + omega_pi x (omega_pi x (the predecessor's own origin)) */
    mbsri_cross3(pred->omega, V_pred + 3, swing);
    for (int k = 0; k < 3; ++k) {
        s->A_w[k] = bias[k];
        s->A_v[k] = swing[k] + bias[3 + k];
    }
    if (!velocity) return MBSR_OK;
    /* v_i = v_pi + omega_pi x rho + the linear part of S u + drive */
    mbsri_spread_out(b->n, 1.0, Sdot, multi->Sdot);
    mbsri_cross3(pred->omega, s->rho, s->v);
    mbsri_add3(1.0, pred->v, s->v);
    mbsri_add3(1.0, drive + 3, s->v);
    for (int k = 0; k < b->n; ++k) mbsri_add3(args.u[k], multi->S[k] + 4, s->v);
    s->v[3] = 0.0;
    return MBSR_OK;
}

#endif
