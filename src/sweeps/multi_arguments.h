/* What a joint of several axes is asked with in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_MULTI_ARGUMENTS_H
#define MBSRI_SWEEPS_MULTI_ARGUMENTS_H

#include "algebra/space3.h"
#include "sweeps/tree.h"

#include <string.h>

/* The joint's arguments; everything is seen from the predecessor's origin as these sweeps use it,
 * which takes its velocity away from all. pose, V: of the predecessor. */
static inline mbsr_joint_args mbsri_multi_arguments(const mbsri_sweep_run *run, int i,
                                                    double pose[MBSR_POSE_SIZE], double V[6])
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_joint *seat = run->tree->joint + b->multi;
    const mbsri_sweep_state *pred = run->state + b->parent;
    const mbsri_joint *chain = &seat->chain;
    const bool rests = run->model->body[i].pred.space == MBSR_SPACE_FIXED;
    const mbsr_joint_args args = {.param = chain->param,
                                  .option = chain->option,
                                  .motion = chain->motion,
                                  .user = chain->user,
                                  .d = chain->d,
                                  .np = chain->np,
                                  .n = chain->n,
                                  .nq = chain->nq,
                                  .t = run->data->t,
                                  .q = run->q + b->q,
                                  .u = run->u + b->u,
                                  .pred_space = rests ? MBSR_SPACE_FIXED : MBSR_SPACE_SPATIAL,
                                  .pred_d = rests ? 0 : 6,
                                  .p_pred = pose,
                                  .V_pred = V};
    memset(V, 0, 6 * sizeof *V);
    if (args.pred_space != MBSR_SPACE_FIXED) {
        double R[9];
        for (int k = 0; k < 9; ++k) R[k] = pred->R[k / 3 * 4 + k % 3];
        mbsri_multiply3(R, seat->R, pose + MBSR_POSE_R);
        mbsri_rotate3(R, seat->x, pose + MBSR_POSE_X);
        memcpy(V, pred->omega, 3 * sizeof *V);
        mbsri_cross3(pred->omega, pose + MBSR_POSE_X, V + 3);
    }
    return args;
}

#endif
