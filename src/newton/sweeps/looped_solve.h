/* The solution where looped.h has eliminated: likewise, with wide bodies and others.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_LOOPED_SOLVE_H
#define MBSRI_NEWTON_LOOPED_SOLVE_H

#include "newton/sweeps/ahead.h"
#include "newton/sweeps/solve.h"
#include "newton/sweeps/follower.h"

/* From a joint that is not wide. */
MBSRI_INLINE void leave_narrow_loads(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                                     loads *f, mbsri_newton_flow **top)
{
    if (!(s->flags & MBSRI_TO_WIDE)) {
        hand_loads_over(s, f, top, false, false);
        return;
    }
    f->b[FORCE] = f->psi[PSI_L] = f->psi[PSI_P] = splat(0.0);
    hand_loads_over(s, f, top, true, newton->last.below_massless);
}

/* Past body i, which is wide. */
MBSRI_INLINE void wide_loads(mbsri_newton_sweeps *newton, int i, right_sides by, loads *f,
                             mbsri_newton_flow **top)
{
    const mbsri_newton_step *s = newton->step + i;
    const int flags = s->flags;
    const bool below_massless = newton->last.below_massless;
    if (flags & MBSRI_LEAF) clear_loads(f);
    if (flags & MBSRI_BRANCHES) add_loads(--*top, f, true, below_massless);
    if (by.load_of_body) add_load(newton, i, by.load_of_body, f, below_massless);
    if (newton->blocks->carried.first_follower >= 0) add_follower_loads(newton, i, f);
    if (flags & MBSRI_CLOSES) close_loads(newton, i, f->b, f->psi);
    if (flags & MBSRI_WIDE_JOINT) {
        condense_joint(newton, s, i, flags, by, f, true, below_massless, true);
        hand_loads_over(s, f, top, true, below_massless);
    } else {
        condense_joint(newton, s, i, flags, by, f, false, false, false);
        leave_narrow_loads(newton, s, f, top);
    }
}

MBSRI_INLINE void looped_back(mbsri_newton_sweeps *newton, const double *r,
                              const double *load_of_body)
{
    const right_sides by = parts_of(newton->model, r, load_of_body);
    mbsri_newton_flow *top = newton->flow;
    loads f;
    clear_loads(&f);
    for (int i = newton->tree->bodies; i >= 1; --i) {
        if (newton->large) expect_solution(newton, i, -1);
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        if (flags & MBSRI_WIDE) {
            loads wide = f; /* the others stay in registers */
            wide_loads(newton, i, by, &wide, &top);
            f = wide;
            continue;
        }
        if (flags & MBSRI_LEAF) clear_loads(&f);
        if (flags & MBSRI_BRANCHES) add_loads(--top, &f, false, false);
        condense_joint(newton, s, i, flags, by, &f, false, false, false);
        leave_narrow_loads(newton, s, &f, &top);
    }
}

/* The motion of body i's predecessor, in the first `count` groups. */
MBSRI_INLINE void start_motion(const mbsri_newton_sweeps *newton, int i, v4 x[4], int count)
{
    const int parent = newton->step[i].parent;
    if (parent == i - 1 && parent > 0) return;
    const double *from = newton->x[newton->step[parent].branch];
    for (int g = 0; g < count; ++g) x[g] = parent > 0 ? load(from + 4 * g) : splat(0.0);
}

MBSRI_INLINE void store_motion(const mbsri_newton_sweeps *newton, int i, const v4 x[4], int count)
{
    const mbsri_newton_step *s = newton->step + i;
    if (!(s->flags & MBSRI_BRANCHES)) return;
    for (int g = 0; g < count; ++g) store(newton->x[s->branch] + 4 * g, x[g]);
}

MBSRI_INLINE void looped_forward(mbsri_newton_sweeps *newton, const double *r, double *delta,
                                 double *motion)
{
    const solution of = solution_of(newton->model, delta);
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    for (int i = 1; i <= newton->tree->bodies; ++i) {
        if (newton->large) expect_solution(newton, i, 1);
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        if (!(flags & MBSRI_WIDE)) {
            start_motion(newton, i, x, 3);
            move_joint(newton, s, i, flags, r, of, x, false, false);
            store_motion(newton, i, x, 3);
            continue;
        }
        if (flags & MBSRI_WIDE_JOINT) {
            start_motion(newton, i, x, 4);
            move_joint(newton, s, i, flags, r, of, x, true, true);
        } else {
            start_motion(newton, i, x, 3);
            move_joint(newton, s, i, flags, r, of, x, false, false);
            x[DISPLACEMENT] = splat(0.0);
        }
        store_motion(newton, i, x, 4);
        if (newton->blocks->carried.first_follower >= 0) see_followers(newton, i, x);
        if (flags & MBSRI_CLOSES) close_motion(newton, i, x);
        if (motion) report_motion(newton, i, x, motion + 12 * i);
    }
}

MBSRI_OUTLINE void solve_looped(mbsri_newton_sweeps *newton, const double *r,
                                const double *load_of_body, double *delta, double *motion)
{
    mbsri_front_load(newton->blocks, r);
    mbsri_follower_load(newton->blocks);
    if (r && !load_of_body) /* mostly so: without questions at every body */
        looped_back(newton, r, NULL);
    else
        looped_back(newton, r, load_of_body);
    turn_root(newton);
    if (r)
        looped_forward(newton, r, delta, motion);
    else
        looped_forward(newton, NULL, delta, motion);
    mbsri_follower_finish(newton->blocks);
    mbsri_front_multipliers(newton->blocks, r, delta);
}

static void newton_solve(mbsri_newton_sweeps *newton, const double *r, const double *load_of_body,
                         double *delta, double *motion)
{
    if (newton->last.looped)
        solve_looped(newton, r, load_of_body, delta, motion);
    else if (newton->mixed)
        solve_mixed(newton, r, load_of_body, delta);
    else if (newton->acting.own)
        solve_system(newton, r, load_of_body, delta, motion, true);
    else
        solve_system(newton, r, load_of_body, delta, NULL, false);
}

#endif
