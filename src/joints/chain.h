/* What the stock joints in space share: chain.c moves them, spatial.c makes them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CHAIN_H
#define MBSRI_CHAIN_H

#include "algebra/frames.h"

#include <mbsrank/joint.h>

#include <stdbool.h>

/* param: frame A, frame B (origin, axes: 12 numbers each), then direction and pitch of each step.
 * */
enum { MBSRI_A = 0, MBSRI_B = 12, MBSRI_AXES = 24, MBSRI_AXIS_SIZE = 4 };

/* option[0]: number of steps; option[1 + k]: kind of step k, whether it is driven, and, from bit 4
 * on, the place of its first coordinate in u, or of a driven one in the motion's outputs. A
 * quaternion takes the first 4 places of q and the first 3 of u; what else the joint has stands
 * behind. */
enum {
    MBSRI_MAX_STEPS = 6,
    MBSRI_ROTATION = 1,
    MBSRI_TRANSLATION = 2,
    MBSRI_SCREW = 3,
    MBSRI_QUATERNION = 4,
    MBSRI_STEP_KIND = 7,
    MBSRI_DRIVEN = 8,
    MBSRI_PLACE_SHIFT = 4
};

/* The functions of the joint table. */
int mbsri_chain_position(const mbsr_joint_args *args, double *p);
int mbsri_chain_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI);

/* Both at once; H, J, kI as `jacobians` has them. */
int mbsri_chain_place(const mbsr_joint_args *args, double *p, double *H, double *J, double *kI);

int mbsri_chain_bias(const mbsr_joint_args *args, double *kII);
int mbsri_chain_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot);
int mbsri_chain_coordinate_rates(const mbsr_joint_args *args, double *qdot);
/* Pose, S = -J, -kI, -kII and S' in one pass; Sdot may be NULL. All are overwritten. */
int mbsri_chain_motion(const mbsr_joint_args *args, double *p, double *S, double *drive,
                       double *bias, double *Sdot);

/* Whether V = -J u with a constant J: translations along axes of a predecessor at rest shift the
 * body without turning what follows, and a ball whose middle is the body's origin turns it about
 * axes at rest. */
bool mbsri_chain_is_steady(mbsr_space pred_space, const double *param, const int *option);

/* An axis of a joint at a state, in the order of the steps; the three of a quaternion are one after
 * the other, along the axes of the frame before it. */
typedef struct mbsri_chain_axis {
    double S[6];               /* column of V = S u, about the body's origin */
    int place;                 /* of its rate among the joint's; -1: driven */
    bool ball;                 /* whether it is one of a quaternion's */
    double rate, acceleration; /* of a driven one */
} mbsri_chain_axis;

/* Into axes (MBSRI_MAX_STEPS). What a prescribed motion returned. */
int mbsri_chain_axes(const mbsr_joint_args *args, mbsri_chain_axis *axes, int *count);

/* The small turn, along the axes of the frame before it, of a rotation by the quaternion q that
 * changes by dq: 2 vec(dq n*) / n.q, n along q, which for dq = q' dt is u dt. */
void mbsri_chain_turn(const double q[4], const double n[4], const double dq[4], double turn[3]);

/* q' = 1/2 (0, u) q, along which the length of q stays. */
void mbsri_chain_quaternion_rate(const double q[4], const double u[3], double qdot[4]);

int mbsri_chain_normalise(const mbsr_joint_args *args, double *q);
int mbsri_chain_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                        double *dK, double *dH, double *dJ, double *dkI);
int mbsri_chain_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                             double *dKdot, double *dHdot, double *dJdot, double *dqdot);

#endif
