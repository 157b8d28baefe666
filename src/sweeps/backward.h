/* The backward recursion (17) of the vectorised sweeps, leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_BACKWARD_H
#define MBSRI_SWEEPS_BACKWARD_H

#include "sweeps/block_bound.h"
#include "sweeps/carry.h"
#include "sweeps/multi_axis.h"
#include "sweeps/rank_bound.h"

#include <math.h>

/* Mbar^a = Mbar - U D^-1 U^T,  p += Mbar^a c + U D^-1 e, at body i's origin. */
MBSRI_INLINE void condense(const mbsri_sweep_run *run, int i, const joint *j, blocks *c)
{
    mbsri_sweep_state *s = run->state + i;
    const v4 c_w = load(s->A_w), c_v = load(s->A_v), U_L = j->U_L, U_p = j->U_p;
    run->rank[i] = j->Dinv > 0.0;
    store(s->U_L, U_L);
    store(s->U_p, U_p);
    s->D = j->D;
    s->Dinv = j->Dinv;
    s->e = j->e;
    const v4 g_L = U_L * splat(j->Dinv), g_p = U_p * splat(j->Dinv), e = splat(j->e);
    c->I[0] -= g_L * xxx(U_L), c->I[1] -= g_L * yyy(U_L), c->I[2] -= g_L * zzz(U_L);
    c->G[0] -= g_p * xxx(U_L), c->G[1] -= g_p * yyy(U_L), c->G[2] -= g_p * zzz(U_L);
    c->M[0] -= g_p * xxx(U_p), c->M[1] -= g_p * yyy(U_p), c->M[2] -= g_p * zzz(U_p);
    c->L += times(c->I, c_w) + transposed_times(c->G, c_v) + g_L * e;
    c->p += times(c->G, c_w) + times(c->M, c_v) + g_p * e;
}

/* ||X||^2 <= (1 + |rho| / L)^2, a constant unless the joint slides. */
MBSRI_INLINE double stretch(const mbsri_sweep_run *run, int i)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    if (!(b->flags & (MBSRI_SLIDES | MBSRI_MULTI))) return b->spread;
    const v4 rho = load(run->state[i].rho);
    const double ratio = 1.0 + sqrt(sum3(rho * rho)) / run->tree->length;
    return ratio * ratio;
}

/* A joint with one rate in any direction, by the bound: as multi_backward, in registers. */
MBSRI_OUTLINE bool pass_column(const mbsri_sweep_run *run, int i, blocks *c)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const v4 drive_w = load(multi->drive), drive_v = load(multi->drive + 4), c_w = load(s->A_w),
             c_v = load(s->A_v);
    column j = {.S_L = load(multi->S[0]), .S_p = load(multi->S[0] + 4), .armature = b->armature};
    store(multi->driven, times(c->I, drive_w) + transposed_times(c->G, drive_v));
    store(multi->driven + 4, times(c->G, drive_w) + times(c->M, drive_v));
    if (!certify_column(run->tree, b->soft, c, &j, &c->kappa, &c->spread)) return false;
    const double e = run->tau[b->u] - sum3(j.S_L * c->L + j.S_p * c->p);
    run->rank[i] = 1;
    store(multi->U[0], j.U_L), store(multi->U[0] + 4, j.U_p);
    store(multi->G[0], j.g_L), store(multi->G[0] + 4, j.g_p);
    multi->D[0][0] = j.D;
    multi->factor[0][0] = 1.0 / j.D;
    multi->x[0] = b->parent > 0 ? e / j.D : e;
    condense_column(&j, c);
    c->L += times(c->I, c_w) + transposed_times(c->G, c_v) + j.g_L * splat(e);
    c->p += times(c->G, c_w) + times(c->M, c_v) + j.g_p * splat(e);
    return true;
}

/* Through the joint of body i, of whatever kind; W: NULL without it. */
MBSRI_INLINE bool pass_joint(const mbsri_sweep_run *run, int i, blocks *c, blocks *W)
{
    if (run->tree->body[i].flags & MBSRI_MULTI) {
        if (!W && run->tree->body[i].n == 1) {
            blocks copy = *c; /* the carry itself stays in registers */
            if (!pass_column(run, i, &copy)) return false;
            *c = copy;
            return true;
        }
        _Alignas(32) mbsri_carry m, noise;
        to_memory(c, &m);
        if (W) to_memory(W, &noise);
        if (!multi_backward(run, i, &m, W ? &noise : NULL)) return false;
        from_memory(&m, c);
        if (W) from_memory(&noise, W);
        return true;
    }
    joint j;
    open_joint(run, i, c, &j);
    const bool clear = W ? judge(run, i, c, &j, W) : certify(run, i, c, &j);
    if (clear) condense(run, i, &j, c);
    return clear;
}

/* Where the sweep stands: the carry, W beside it, and the places where they wait at branches. */
typedef struct back {
    blocks c, W;
    mbsri_carry *top, *noise_top;
} back;

MBSRI_INLINE void start_back(const mbsri_sweep_run *run, back *at)
{
    clear(&at->c);
    clear(&at->W);
    at->top = run->stack;
    at->noise_top = run->noise;
}

/* Through a body of another kind, which reads and leaves the carry of its predecessor's point. */
MBSRI_OUTLINE bool pass_block(const mbsri_sweep_run *run, int i, bool exact, back *at)
{
    const bool bounded = !exact && run->tree->body[i].flags & MBSRI_BOUNDED;
    if (bounded) {
        mbsri_block_before_bound(run, i);
        if (!pass_bounded(run, i)) return false;
    }
    if (bounded && run->tree->body[i].flags & MBSRI_SIX) {
        collect_blocks(run, i, &at->c);
        return true;
    }
    _Alignas(32) mbsri_carry c, W;
    memset(&c, 0, sizeof c);
    memset(&W, 0, sizeof W);
    if (bounded)
        mbsri_block_after_bound(run, i, &c);
    else if (!mbsri_block_backward(run, i, exact, &c, &W))
        return false;
    from_memory(&c, &at->c);
    if (exact) from_memory(&W, &at->W);
    return true;
}

/* The same of one block alone. */
MBSRI_INLINE bool block_backward(const mbsri_sweep_run *run, int i, mbsri_carry *c)
{
    back at;
    clear(&at.c);
    if (!pass_block(run, i, false, &at)) return false;
    to_memory(&at.c, c);
    return true;
}

MBSRI_OUTLINE void give_to_block(const mbsri_sweep_run *run, int i, bool exact, const back *at)
{
    _Alignas(32) mbsri_carry c, W;
    to_memory(&at->c, &c);
    if (exact) to_memory(&at->W, &W);
    mbsri_block_receive(run, run->tree->body[i].parent, &c, exact ? &W : NULL);
}

/* To the predecessor, whose carry this is. */
MBSRI_INLINE void hand_on(int flags, bool exact, back *at)
{
    if (flags & MBSRI_NEXT) return;
    const bool opens = (flags & MBSRI_OPENS) != 0;
    if (!opens) add(--at->top, &at->c);
    to_memory(&at->c, at->top++);
    if (!exact) return;
    if (!opens) add(--at->noise_top, &at->W);
    to_memory(&at->W, at->noise_top++);
}

/* Past body i; false: its rank is not clear. any: there are blocks. kept: the carry is not handed on. */
MBSRI_INLINE bool pass_part(const mbsri_sweep_run *run, int i, bool exact, bool any, bool kept,
                            back *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const int flags = b->flags;
    blocks *c = &at->c, *W = &at->W;
    if (any && flags & MBSRI_BLOCK) {
        if (!pass_block(run, i, exact, at)) return false;
        if (!(flags & MBSRI_TO_BLOCK)) hand_on(flags, exact, at);
        return true;
    }
    if (flags & MBSRI_LEAF) clear(c);
    if (exact && flags & MBSRI_LEAF) clear(W);
    if (flags & MBSRI_BRANCHES) add(--at->top, c);
    if (exact && flags & MBSRI_BRANCHES) add(--at->noise_top, W);
    if (!(flags & MBSRI_MASSLESS)) add_own(b, run->state + i, c);
    if (exact && !(flags & MBSRI_PLANE)) W->spread += b->I[0] + b->I[5] + b->I[10];
    if (flags & MBSRI_LOADED) {
        c->L -= load(run->load[i].L);
        c->p -= load(run->load[i].p);
    }
    if (!pass_joint(run, i, c, exact ? W : NULL)) return false;
    const v4 rho = load(run->state[i].rho);
    translate(rho, c);
    if (exact)
        translate(rho, W);
    else
        c->spread *= stretch(run, i);
    if (any && flags & MBSRI_TO_BLOCK) give_to_block(run, i, exact, at);
    if (!kept) hand_on(flags, exact, at);
    return true;
}

MBSRI_INLINE bool pass_body(const mbsri_sweep_run *run, int i, bool exact, bool any, back *at)
{
    return pass_part(run, i, exact, any, false, at);
}

MBSRI_INLINE bool sweep_back(const mbsri_sweep_run *run, bool exact, bool any)
{
    back at;
    start_back(run, &at);
    if (any) mbsri_block_open(run);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!pass_body(run, i, exact, any, &at)) return false;
    }
    return true;
}

MBSRI_OUTLINE bool backward(const mbsri_sweep_run *run)
{
    if (run->tree->whole) return sweep_back(run, true, true);
    if (run->tree->blocks > 0) return sweep_back(run, false, true) || sweep_back(run, true, true);
    return sweep_back(run, false, false) || sweep_back(run, true, false);
}

#endif
