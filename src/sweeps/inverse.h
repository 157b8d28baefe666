/* Inverse dynamics (recursive Newton-Euler) of the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   A_i   = X A_pi + c + S u',  (L, p)_i = M_i A_i + h_i - loads     root to leaves
 *   tau_i = S^T sum of (L, p) from i to the leaves, about i, + armature u'   leaves to root */
#ifndef MBSRI_SWEEPS_INVERSE_H
#define MBSRI_SWEEPS_INVERSE_H

#include "sweeps/block.h"
#include "sweeps/motion.h"
#include "sweeps/rank_bound.h"

/* any: there are blocks, or force elements on bodies. */
MBSRI_INLINE void accelerate(const mbsri_sweep_run *run, int i, bool any)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *pred = run->state + b->parent;
    mbsri_sweep_state *s = run->state + i;
    const v4 w = load(pred->A_w);
    v4 A_w = w + load(s->A_w), A_v = load(pred->A_v) + cross(w, load(s->rho)) + load(s->A_v);
    if (b->flags & MBSRI_MULTI) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->multi[b->multi].S[k];
            const v4 udot = splat(run->tau[b->u + k]);
            A_w += load(S) * udot;
            A_v += load(S + 4) * udot;
        }
    } else if (b->n) {
        const v4 Z = load(s->R + 8);
        const double udot = run->tau[b->u];
        if (b->flags & MBSRI_TURNS) A_w += Z * splat(udot);
        if (b->flags & MBSRI_SLIDES) A_v += Z * splat(b->pitch * udot);
    }
    store(s->A_w, A_w);
    store(s->A_v, A_v);
    /* in the place of U */
    v4 L = splat(0.0), p = splat(0.0);
    if (!(b->flags & MBSRI_MASSLESS)) own_load(b, s, A_w, A_v, &L, &p);
    if (any && b->flags & MBSRI_LOADED) {
        L -= load(run->load[i].L);
        p -= load(run->load[i].p);
    }
    store(s->U_L, L);
    store(s->U_p, p);
}

/* The sums to the leaves, which stay in registers or, at branches, on the stack of the momentum form. */
typedef struct sums {
    v4 L, p;
    mbsri_flow *top;
} sums;

MBSRI_INLINE void hand_sums_on(int flags, sums *at)
{
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) --at->top, at->L += load(at->top->L), at->p += load(at->top->p);
    store(at->top->L, at->L);
    store(at->top->p, at->p);
    ++at->top;
}

/* From body i on; kept: not handed on. */
MBSRI_INLINE void add_load(const mbsri_sweep_run *run, const mbsri_sweeps *tree, int i, bool any,
                           bool kept, sums *at)
{
    const mbsri_sweep_body *b = tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const int flags = b->flags;
    if (any && flags & MBSRI_BLOCK) {
        _Alignas(32) double force[8];
        mbsri_block_react(run, i, force, force + 4);
        at->L = load(force);
        at->p = load(force + 4);
        hand_sums_on(flags, at);
        return;
    }
    if (flags & MBSRI_LEAF) at->L = at->p = splat(0.0);
    if (flags & MBSRI_BRANCHES) --at->top, at->L += load(at->top->L), at->p += load(at->top->p);
    at->L += load(s->U_L);
    at->p += load(s->U_p);
    if (flags & MBSRI_MULTI) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->multi[b->multi].S[k];
            run->out[b->u + k] = sum3(load(S) * at->L + load(S + 4) * at->p) +
                                 run->model->armature[b->u + k] * run->tau[b->u + k];
        }
    } else if (b->n) {
        const screw S = {flags, b->pitch, load(s->R + 8)};
        run->out[b->u] = along_axis(&S, at->L, at->p, b->armature * run->tau[b->u]);
    }
    at->L += cross(load(s->rho), at->p);
    if (any && flags & MBSRI_TO_BLOCK) {
        _Alignas(32) double force[8];
        store(force, at->L);
        store(force + 4, at->p);
        mbsri_block_receive_force(run, b->parent, force, force + 4);
    }
    if (!kept) hand_sums_on(flags, at);
}

/* Motion and accelerations of bodies first .. last. */
MBSRI_INLINE int accelerate_part(const mbsri_sweep_run *run, int first, int last)
{
    const mbsri_sweeps *tree = run->tree;
    if (first > last) return 0;
    int at = tree->body[first].parent; /* the body whose motion is in registers */
    motion m;
    motion_from_memory(run->state + at, false, &m);
    for (int i = first; i <= last; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        if (b->flags & MBSRI_MULTI) {
            const int status = multi_kinematics(run, i, false);
            if (status) return status;
        } else {
            if (b->parent != at) motion_from_memory(run->state + b->parent, false, &m);
            move_body(run, b, false, run->state + i, &m);
            at = i;
        }
        accelerate(run, i, false);
    }
    return 0;
}

MBSRI_INLINE int inverse_sweep(const mbsri_sweep_run *run, bool any)
{
    const mbsri_sweeps *tree = run->tree;
    const int bodies = tree->bodies;
    const int status = any ? 0 : accelerate_part(run, 1, bodies);
    if (status) return status;
    for (int i = 1; i <= bodies && any; ++i) { /* the kinematics came before the loads */
        if (tree->body[i].flags & MBSRI_BLOCK)
            mbsri_block_accelerate(run, i);
        else
            accelerate(run, i, true);
    }
    sums at = {splat(0.0), splat(0.0), run->flows};
    for (int i = bodies; i >= 1; --i) add_load(run, tree, i, any, false, &at);
    return 0;
}

static int inverse(const mbsri_sweep_run *run)
{
    return run->load ? inverse_sweep(run, true) : inverse_sweep(run, false);
}

#endif
