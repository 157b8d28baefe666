/* Closures whose forces turn with their second body, in solutions: see
 * newton/slopes/closure_turn.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_FOLLOWER_H
#define MBSRI_NEWTON_FOLLOWER_H

#include "newton/carried/follower.h"
#include "newton/sweeps/solve.h"

/* Loads on body i. */
MBSRI_OUTLINE void add_follower_loads(const mbsri_newton_sweeps *newton, int i, loads *f)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_closure *all = newton->model->closures.data;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const mbsri_closure *c = all + v->end[k].closure;
        const mbsri_loop *loop = v->loop + v->end[k].closure;
        if (!loop->follower || v->end[k].slot != 1) continue;
        add_wrench(newton, i, mbsri_turn_of(v, c, loop).load + c->column[1], f,
                   newton->last.below_massless);
    }
}

/* What the motion of body i makes of its multipliers. */
MBSRI_OUTLINE void see_followers(const mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_closure *all = newton->model->closures.data;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const mbsri_closure *c = all + v->end[k].closure;
        const mbsri_loop *loop = v->loop + v->end[k].closure;
        if (!loop->follower || v->end[k].slot != 1) continue;
        const mbsri_closure_turn turn = mbsri_turn_of(v, c, loop);
        double motion[12];
        report_motion(newton, i, x, motion);
        for (int l = 0; l < c->rows; ++l) turn.shift[l] = 0.0;
        for (int j = c->column[1]; j < c->columns; ++j) {
            const double *L = turn.L + j * c->rows;
            for (int l = 0; l < c->rows; ++l) turn.shift[l] += L[l] * motion[j - c->column[1]];
        }
    }
}

#endif
