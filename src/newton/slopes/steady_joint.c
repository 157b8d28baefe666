/* Derivatives of a joint that moves its body the same way in every state: see steady_joint.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * V = -J u with a constant J, so that only the pose changes with q, by -J dq or the turn of a
 * quaternion, and V with u. */
#include "newton/slopes/steady_joint.h"

#include "algebra/space3.h"
#include "joints/chain.h"

bool mbsri_steady_joint_serves(const mbsri_body *b)
{
    const mbsri_joint *joint = &b->joint;
    return joint->space == MBSR_SPACE_SPATIAL && joint->table->tangent == mbsri_chain_tangent &&
           b->lock.count == 0 && mbsri_chain_is_steady(b->pred.space, joint->param, joint->option);
}

void mbsri_steady_joint(const mbsri_body *b, const mbsr_data *d, const double *q, const double *u,
                        double *const x[2], double *const qdot[2])
{
    enum { ROWS = 18, V = 6 }; /* V: its first row */
    const size_t nq = (size_t)b->nq;
    const double *J = d->J + b->dn;
    double n[4];
    (void)mbsri_scale4(q, n);
    for (size_t k = 0; k < 4; ++k) {
        double dq[4] = {0.0}, turn[3];
        dq[k] = 1.0;
        mbsri_chain_turn(q, n, dq, turn);
        for (int l = 0; l < 3; ++l) mbsri_add3(-turn[l], J + 6 * (ptrdiff_t)l, x[0] + k * ROWS);
        mbsri_chain_quaternion_rate(dq, u, qdot[0] + k * nq);
    }
    for (size_t k = 0; k < (size_t)b->n; ++k) {
        const double *along = J + 6 * k;
        for (size_t l = 0; l < 6; ++l) x[1][k * ROWS + V + l] = -along[l];
        if (k < 3) {
            double du[3] = {0.0};
            du[k] = 1.0;
            mbsri_chain_quaternion_rate(q, du, qdot[1] + k * nq);
            continue;
        }
        for (size_t l = 0; l < 6; ++l) x[0][(k + 1) * ROWS + l] = -along[l];
        qdot[1][k * nq + k + 1] = 1.0;
    }
}
