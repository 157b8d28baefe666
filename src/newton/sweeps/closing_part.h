/* Loops that close where others are carried on: as closing.h, of the unknowns a that may go.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With b those that are carried on, and X = T_aa^-1 T_ab,
 *
 *   v_a = T_aa^-1 s_a - W x - X v_b,   W = T_aa^-1 R_a,      P <- P - Q_a W
 *   Q_b <- Q_b - Q_a X    R_b <- R_b - T_ba W    T_bb <- T_bb - T_ba X
 *       s_b <- s_b - T_ba T_aa^-1 s_a
 *
 * Pivots are sought in T_aa alone; where they are small, and where directions without inertia are
 * delayed, which may wait for other loops, the front takes all of the model. So the body has
 * inertia: on a loop of one below a massless joint all directions are delayed. */
#ifndef MBSRI_NEWTON_CLOSING_PART_H
#define MBSRI_NEWTON_CLOSING_PART_H

#include "newton/sweeps/closing_matrix.h"

/* Places of the multipliers of front k, a first; returns how many, -1: there are directions that
 * are delayed. */
MBSRI_INLINE int sort_part(const mbsri_newton_sweeps *newton, int k, int *at)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    if (is_below_massless(newton, v->lane_pool[k].body)) return -1;
    const int count = v->lane_pool[k].count, *name = v->numbers + v->lane_pool[k].column;
    int done = 0, rest = count;
    for (int l = count - 1; l >= 0; --l) {
        if (name[l] >= v->multipliers) return -1;
        if (mbsri_carried_level(w, name[l]) < v->front[k].level) at[--rest] = l;
    }
    for (int l = 0, next = rest; l < count; ++l) {
        if (next < count && at[next] == l)
            ++next;
        else
            at[done++] = l;
    }
    return done;
}

/* X, and T_ba in the scales of a; false: not finite. place: the columns of a. */
MBSRI_INLINE bool place_beside(const closing *c, const open_pool *pool, const int *place)
{
    double worst = 0.0;
    for (int m = 0; m < c->rest; ++m) {
        const int at = c->row[c->size + m];
        double *X = c->LU + (c->size + m) * c->span;
        for (int l = 0; l < c->size; ++l) {
            X[l] = pool->T[at * pool->most + c->row[l]] * c->by_row[l];
            c->LU[l * c->span + c->size + m] =
                pool->T[place[l] * pool->most + at] * c->by_column[l];
        }
        solve_T(c, X);
        for (int l = 0; l < c->size; ++l) {
            const double below = c->LU[l * c->span + c->size + m];
            worst += (X[l] - X[l]) + (below - below);
        }
    }
    return worst == 0.0;
}

/* Unknown m of b, its forces and what eta moves, to the pool that goes on. */
MBSRI_INLINE void hand_unknown(const closing *c, const open_pool *from, const open_pool *to, int m,
                               int place)
{
    const int at = c->row[c->size + m];
    const double *X = c->LU + (c->size + m) * c->span, *Q = from->Q + at * MBSRI_LANE_ACTIONS,
                 *kappa = from->kappa + at * MBSRI_LANE_FORCES;
    double *to_Q = to->Q + place * MBSRI_LANE_ACTIONS,
           *to_kappa = to->kappa + place * MBSRI_LANE_FORCES;
    for (int r = 0; r < 4; ++r) {
        v4 sum = load3(Q + 4 * r);
        for (int l = 0; l < c->size; ++l) sum -= load3(c->Q + l * c->actions + 3 * r) * splat(X[l]);
        store3(to_Q + 4 * r, load3(to_Q + 4 * r) + first_three(sum));
    }
    for (int g = 0; g < MBSRI_LANE_FORCES; g += 4)
        store3(to_kappa + g, load3(to_kappa + g) + load3(kappa + g));
}

/* Its row. */
MBSRI_INLINE void hand_waiting(const closing *c, const open_pool *from, const open_pool *to, int m,
                               int place)
{
    const int at = c->row[c->size + m];
    const double *below = c->LU + c->size + m, *R = from->R + at * MBSRI_LANE_MOTIONS;
    double *to_R = to->R + place * MBSRI_LANE_MOTIONS;
    for (int g = 0; g < 4; ++g) {
        v4 sum = load3(R + 4 * g);
        for (int l = 0; l < c->size; ++l)
            sum -= load3(c->W + l * CLOSED_MOTIONS + 3 * g) * splat(below[l * c->span]);
        store3(to_R + 4 * g, load3(to_R + 4 * g) + first_three(sum));
    }
}

/* What is carried on. */
MBSRI_INLINE void hand_rest(const mbsri_carried *v, const closing *c, int k)
{
    const open_pool from = view_pool(v, v->lane_pool + k);
    open_pool to = view_pool(v, v->lane_pool + from.pool->up);
    int *place = v->numbers + v->front[k].place;
    for (int m = 0; m < c->rest; ++m)
        place[m] = place_of_name(&to, from.column[c->row[c->size + m]]);
    for (int m = 0; m < c->rest; ++m) {
        const int at = c->row[c->size + m];
        const double *X = c->LU + (c->size + m) * c->span;
        hand_unknown(c, &from, &to, m, place[m]);
        hand_waiting(c, &from, &to, m, place[m]);
        for (int n = 0; n < c->rest; ++n) {
            double sum = from.T[at * from.most + c->row[c->size + n]];
            for (int l = 0; l < c->size; ++l) sum -= c->LU[l * c->span + c->size + n] * X[l];
            to.T[place[m] * to.most + place[n]] += sum;
        }
    }
}

/* Front k at the last factorisation. */
MBSRI_INLINE closing closed_front(const mbsri_carried *v, int k, bool below_massless)
{
    const mbsri_carried_front *front = v->front + k;
    if (!front->passes) return closing_of(v, k, v->lane_pool[k].count, below_massless);
    closing c = closing_of(v, k, front->size, below_massless);
    c.size = front->done;
    c.rest = front->size - front->done;
    return c;
}

/* Of `size` unknowns that go and `rest` that go on, constants where that makes loops short. */
MBSRI_INLINE bool close_part_sized(const mbsri_newton_sweeps *newton, int k, int size, int rest,
                                   slab *y)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const open_pool pool = view_pool(v, v->lane_pool + k);
    int *at = v->list, *place = at + pool.pool->count;
    closing c = closed_front(v, k, false);
    c.size = size;
    c.rest = rest;
    if (!scale_T(&c, &pool, at, (int *)(void *)v->work)) return false;
    if (!factor_T(&c, place, MBSRI_CLEAR_PIVOT)) return false;
    exchange(size, c.row, c.by_row, v->work);
    exchange(size, place, c.by_column, v->work);
    for (int l = 0; l < size; ++l) {
        c.row[l] = at[c.row[l]];
        place[l] = at[place[l]];
    }
    for (int m = size; m < size + c.rest; ++m) c.row[m] = place[m] = at[m];
    for (int l = 0; l < size + c.rest; ++l) c.name[l] = pool.column[place[l]];
    if (!place_W(&c, &pool, place, v->work) || !place_beside(&c, &pool, place)) return false;
    hand_rest(v, &c, k);
    if (y) subtract_closed(&c, y, false);
    return true;
}

/* Front k, from which something is carried on; y: NULL on the root. False: nothing is done. A
 * coupling has two unknowns. */
MBSRI_OUTLINE bool close_part(mbsri_newton_sweeps *newton, int k, slab *y)
{
    const mbsri_carried *v = &newton->blocks->carried;
    mbsri_carried_front *front = v->front + k;
    mbsri_carried_seat(newton->blocks, k);
    front->size = v->lane_pool[k].count;
    front->done = sort_part(newton, k, v->list);
    if (front->done < 0) return false;
    const int rest = front->size - front->done;
    if (front->done == 2 && rest == 2) return close_part_sized(newton, k, 2, 2, y);
    return close_part_sized(newton, k, front->done, rest, y);
}

/* On the way back: less X v_b. */
MBSRI_INLINE void move_rest_sized(const mbsri_carried *v, const closing *c, int size)
{
    for (int m = 0; m < c->rest; ++m) {
        const double value = v->value[c->name[size + m]], *X = c->LU + (size + m) * c->span;
        for (int l = 0; l < size; ++l) c->right[l] -= X[l] * value;
    }
}

MBSRI_INLINE void move_rest(const mbsri_carried *v, const closing *c)
{
    if (c->size == 2)
        move_rest_sized(v, c, 2);
    else
        move_rest_sized(v, c, c->size);
}

/* Right-hand sides of the rows that go on, when T_aa^-1 s_a is there. */
MBSRI_INLINE void pass_rest_sized(const mbsri_carried *v, const closing *c, int k, int size)
{
    const mbsri_pool *pool = v->lane_pool + k;
    const int *place = v->numbers + v->front[k].place;
    const double *from = v->store + pool->right;
    double *to = v->store + v->lane_pool[pool->up].right;
    for (int m = 0; m < c->rest; ++m) {
        double sum = from[c->row[size + m]];
        for (int l = 0; l < size; ++l) sum -= c->LU[l * c->span + size + m] * c->right[l];
        to[place[m]] += sum;
    }
}

MBSRI_INLINE void pass_rest(const mbsri_carried *v, const closing *c, int k)
{
    if (c->size == 2)
        pass_rest_sized(v, c, k, 2);
    else
        pass_rest_sized(v, c, k, c->size);
}

#endif
