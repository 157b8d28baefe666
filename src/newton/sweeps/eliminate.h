/* The elimination, leaves to root, beside the backward recursion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_ELIMINATE_H
#define MBSRI_NEWTON_ELIMINATE_H

#include "newton/sweeps/border.h"
#include "newton/sweeps/closing.h"
#include "newton/sweeps/multi_fronts.h"
#include "sweeps/backward.h"

/* ---- leaves to root: Mbar and P ---- */

/* Where the elimination stands. */
typedef struct elimination {
    slab y;
    mbsri_newton_carry *top;
} elimination;

/* The record of a coordinate, to be written soon. */
MBSRI_INLINE void expect_column(const mbsri_newton_sweeps *newton, int u)
{
    const char *record = (const char *)mbsri_newton_column_at(newton, u > 0 ? u : 0);
    for (size_t k = 0; k < newton->column_size; k += 64) __builtin_prefetch(record + k, 1);
}

/* To the predecessor, whose slab this is. */
MBSRI_INLINE void queue(int flags, elimination *at, bool full, bool below_massless)
{
    slab *y = &at->y;
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) {
        add_slab(--at->top, y, full);
        if (below_massless) add_reaction(at->top, y);
    }
    slab_to_memory(y, at->top, full);
    if (below_massless) reaction_to_memory(y, at->top);
    ++at->top;
}

/* From body i to its predecessor. */
MBSRI_INLINE void hand_over(const mbsri_sweep_run *run, int i, elimination *at, bool full,
                            bool below_massless)
{
    const int flags = run->tree->body[i].flags;
    const v4 rho = load(run->state[i].rho);
    translate_slab(rho, &at->y, full);
    if (below_massless) translate_reaction(rho, &at->y, full);
    queue(flags, at, full, below_massless);
}

/* All that acts on body i: its own mass, its successors, elements. any: there are bodies below
 * massless joints. */
MBSRI_INLINE void gather_body(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                              elimination *at, bool full, bool any)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const v4 g = load3(run->tree->gravity);
    const int flags = b->flags;
    const bool below_massless = any && newton->step[i].below_massless & MBSRI_BELOW_MASSLESS;
    slab *y = &at->y;
    expect_column(newton, b->u - 2);
    if (flags & MBSRI_LEAF) clear_slab(y, full);
    if (any && flags & MBSRI_LEAF) clear_reaction(y);
    if (flags & MBSRI_BRANCHES) {
        add_slab(--at->top, y, full);
        if (any) add_reaction(at->top, y);
    }
    if (!(flags & MBSRI_MASSLESS)) add_own_slab(b, run->state + i, g, y);
    if (full && flags & MBSRI_LOADED) add_elements(run, i, newton, y, below_massless);
}

/* False: the rows of the joint are singular. What reaches others of Y is not used. */
MBSRI_INLINE bool eliminate_joint(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                  slab *y, bool full, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    if (__builtin_expect((b->flags & MBSRI_MULTI) != 0, 0)) { /* most have one axis */
        _Alignas(32) mbsri_newton_carry multi;
        slab_to_memory(y, &multi, full);
        if (!eliminate_multi(run, i, newton, &multi, full)) return false;
        clear_slab(y, full);
        add_slab(&multi, y, full);
    } else if (b->n) {
        if (!eliminate(run, i, newton, y, full, below_massless)) return false;
    } else if (is_pair(newton, i, full)) {
        pass_weld(run, i, newton, y, below_massless);
    }
    return true;
}

/* To the predecessor. */
MBSRI_INLINE void leave_body(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             elimination *at, bool full, bool any)
{
    store(newton->step[i].rho, load(run->state[i].rho));
    if (run->tree->body[i].parent > 0) hand_over(run, i, at, full, any);
}

/* Past body i, which the backward sweep has passed, too; false: the rows of its joint are singular.
 */
MBSRI_INLINE bool eliminate_body(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 elimination *at, bool full, bool any)
{
    const bool below_massless = any && newton->step[i].below_massless & MBSRI_BELOW_MASSLESS;
    gather_body(run, i, newton, at, full, any);
    if (!eliminate_joint(run, i, newton, &at->y, full, below_massless)) return false;
    leave_body(run, i, newton, at, full, any);
    return true;
}

MBSRI_INLINE void start_elimination(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton,
                                    elimination *at, bool full)
{
    clear_slab(&at->y, full);
    at->top = newton->carry;
    for (int i = 1; i <= run->tree->bodies && full; ++i) place_own(run, i, newton->acting.own + i);
}

/* Both in one sweep, while the body is at hand. */
MBSRI_INLINE int factor_sweep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, bool full)
{
    back at;
    elimination of;
    start_back(run, &at);
    start_elimination(run, newton, &of, full);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!pass_body(run, i, false, false, &at)) return MBSRI_DEFICIENT;
        if (run->rank[i] != run->tree->body[i].n) return MBSRI_DEFICIENT;
        if (!eliminate_body(run, i, newton, &of, full, false)) return i;
    }
    return 0;
}

static int newton_factor(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    return run->load ? factor_sweep(run, newton, true) : factor_sweep(run, newton, false);
}

/* After the backward sweep, where the bound does not tell or bodies are below massless joints;
 * their reactions are known. */
MBSRI_INLINE int below_massless_sweep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton,
                                      bool full)
{
    elimination of;
    start_elimination(run, newton, &of, full);
    clear_reaction(&of.y);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!eliminate_body(run, i, newton, &of, full, true)) return i;
    }
    return 0;
}

static int newton_factor_below_massless(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    if (!run->tree->kernels->backward(run) || !find_below_massless(run, newton))
        return MBSRI_NOT_CLEAR;
    newton->last.unclear = true;
    if (newton->last.below_massless) run->tree->kernels->forward(run);
    if (newton->last.below_massless) find_reactions(run, newton);
    return run->load ? below_massless_sweep(run, newton, true)
                     : below_massless_sweep(run, newton, false);
}

/* ---- trees with blocks ---- */

/* Past block i; false: see newton->status. */
MBSRI_OUTLINE bool eliminate_block(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                   elimination *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const bool below_massless = newton->last.below_massless;
    _Alignas(32) mbsri_newton_carry carry;
    newton->status = mbsri_border_eliminate(run, newton, i, &carry);
    if (newton->status) return false;
    if (b->parent == 0 || b->flags & MBSRI_TO_BLOCK) return true;
    const v4 arm = load(newton->acting.own[b->parent].arm);
    slab *y = &at->y;
    clear_slab(y, true);
    clear_reaction(y);
    add_slab(&carry, y, true);
    if (below_massless) add_reaction(&carry, y);
    translate_slab(arm, y, true);
    if (below_massless) translate_reaction(arm, y, true);
    queue(b->flags, at, true, below_massless);
    return true;
}

MBSRI_OUTLINE void give_slab(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             const elimination *at)
{
    _Alignas(32) mbsri_newton_carry carry;
    slab_to_memory(&at->y, &carry, true);
    if (newton->last.below_massless) reaction_to_memory(&at->y, &carry);
    mbsri_border_give(run, newton, i, &carry);
}

static int mixed_sweep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    elimination of;
    start_elimination(run, newton, &of, true);
    clear_reaction(&of.y);
    for (int i = run->tree->bodies; i >= 1; --i) {
        const int flags = run->tree->body[i].flags;
        if (flags & MBSRI_BLOCK) {
            if (!eliminate_block(run, i, newton, &of)) return MBSRI_BLOCK_FAILED;
            continue;
        }
        if (!eliminate_body(run, i, newton, &of, true, newton->last.below_massless)) return i;
        if (flags & MBSRI_TO_BLOCK) give_slab(run, i, newton, &of);
    }
    return 0;
}

/* Trees with blocks. After the backward sweep. */
static int newton_factor_mixed(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    if (!run->tree->kernels->backward(run) || !find_below_massless(run, newton))
        return MBSRI_NOT_CLEAR;
    if (newton->last.below_massless) {
        run->tree->kernels->forward(run);
        memcpy(run->data->udot, run->out, (size_t)run->model->nu * sizeof *run->out);
        find_reactions(run, newton);
    }
    mbsri_border_open(run, newton);
    newton->status = mbsri_block_open_momentum(run);
    return newton->status ? MBSRI_BLOCK_FAILED : mixed_sweep(run, newton);
}

#endif
