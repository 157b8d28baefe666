/* Displaced poses, and derivatives of a joint's functions by differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MOVE_H
#define MBSRI_MOVE_H

#include "recursion/data.h"
#include "recursion/pose.h"

/* ---- differences of a joint's functions ---- */

/* K, H, J and one vector. */
typedef struct mbsri_joint_sample {
    double *K, *H, *J, *k;
} mbsri_joint_sample;

typedef struct mbsri_joint_mover {
    const mbsr_joint_table *table;
    mbsr_space space; /* of the body */
    int np_pred;
    bool still;   /* mbsri_joint_move_rates: q and poses do not change */
    double span;  /* multiple of the change over which functions change; `still`: of its size */
    double speed; /* rate at which the state moves through these, 1/s */
    double *q, *u, *p_pred, *V_pred, *p, *V;   /* displaced */
    double *q_on, *p_pred_on, *dp_pred, *p_on; /* and moved on from there in time */
    double *qdot;
    mbsri_joint_sample sample, inner;
} mbsri_joint_mover;

/* Places the arrays in memory (NULL: none); returns how many doubles they take. */
size_t mbsri_joint_mover_place(const mbsri_body *b, int np_pred, double *memory,
                               mbsri_joint_mover *w);

/* What `tangent` and `rate_tangent` of the joint would write; *name is the function that failed. */
int mbsri_joint_move_tangent(mbsri_joint_mover *w, const mbsr_joint_args *args,
                             const mbsr_joint_change *by, double *dp, double *dK, double *dH,
                             double *dJ, double *dkI, const char **name);
int mbsri_joint_move_rates(mbsri_joint_mover *w, const mbsr_joint_args *args,
                           const mbsr_joint_change *by, double *dkII, double *dKdot, double *dHdot,
                           double *dJdot, double *dqdot, const char **name);

/* K' at args, H' and J' besides: what `rates` writes, or differences. */
int mbsri_joint_move_Kdot(mbsri_joint_mover *w, const mbsr_joint_args *args, double *Kdot,
                          double *Hdot, double *Jdot);

#endif
