/* Pools of what is carried past joints (newton/carried/lane_pools.h), as the Newton sweeps see
 * them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_POOLS_H
#define MBSRI_NEWTON_POOLS_H

#include "newton/carried/carried.h"
#include "newton/carried/lane_pools.h"
#include "newton/sweeps/record.h"
#include "sweeps/lane.h"

/* What the solution needs of the rows, and of the unknowns: du -= z v, the joint is moved by e v,
 * d(M u) += p v. */
typedef struct open_record {
    double *m, *n, *z, *e, *p;
} open_record;

/* How many du of joint i are carried on: none, or all of the joint. */
MBSRI_INLINE int delayed_at(const mbsri_newton_sweeps *newton, int i)
{
    const mbsri_newton_step *s = newton->step + i;
    return s->below_massless & MBSRI_NO_INERTIA ? s->n : 0;
}

/* Of axis k of joint i, when the names from behind are known. */
MBSRI_INLINE open_record record_of(const mbsri_newton_sweeps *newton, int i, int k)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const int span = mbsri_lane_span(pool->count + delayed_at(newton, i));
    double *at = v->store + pool->record + MBSRI_LANE_RECORD * span * k;
    return (open_record){at, at + span, at + 2 * span, at + 3 * span, at + 4 * span};
}

/* A pool's arrays. */
typedef struct open_pool {
    mbsri_pool *pool;
    double *Q, *kappa, *R, *T;
    int *column, *row, most;
} open_pool;

MBSRI_INLINE open_pool view_pool(const mbsri_carried *v, mbsri_pool *pool)
{
    double *store = v->store;
    return (open_pool){pool,
                       store + pool->Q,
                       store + mbsri_pool_kappa(pool),
                       store + mbsri_pool_R(pool),
                       store + mbsri_pool_T(pool),
                       v->numbers + pool->column,
                       v->numbers + mbsri_pool_row(pool),
                       pool->most};
}

/* The next unknown and row of a pool, with nothing in them. */
MBSRI_INLINE int append(open_pool *to, int column, int row)
{
    const int at = to->pool->count++;
    const v4 none = splat(0.0);
    to->column[at] = column;
    to->row[at] = row;
    for (int r = 0; r < MBSRI_LANE_ACTIONS; r += 4)
        store3(to->Q + at * MBSRI_LANE_ACTIONS + r, none);
    for (int r = 0; r < MBSRI_LANE_FORCES; r += 4)
        store3(to->kappa + at * MBSRI_LANE_FORCES + r, none);
    for (int r = 0; r < MBSRI_LANE_MOTIONS; r += 4)
        store3(to->R + at * MBSRI_LANE_MOTIONS + r, none);
    for (int r = 0; r <= at; r += 4) store3(to->T + at * to->most + r, none);
    for (int k = 0; k < at; ++k) to->T[k * to->most + at] = 0.0;
    return at;
}

MBSRI_INLINE int place_of_name(open_pool *to, int name)
{
    const int at = mbsri_carried_find(to->column, to->pool->count, name);
    return at >= 0 ? at : append(to, name, name);
}

/* Nothing in the fourth number, which counts where fronts are dense matrices. */
MBSRI_INLINE v4 first_three(v4 x)
{
    const i4 mask = {-1, -1, -1, 0};
    return (v4)((i4)x & mask);
}

#endif
