/* The elimination of trees with loops in one sweep, beside the backward recursion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Loops close on a common predecessor of their bodies, with forces that balance: a displacement of
 * that body without rotation changes nothing, and its forces change no sum of forces. So above and
 * beside loops, and wherever no elements act on bodies or behind them, joints are passed as in a
 * tree without any (perturbation.h: not `full`). Bodies at which all columns count are wide
 * (sweeps/tree.h); where their joints are not, what counts in them alone is left behind, being
 * zero.
 *
 * Below a massless joint (reaction.h) are joints of several axes with no inertia behind them: their
 * reactions are the loads on these bodies, known at once. All else that lacks rank is left to the
 * sweeps that go one after the other. */
#ifndef MBSRI_NEWTON_LOOPED_H
#define MBSRI_NEWTON_LOOPED_H

#include "newton/sweeps/ahead.h"
#include "newton/sweeps/elements.h"
#include "newton/sweeps/eliminate.h"

MBSRI_INLINE bool is_light(int flags)
{
    return (flags & (MBSRI_WIDE_JOINT | MBSRI_HEAVY)) == MBSRI_WIDE_JOINT;
}

/* Whether body i, which is wide, has the rank that the sweep takes it to have. */
MBSRI_INLINE bool has_rank(const mbsri_sweep_run *run, int i)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    return run->rank[i] == (is_light(b->flags) ? 0 : b->n);
}

/* W of a body that is massless on a loop from its loads and what its successors have added; to its
 * predecessor. */
MBSRI_INLINE void add_reaction_of(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    double *W = newton->reaction[i].W, *to = newton->reaction[b->parent].W;
    const bool first =
        b->flags & MBSRI_OPENS || !(run->tree->body[b->parent].flags & MBSRI_BRANCHES);
    v4 L = splat(0.0), p = splat(0.0);
    if (!(b->flags & MBSRI_LEAF)) L = load(W), p = load(W + 4);
    if (b->flags & MBSRI_LOADED) {
        L -= load(run->load[i].L);
        p -= load(run->load[i].p);
    }
    store(W, L), store(W + 4, p);
    L += cross(load(run->state[i].rho), p);
    if (!first) L += load(to), p += load(to + 4);
    store(to, L), store(to + 4, p);
}

/* From a joint that is not wide. */
MBSRI_INLINE void leave_narrow(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                               elimination *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const v4 rho = load(run->state[i].rho), none = splat(0.0);
    slab *y = &at->y;
    store(newton->step[i].rho, rho);
    if (b->parent == 0) return;
    translate_slab(rho, y, false);
    if (!(b->flags & MBSRI_TO_WIDE)) {
        queue(b->flags, at, false, false);
        return;
    }
    for (int j = 0; j < 3; ++j) {
        for (int g = 0; g < 4; ++g) y->P[g][j][FORCE] = none;
        for (int r = 0; r < 4; ++r) y->P[DISPLACEMENT][j][r] = none;
    }
    clear_reaction(y);
    queue(b->flags, at, true, newton->last.below_massless);
}

/* Past body i, which is wide; false: its rows are singular, or see newton->status. */
MBSRI_OUTLINE bool eliminate_wide(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                  elimination *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const int flags = b->flags;
    const bool below_massless = is_light(flags);
    slab *y = &at->y;
    place_own(run, i, newton->acting.own + i);
    if (is_pair(newton, i, true)) place_own(run, b->parent, newton->acting.own + b->parent);
    if (below_massless) add_reaction_of(run, i, newton);
    gather_body(run, i, newton, at, true, newton->last.below_massless);
    if (flags & (MBSRI_FRONT | MBSRI_CLOSES)) newton->status = meet_loops(run, i, newton, y);
    if (newton->status) return false;
    if (flags & MBSRI_WIDE_JOINT) {
        const bool passed = flags & MBSRI_FRONT
                                ? pass_open(run, i, newton, y, below_massless)
                                : eliminate_joint(run, i, newton, y, true, below_massless);
        if (passed) leave_body(run, i, newton, at, true, newton->last.below_massless);
        return passed;
    }
    if (!eliminate_joint(run, i, newton, y, false, false)) return false;
    leave_narrow(run, i, newton, at);
    return true;
}

/* The same where it is not; false: its rows are singular. */
MBSRI_OUTLINE bool eliminate_narrow(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                    elimination *at)
{
    gather_body(run, i, newton, at, false, false);
    if (!eliminate_joint(run, i, newton, &at->y, false, false)) return false;
    leave_narrow(run, i, newton, at);
    return true;
}

/* Which bodies are below a massless joint, as the model says, where others have found it in a
 * state. */
static void mark_below_massless(mbsri_newton_sweeps *newton)
{
    newton->last.below_massless = newton->last.massless_on_loop;
    if (newton->last.marked) return;
    for (int i = 0; i <= newton->tree->bodies; ++i) {
        const mbsri_sweep_body *b = newton->tree->body + i;
        const bool below_massless = is_light(b->flags);
        newton->step[i].below_massless =
            below_massless ? MBSRI_BELOW_MASSLESS | (b->n > 0 ? MBSRI_NO_INERTIA : 0) : 0;
        newton->blocks->node[i].below_massless = below_massless;
    }
    newton->last.marked = true;
}

/* Past body i, which is light, on a joint of several axes: no inertia is handed on. */
MBSRI_OUTLINE void pass_light_axes(const mbsri_sweep_run *run, int i, back *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    blocks *c = &at->c;
    if (b->flags & MBSRI_LEAF) clear(c);
    if (b->flags & MBSRI_BRANCHES) add(--at->top, c);
    run->rank[i] = 0;
    memset(run->multi[b->multi].G, 0, sizeof run->multi->G);
    hand_on(b->flags, false, at);
}

/* The step of the backward recursion. */
MBSRI_INLINE bool pass_back(const mbsri_sweep_run *run, int i, back *at)
{
    const int flags = run->tree->body[i].flags;
    if (!(flags & MBSRI_MULTI) || !is_light(flags)) return pass_body(run, i, false, false, at);
    pass_light_axes(run, i, at);
    return true;
}

/* The loops at this state. */
static int open_loops(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    newton->blocks->c = newton->c;
    newton->blocks->node[0].below_massless = false;
    const int status = mbsri_carried_open(newton->blocks, run->data, newton->c);
    if (!status) mbsri_newton_add_joint_slopes(newton);
    return status;
}

static int newton_factor_looped(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    back at;
    elimination of;
    mark_below_massless(newton);
    newton->status = open_loops(run, newton);
    if (newton->status) return MBSRI_BLOCK_FAILED;
    start_back(run, &at);
    start_elimination(run, newton, &of, false);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (newton->large) expect_factor(run, newton, i);
        if (!pass_back(run, i, &at)) return MBSRI_DEFICIENT;
        if (run->tree->body[i].flags & MBSRI_WIDE) {
            if (!has_rank(run, i)) return MBSRI_DEFICIENT;
            if (eliminate_wide(run, i, newton, &of)) continue;
            return newton->status ? MBSRI_BLOCK_FAILED : MBSRI_DEFICIENT;
        }
        if (run->rank[i] != run->tree->body[i].n) return MBSRI_DEFICIENT;
        if (!eliminate_narrow(run, i, newton, &of)) return i;
    }
    newton->status = close_loops_on(run, 0, newton, NULL);
    return newton->status ? MBSRI_BLOCK_FAILED : 0;
}

#endif
