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

/* A of the body before, in registers: mostly the predecessor. */
typedef struct acceleration {
    v4 w, v;
} acceleration;

MBSRI_INLINE void acceleration_from_memory(const mbsri_sweep_state *s, acceleration *A)
{
    A->w = load(s->A_w);
    A->v = load(s->A_v);
}

/* A: of the predecessor, then of the body. any: there are blocks, or force elements on bodies. */
MBSRI_INLINE void accelerate(const mbsri_sweep_run *run, int i, const mbsri_sweep_body *b,
                             mbsri_sweep_state *s, bool any, acceleration *A)
{
    /* in the order of forward.h, whose rounding this then has, too */
    A->v += cross(A->w, load(s->rho)) + load(s->A_v);
    A->w += load(s->A_w);
    if (b->flags & MBSRI_MULTI) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->multi[b->multi].S[k];
            const v4 udot = splat(run->tau[b->u + k]);
            A->w += load(S) * udot;
            A->v += load(S + 4) * udot;
        }
    } else if (b->flags & (MBSRI_TURNS | MBSRI_SLIDES)) {
        const v4 Z = load(s->R + 8);
        const v4 udot = splat(run->tau[b->u]);
        if (b->flags & MBSRI_TURNS) A->w += Z * udot;
        if (b->flags & MBSRI_SLIDES) A->v += Z * (splat(b->pitch) * udot);
    }
    /* in the place of U */
    v4 L = splat(0.0), p = splat(0.0);
    if (!(b->flags & MBSRI_MASSLESS)) own_load(b, s, A->w, A->v, &L, &p);
    store(s->A_w, A->w);
    store(s->A_v, A->v);
    if (any && b->flags & MBSRI_LOADED) {
        L -= load(run->load[i].L);
        p -= load(run->load[i].p);
    }
    store(s->U_L, L);
    store(s->U_p, p);
}

/* The sums to the leaves, which stay in registers or, at branches, on the stack of the momentum
 * form. */
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
    mbsri_sweep_state *state = run->state;
    int at = -1; /* the body whose motion is in registers */
    motion m = {0};
    acceleration A = {0};
    for (int i = first; i <= last; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        mbsri_sweep_state *s = state + i;
        if (b->parent != at) {
            motion_from_memory(state + b->parent, false, &m);
            acceleration_from_memory(state + b->parent, &A);
        }
        if (b->flags & MBSRI_MULTI) {
            const int status = multi_kinematics(run, i, false);
            if (status) return status;
            motion_from_memory(s, false, &m);
        } else {
            move_body(run, b, false, s, &m);
        }
        accelerate(run, i, b, s, false, &A);
        at = i;
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
        const mbsri_sweep_body *b = tree->body + i;
        mbsri_sweep_state *s = run->state + i;
        if (b->flags & MBSRI_BLOCK) {
            mbsri_block_accelerate(run, i);
            continue;
        }
        acceleration A;
        acceleration_from_memory(run->state + b->parent, &A);
        accelerate(run, i, b, s, true, &A);
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
