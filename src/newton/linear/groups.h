/* Joints and groups of joints, as the linearised equations take them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LINEAR_GROUPS_H
#define MBSRI_LINEAR_GROUPS_H

#include "newton/linear/linear.h"
#include "recursion/group.h"
#include "recursion/momentum.h"

/* Whether joint i is one by itself, or stands for its group. */
static inline bool mbsri_linear_leads(const mbsri_linear *l, int i)
{
    return !l->coupled[i] || l->model->body[i].group.head == i;
}

/* That joint or group. */
static inline mbsri_group mbsri_linear_group(const mbsri_linear *l, int i)
{
    const mbsri_body *b = l->model->body + i;
    if (l->coupled[i]) return mbsri_group_in_model(l->model, i);
    return (mbsri_group){l->model->order.member + b->group.at, 1, b->n, b->group.iu};
}

/* The rate by which momenta are in the rows of u of joint i, or of the group of that head. */
static inline double mbsri_linear_rate(const mbsri_linear *l, int i)
{
    return mbsri_momentum_rate(l->model, mbsri_linear_group(l, i).n, l->rank[i]);
}

#endif
