/* Loops that close, in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With R x + T v = s and y = P x + Q v + b (fronts.h),
 *
 *   v = T^-1 s - W x,   W = T^-1 R,      P <- P - Q W,   b <- b + Q T^-1 s
 *
 * T is scaled by powers of two and factored with complete pivoting. Where a pivot is small, digits
 * are lost that nothing here brings back: then the front takes all of the model, refines, and can
 * say what is singular. Pools of which something is carried on: closing_part.h. */
#ifndef MBSRI_NEWTON_CLOSING_H
#define MBSRI_NEWTON_CLOSING_H

#include "newton/sweeps/closing_part.h"

/* Of `size` unknowns, a constant where that makes loops short; y: NULL on the root. */
MBSRI_INLINE bool close_sized(const mbsri_newton_sweeps *newton, int k, int size, slab *y)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const bool below_massless = is_below_massless(newton, v->lane_pool[k].body);
    const closing c = closing_of(v, k, size, below_massless);
    const open_pool pool = view_pool(v, v->lane_pool + k);
    int *place = v->list;
    if (!scale_T(&c, &pool, NULL, (int *)(void *)v->work) ||
        !factor_T(&c, place, MBSRI_SHARP_PIVOT))
        return false;
    exchange(size, c.row, c.by_row, v->work);
    exchange(size, place, c.by_column, v->work);
    for (int l = 0; l < size; ++l) c.name[l] = pool.column[place[l]];
    if (!y) return true;
    if (!place_W(&c, &pool, place, v->work)) return false;
    if (below_massless)
        subtract_closed(&c, y, true);
    else
        subtract_closed(&c, y, false);
    return true;
}

/* Front k, from which nothing is carried on. False: the front has to. A pin in the plane
 * has four unknowns, or five with a link without mass that it holds. */
MBSRI_OUTLINE bool close_front(mbsri_newton_sweeps *newton, int k, slab *y)
{
    mbsri_carried *v = &newton->blocks->carried;
    mbsri_carried_seat(newton->blocks, k);
    switch (v->lane_pool[k].count) {
    case 4: return close_sized(newton, k, 4, y);
    case 5: return close_sized(newton, k, 5, y);
    default: return close_sized(newton, k, v->lane_pool[k].count, y);
    }
}

/* Loops that close on body i, or on the root; a status. */
MBSRI_OUTLINE int close_loops_on(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 slab *y)
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    int status = MBSR_OK;
    for (int k = v->first_closing[i]; k > 0 && !status; k = v->front[k].next) {
        mbsri_carried_diagonal(w, run->data, k, newton->c);
        status = mbsri_carried_judge(w, run->data, k, newton->c);
        if (!status && !(v->front[k].passes ? close_part(newton, k, y) : close_front(newton, k, y)))
            status = MBSRI_NOT_SERVED;
    }
    return status;
}

/* The loops at body i, before its joint; a status. */
MBSRI_OUTLINE int meet_loops(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y)
{
    take_ends(run, i, newton, y);
    return run->tree->body[i].flags & MBSRI_CLOSES ? close_loops_on(run, i, newton, y) : MBSR_OK;
}

/* ---- solution ---- */

/* Front k, of `size` unknowns that close there: T^-1 s, and what that adds to the forces; on the
 * root nothing. */
MBSRI_INLINE void load_closed(const mbsri_carried *v, const closing *c, int k, int size, v4 b[4],
                              v4 psi[2], bool on_root)
{
    const double *s = v->store + v->lane_pool[k].right;
    const bool below_massless = c->actions > CLOSED_ACTIONS;
    closing sized = *c;
    sized.size = size;
    for (int l = 0; l < size; ++l) c->right[l] = s[c->row[l]] * c->by_row[l];
    solve_T(&sized, c->right);
    for (int l = 0; l < size && !on_root; ++l) {
        const double *Q = c->Q + l * c->actions;
        const v4 x = splat(c->right[l]);
        for (int r = 0; r < 4; ++r) b[r] += load3(Q + 3 * r) * x;
        for (int r = 0; r < 2 && below_massless; ++r) psi[r] += load3(Q + 12 + 3 * r) * x;
    }
}

/* Loops that close on body i: what their right-hand sides add to its forces. */
MBSRI_OUTLINE void close_loads(mbsri_newton_sweeps *newton, int i, v4 b[4], v4 psi[2])
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const bool below_massless = is_below_massless(newton, i);
    for (int k = v->first_closing[i]; k > 0; k = v->front[k].next) {
        const closing c = closed_front(v, k, below_massless);
        switch (c.size) {
        case 2: load_closed(v, &c, k, 2, b, psi, i == 0); break;
        case 4: load_closed(v, &c, k, 4, b, psi, i == 0); break;
        default: load_closed(v, &c, k, c.size, b, psi, i == 0); break;
        }
        if (c.rest > 0) pass_rest(v, &c, k);
    }
}

/* Loops that close on body i, from its motion. */
MBSRI_OUTLINE void close_motion(mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const bool below_massless = is_below_massless(newton, i);
    for (int k = v->last_closing[i]; k > 0; k = v->front[k].previous) {
        const closing c = closed_front(v, k, below_massless);
        if (c.rest > 0) move_rest(v, &c);
        for (int l = 0; l < c.size; ++l) {
            const double *W = c.W + l * CLOSED_MOTIONS;
            double of_motion = 0.0;
            if (i > 0) {
                const v4 sum = load3(W) * x[0] + load3(W + 3) * x[1] + load3(W + 6) * x[2] +
                               load3(W + 9) * x[3];
                of_motion = sum3(sum);
            }
            v->value[c.name[l]] = (c.right[l] - of_motion) * c.by_column[l];
        }
    }
}

/* Those that close on the root. */
MBSRI_INLINE void turn_root(mbsri_newton_sweeps *newton)
{
    v4 none[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    close_loads(newton, 0, none, none);
    close_motion(newton, 0, none);
}

#endif
