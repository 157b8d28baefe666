/* The sweeps over parts of a tree, which split.c shares out among threads: bodies first .. last in
 * the order of the sweeps, which are subtrees side by side, or what stands between such subtrees.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_PARTS_H
#define MBSRI_SWEEPS_PARTS_H

#include "sweeps/backward.h"
#include "sweeps/forward.h"
#include "sweeps/inverse.h"
#include "sweeps/momentum.h"
#include "sweeps/motion.h"
#include "sweeps/split.h"

static int part_move(const mbsri_sweep_run *run, int first, int last, bool velocity)
{
    return velocity ? move_part(run, first, last, true, false)
                    : move_part(run, first, last, false, false);
}

/* ---- the backward recursion ---- */

MBSRI_INLINE bool back_through(const mbsri_sweep_run *run, int first, int last, bool exact,
                               bool kept, mbsri_part_state *state)
{
    back at;
    from_memory(&state->carry, &at.c);
    if (exact) from_memory(&state->noise, &at.W);
    at.top = state->stack;
    at.noise_top = state->noises;
    for (int i = last; i >= first; --i) {
        if (!pass_part(run, i, exact, false, kept && i == first, &at)) return false;
    }
    to_memory(&at.c, &state->carry);
    if (exact) to_memory(&at.W, &state->noise);
    state->stack = at.top;
    state->noises = at.noise_top;
    return true;
}

static bool part_backward(const mbsri_sweep_run *run, int first, int last, bool exact, bool kept,
                          mbsri_part_state *state)
{
    return exact ? back_through(run, first, last, true, kept, state)
                 : back_through(run, first, last, false, kept, state);
}

static void join_backward(int flags, bool exact, mbsri_part_state *state)
{
    back at;
    from_memory(&state->carry, &at.c);
    from_memory(&state->noise, &at.W);
    at.top = state->stack;
    at.noise_top = state->noises;
    hand_on(flags, exact, &at);
    state->stack = at.top;
    state->noises = at.noise_top;
}

/* ---- momenta ---- */

MBSRI_INLINE void flow_from_memory(const mbsri_flow *m, flow *f)
{
    f->L = load(m->L), f->p = load(m->p);
    f->N = load(m->N), f->F = load(m->F);
    f->L_bar = load(m->L_bar), f->p_bar = load(m->p_bar);
}

static void part_momentum(const mbsri_sweep_run *run, int first, int last, bool kept,
                          mbsri_part_state *state)
{
    const v4 g = load3(run->tree->gravity);
    flows at = {.top = state->flows};
    flow_from_memory(&state->flow, &at.f);
    for (int i = last; i >= first; --i) pass_flow(run, i, g, false, kept && i == first, &at);
    flow_to_memory(&at.f, &state->flow);
    state->flows = at.top;
}

static void join_momentum(int flags, mbsri_part_state *state)
{
    flows at = {.top = state->flows};
    flow_from_memory(&state->flow, &at.f);
    hand_flow_on(flags, &at);
    state->flows = at.top;
}

static void part_balance(const mbsri_sweep_run *run, int first, int last)
{
    balance_part(run, first, last, false);
}

/* ---- inverse dynamics ---- */

static int part_accelerate(const mbsri_sweep_run *run, int first, int last)
{
    return accelerate_part(run, first, last);
}

static void part_loads(const mbsri_sweep_run *run, int first, int last, bool kept,
                       mbsri_part_state *state)
{
    sums at = {load(state->flow.L), load(state->flow.p), state->flows};
    for (int i = last; i >= first; --i) add_load(run, run->tree, i, false, kept && i == first, &at);
    store(state->flow.L, at.L);
    store(state->flow.p, at.p);
    state->flows = at.top;
}

static void join_loads(int flags, mbsri_part_state *state)
{
    sums at = {load(state->flow.L), load(state->flow.p), state->flows};
    hand_sums_on(flags, &at);
    state->flows = at.top;
}

/* ---- the forward recursion ---- */

static void part_forward(const mbsri_sweep_run *run, int first, int last)
{
    forward_part(run, first, last);
}

/* ---- momenta of large trees ---- */

/* Backward and momentum, one after the other for some bodies at a time, which stay in the cache
 * between. */
MBSRI_INLINE bool in_pieces(const mbsri_sweep_run *run, bool loaded)
{
    enum { PIECE = 128 };
    const v4 none = splat(0.0), g = load3(run->tree->gravity);
    back at;
    flows moving = {{none, none, none, none, none, none}, run->flows};
    start_back(run, &at);
    for (int last = run->tree->bodies; last >= 1; last -= PIECE) {
        const int first = last > PIECE ? last - PIECE + 1 : 1;
        for (int i = last; i >= first; --i) {
            if (!pass_body(run, i, false, false, &at)) return false;
        }
        for (int i = last; i >= first; --i) pass_flow(run, i, g, loaded, false, &moving);
        balance_part(run, first, last, false);
    }
    return true;
}

static bool momenta(const mbsri_sweep_run *run)
{
    return run->load ? in_pieces(run, true) : in_pieces(run, false);
}

static const mbsri_part_kernels part_kernels = {
    part_move,     part_backward, part_momentum,   part_loads,   join_backward,
    join_momentum, join_loads,    part_accelerate, part_balance, part_forward};

#endif
