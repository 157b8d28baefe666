/* The solution with the transposed matrix where looped.h has eliminated: looped_solve.h, its steps
 * transposed.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_LOOPED_TRANSPOSED_H
#define MBSRI_NEWTON_LOOPED_TRANSPOSED_H

#include "newton/sweeps/looped_solve.h"
#include "newton/sweeps/solve_transposed.h"

/* ---- closures whose forces turn with their second body ---- */

/* Of see_followers. */
MBSRI_OUTLINE void see_followers_back(const mbsri_newton_sweeps *newton, int i, v4 x[4])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_closure *all = newton->model->closures.data;
    const mbsri_newton_own *own = newton->acting.own + i;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const mbsri_closure *c = all + v->end[k].closure;
        const mbsri_loop *loop = v->loop + v->end[k].closure;
        if (!loop->follower || v->end[k].slot != 1) continue;
        const mbsri_closure_turn turn = mbsri_turn_of(v, c, loop);
        double pose[6] = {0.0}, lifted[6];
        for (int j = c->column[1]; j < c->columns; ++j)
            pose[j - c->column[1]] = mbsri_dot(c->rows, turn.L + j * c->rows, turn.shift);
        mbsri_lift(newton->model->body[i].d, pose, lifted);
        const v4 rotation = {lifted[0], lifted[1], lifted[2], 0.0},
                 place = {lifted[3], lifted[4], lifted[5], 0.0};
        x[ROTATION] += rotation + cross(load(own->arm), place);
        x[DISPLACEMENT] += place;
    }
}

/* Of add_follower_loads. */
MBSRI_OUTLINE void follower_loads_back(const mbsri_newton_sweeps *newton, int i, const loads *f)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_closure *all = newton->model->closures.data;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const mbsri_closure *c = all + v->end[k].closure;
        const mbsri_loop *loop = v->loop + v->end[k].closure;
        if (!loop->follower || v->end[k].slot != 1) continue;
        v4 moment = f->b[MOMENT], force = f->b[FORCE];
        if (is_below_massless(newton, i)) moment -= f->psi[PSI_L], force -= f->psi[PSI_P];
        force += cross(moment, load(newton->acting.own[i].arm));
        const double wrench[6] = {moment[0], moment[1], moment[2], force[0], force[1], force[2]};
        mbsri_lower(newton->model->body[i].d, wrench,
                    mbsri_turn_of(v, c, loop).load + c->column[1]);
    }
}

/* ---- leaves to root ---- */

/* Of looped_forward. */
MBSRI_INLINE void looped_motions_back(mbsri_newton_sweeps *newton, const double *v, double *to)
{
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    clear_branches(newton);
    for (int i = newton->tree->bodies; i >= 1; --i) {
        if (newton->large) expect_solution(newton, i, -1);
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        gather_motions(newton, s, x, true);
        if (flags & MBSRI_CLOSES) close_motion_back(newton, i, x);
        if (flags & MBSRI_WIDE && newton->blocks->carried.first_follower >= 0)
            see_followers_back(newton, i, x);
        if (flags & MBSRI_WIDE_JOINT) {
            move_back(newton, i, v, to, x, true, true);
        } else {
            move_back(newton, i, v, to, x, false, false);
            x[DISPLACEMENT] = splat(0.0);
        }
        hand_motions_over(newton, i, x, true);
    }
}

/* ---- root to leaves ---- */

/* Of looped_back. */
MBSRI_INLINE void looped_loads_back(mbsri_newton_sweeps *newton, transposed to)
{
    const bool below_massless = newton->last.below_massless;
    loads f;
    clear_loads(&f);
    for (int i = 1; i <= newton->tree->bodies; ++i) {
        if (newton->large) expect_solution(newton, i, 1);
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        gather_said(newton, i, &f, true, below_massless);
        if (flags & MBSRI_WIDE_JOINT)
            joint_back(newton, i, to, &f, true, below_massless, true);
        else {
            f.b[FORCE] = f.psi[PSI_L] = f.psi[PSI_P] = splat(0.0);
            joint_back(newton, i, to, &f, false, false, false);
        }
        if (flags & MBSRI_CLOSES) close_loads_back(newton, i, f.b, f.psi);
        if (flags & MBSRI_WIDE && newton->blocks->carried.first_follower >= 0)
            follower_loads_back(newton, i, &f);
        if (flags & MBSRI_BRANCHES)
            loads_to_memory(&f, newton->said + s->branch, true, below_massless);
    }
}

MBSRI_OUTLINE void solve_looped_transposed(mbsri_newton_sweeps *newton, const double *v,
                                           transposed to)
{
    v4 none[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    mbsri_front_multipliers_transposed(newton->blocks, v, to.x);
    mbsri_follower_finish_transposed(newton->blocks);
    looped_motions_back(newton, v, to.x);
    close_motion_back(newton, 0, none);
    close_loads_back(newton, 0, none, none);
    looped_loads_back(newton, to);
    mbsri_follower_load_transposed(newton->blocks);
    mbsri_front_load_transposed(newton->blocks, to.x);
}

static void newton_solve_transposed(mbsri_newton_sweeps *newton, const double *v, double *x,
                                    double *tau)
{
    const transposed to = {x, tau};
    if (newton->last.looped)
        solve_looped_transposed(newton, v, to);
    else
        solve_system_transposed(newton, v, to);
}

#endif
