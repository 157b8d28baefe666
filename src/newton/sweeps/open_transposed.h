/* What open loops are in solutions with the transposed matrix: fronts.h, multi_fronts.h, closing.h
 * and closing_part.h, their steps of a solution transposed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * `value` has what is said of the unknowns, from the leaves to the root, and the right-hand sides
 * of pools what is said of these, from the root to the leaves. */
#ifndef MBSRI_NEWTON_OPEN_TRANSPOSED_H
#define MBSRI_NEWTON_OPEN_TRANSPOSED_H

#include "newton/sweeps/closing.h"

/* ---- joints ---- */

/* Of move_open, for axis o of joint i: what is said of du, of what moves the joint besides, and of
 * d(M u). */
MBSRI_OUTLINE void open_motion_back(const mbsri_newton_sweeps *newton, int i, int o, double du,
                                    double rest, double dp)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const int *name = v->numbers + pool->column, count = pool->count,
              delayed = delayed_at(newton, i);
    const open_record by = record_of(newton, i, o);
    for (int l = 0; l < count; ++l)
        v->value[name[l]] += by.e[l] * rest - by.z[l] * du + by.p[l] * dp;
    for (int l = 0; l < delayed; ++l)
        v->value[mbsri_name_own(newton->blocks, i, l)] += by.p[count + l] * dp;
    if (delayed > 0) v->value[mbsri_name_own(newton->blocks, i, o)] += du;
}

/* Of pass_rights: what is said of the rows, and of k and r_q (or g) of each axis and of the
 * balances of a joint that is delayed, added to these. */
MBSRI_OUTLINE void open_rights_back(const mbsri_newton_sweeps *newton, int i, double *k, double *g,
                                    double *rest)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const int count = pool->count, delayed = delayed_at(newton, i), n = newton->step[i].n,
              *place = v->numbers + pool->place;
    double *from = v->store + pool->right;
    const double *to = v->store + v->lane_pool[pool->up].right;
    for (int o = 0; o < delayed; ++o) rest[o] += to[pool->in_place ? count + o : place[count + o]];
    for (int l = 0; l < count; ++l) from[l] = to[pool->in_place ? l : place[l]];
    for (int o = 0; o < n; ++o) {
        const open_record by = record_of(newton, i, o);
        for (int l = 0; l < count; ++l) {
            k[o] -= by.m[l] * from[l];
            g[o] -= by.n[l] * from[l];
        }
    }
}

/* ---- loops that close ---- */

/* Of solve_T. */
MBSRI_INLINE void solve_T_back(const closing *c, double *x)
{
    const int size = c->size, span = c->span;
    for (int k = 0; k < size; ++k) {
        for (int l = 0; l < k; ++l) x[k] -= c->LU[k * span + l] * x[l];
        x[k] *= c->LU[k * span + k];
    }
    for (int k = size - 1; k >= 0; --k) {
        for (int l = k + 1; l < size; ++l) x[k] -= c->LU[k * span + l] * x[l];
    }
}

/* Of close_motion; x: what is said of the body's motion. What is said of T^-1 s stays in `right`.
 */
MBSRI_OUTLINE void close_motion_back(mbsri_newton_sweeps *newton, int i, v4 x[4])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const bool below_massless = is_below_massless(newton, i);
    for (int k = v->first_closing[i]; k > 0; k = v->front[k].next) {
        const closing c = closed_front(v, k, below_massless);
        for (int l = 0; l < c.size; ++l) {
            const double said = v->value[c.name[l]] * c.by_column[l], *W = c.W + l * CLOSED_MOTIONS;
            c.right[l] = said;
            for (int g = 0; g < 4 && i > 0; ++g) x[g] -= load3(W + 3 * g) * splat(said);
        }
        for (int m = 0; m < c.rest; ++m) {
            const double *X = c.LU + (c.size + m) * c.span;
            double sum = 0.0;
            for (int l = 0; l < c.size; ++l) sum += X[l] * c.right[l];
            v->value[c.name[c.size + m]] -= sum;
        }
    }
}

/* Of pass_rest. */
MBSRI_INLINE void rest_back(const mbsri_carried *v, const closing *c, int k)
{
    const mbsri_pool *pool = v->lane_pool + k;
    const int *place = v->numbers + v->front[k].place;
    double *from = v->store + pool->right;
    const double *to = v->store + v->lane_pool[pool->up].right;
    for (int m = 0; m < c->rest; ++m) {
        const double said = to[place[m]];
        for (int l = 0; l < c->size; ++l) c->right[l] -= c->LU[l * c->span + c->size + m] * said;
        from[c->row[c->size + m]] = said;
    }
}

/* Of close_loads; b, psi: what is said of the loads. */
MBSRI_OUTLINE void close_loads_back(mbsri_newton_sweeps *newton, int i, const v4 b[4],
                                    const v4 psi[2])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const bool below_massless = is_below_massless(newton, i);
    for (int k = v->last_closing[i]; k > 0; k = v->front[k].previous) {
        const closing c = closed_front(v, k, below_massless);
        double *s = v->store + v->lane_pool[k].right;
        for (int l = 0; l < c.size && i > 0; ++l) {
            const double *Q = c.Q + l * c.actions;
            v4 sum = splat(0.0);
            for (int r = 0; r < 4; ++r) sum += load3(Q + 3 * r) * b[r];
            for (int r = 0; r < 2 && below_massless; ++r) sum += load3(Q + 12 + 3 * r) * psi[r];
            c.right[l] += sum3(sum);
        }
        if (c.rest > 0) rest_back(v, &c, k);
        solve_T_back(&c, c.right);
        for (int l = 0; l < c.size; ++l) s[c.row[l]] = c.right[l] * c.by_row[l];
    }
}

#endif
