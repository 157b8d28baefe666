/* Derivatives of a joint's equations along each of its variables.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JOINT_SLOPES_H
#define MBSRI_JOINT_SLOPES_H

#include "recursion/data.h"

/* The derivatives of one joint, a column each for the predecessor's pose, V and A, then q, u, u'.
 * With d for the derivative along the column and K divided out, the rows are
 *
 *   x      the body's own pose, V and A                                            e + 2 d
 *   below  -dH^T m,  -(dH^T sigma + dH'^T m),  -dH^T mu                            3 d_pred
 *   own    dJ^T m,  dJ^T sigma + dJ'^T m,  dJ^T mu                                 3 n
 *   qdot   d(G u)                                                                  nq
 *
 * where m, sigma, mu are the impulse, its rate and the reaction of the joint, held. */
typedef struct mbsri_joint_slopes {
    int e, e_pred, columns; /* e_pred + 2 d_pred + nq + 2 n */
    int q, u, a;            /* the first column of q, u, u' */
    double *x, *below, *own, *qdot;
    double *work;
} mbsri_joint_slopes;

/* Doubles for the largest joint of the model, and where they are given to it. */
size_t mbsri_joint_slopes_size(const mbsr_model *m);
void mbsri_joint_slopes_place(mbsri_joint_slopes *s, double *memory);

/* Of joint i at the state of mbsr_stage_backward with momenta and rates; `accelerated`: with A and
 * mu of the accelerations udot (n, in the order of the sweeps), otherwise the rows of A and mu are
 * zero. Statuses of the joint's functions. */
int mbsri_joint_slopes_of(const mbsr_model *m, mbsr_data *d, int i, bool accelerated,
                          const double *udot, mbsri_joint_slopes *s);

/* Whether the joint's derivatives can be had: one that leaves its rates to differences needs V = p'
 * of its predecessor. */
bool mbsri_joint_slopes_serve(const mbsri_body *b, int np_pred);

#endif
