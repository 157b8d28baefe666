/* The backward recursion (17) of the vectorised sweeps, leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_BACKWARD_H
#define MBSRI_SWEEPS_BACKWARD_H

#include "sweeps/block_bound.h"
#include "sweeps/carry.h"
#include "sweeps/multi_axis.h"
#include "sweeps/rank_bound.h"

#include <math.h>

/* What the forward sweep needs of the joint. */
MBSRI_INLINE void keep_factors(const mbsri_sweep_run *run, int i, const joint *j)
{
    mbsri_sweep_state *s = run->state + i;
    run->rank[i] = j->Dinv > 0.0;
    store(s->U_L, j->U_L);
    store(s->U_p, j->U_p);
    s->D = j->D;
    s->Dinv = j->Dinv;
    s->e = j->e;
}

/* Mbar^a = Mbar - U D^-1 U^T,  p += U D^-1 e, about the point that U is about. */
MBSRI_INLINE void condense(const joint *j, v4 U_L, v4 U_p, blocks *c)
{
    const v4 Dinv = splat(j->Dinv), e = splat(j->e), g_L = U_L * Dinv, g_p = U_p * Dinv;
    subtract_dyad(g_L, g_p, U_L, U_p, c);
    c->L += g_L * e;
    c->p += g_p * e;
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
    v4 driven_L, driven_p, swing_L, swing_p;
    column j = {.S_L = load(multi->S[0]), .S_p = load(multi->S[0] + 4), .armature = b->armature};
    times_masses(c, load(multi->drive), load(multi->drive + 4), &driven_L, &driven_p);
    store(multi->driven, driven_L);
    store(multi->driven + 4, driven_p);
    if (!certify_column(run->tree, b->soft, c, &j, &c->kappa, &c->spread)) return false;
    const double e = run->tau[b->u] - sum3(j.S_L * c->L + j.S_p * c->p);
    run->rank[i] = 1;
    store(multi->U[0], j.U_L), store(multi->U[0] + 4, j.U_p);
    store(multi->G[0], j.g_L), store(multi->G[0] + 4, j.g_p);
    multi->D[0][0] = j.D;
    multi->factor[0][0] = 1.0 / j.D;
    multi->x[0] = b->parent > 0 ? e / j.D : e;
    subtract_dyad(j.g_L, j.g_p, j.U_L, j.U_p, c);
    times_masses(c, load(s->A_w), load(s->A_v), &swing_L, &swing_p);
    c->L += swing_L + j.g_L * splat(e);
    c->p += swing_p + j.g_p * splat(e);
    return true;
}

/* Through a joint of other than one axis. */
MBSRI_INLINE bool pass_axes(const mbsri_sweep_run *run, int i, blocks *c, blocks *W)
{
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

/* Through a joint of one axis, whose flags the compiler may know, and to the predecessor's point.
 * The articulated inertia is that of all mass there, moved with the joint locked, less what the
 * joint gives way: the next body waits for U, D and one product only. */
MBSRI_INLINE bool pass_axis(const mbsri_sweep_run *run, int i, int flags, blocks *c, blocks *W)
{
    const v4 rho = load(run->state[i].rho);
    joint j;
    open_joint(run, i, flags, c, &j);
    if (!(W ? judge(run, i, c, &j, W) : certify(run, i, c, &j))) return false;
    keep_factors(run, i, &j);
    translate(rho, c);
    condense(&j, j.U_L + cross(rho, j.U_p), j.U_p, c);
    return true;
}

/* The same where flags are looked up. */
MBSRI_OUTLINE bool pass_any_axis(const mbsri_sweep_run *run, int i, blocks *c)
{
    return pass_axis(run, i, run->tree->body[i].flags, c, NULL);
}

/* Through the joint of body i, of whatever kind, and to the predecessor's point; W: NULL without
 * it. */
MBSRI_INLINE bool pass_joint(const mbsri_sweep_run *run, int i, blocks *c, blocks *W)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const int kind = b->flags & (MBSRI_MULTI | MBSRI_TURNS | MBSRI_SLIDES);
    const v4 rho = load(run->state[i].rho);
    if (!W && kind == MBSRI_TURNS) {
        const int flags = MBSRI_TURNS | (b->flags & (MBSRI_LEVEL | MBSRI_FLAT));
        const double spread = b->spread;
        if (!pass_axis(run, i, flags, c, NULL)) return false;
        c->spread *= spread;
        return true;
    }
    if (kind & MBSRI_MULTI) {
        if (!pass_axes(run, i, c, W)) return false;
        translate(rho, c);
    } else if (W) {
        if (!pass_axis(run, i, b->flags, c, W)) return false;
    } else {
        blocks copy = *c; /* the carry itself stays in registers */
        if (!pass_any_axis(run, i, &copy)) return false;
        *c = copy;
    }
    if (W)
        translate(rho, W);
    else
        c->spread *= stretch(run, i);
    return true;
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

/* What a body in space in the sweeps gets of block i, about its own point (see collect, block.c):
 * p = H^T mu + Mbar (0, g + omega x (omega x arm)). */
MBSRI_OUTLINE void collect_blocks(const mbsri_sweep_run *run, int i, blocks *c)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *data = run->data;
    const double *bound = run->load[i].bound;
    double y[6] = {0.0};
    matrix_to_blocks(data->Mbar + b->pred.dd, c);
    mbsri_atx(b->d, 6, 1.0, data->H + b->dp, data->mu + b->v, y);
    const v4 omega = load(run->state[b->parent].omega), arm = load(run->load[b->parent].arm);
    const v4 a = load3(run->tree->gravity) + cross(omega, cross(omega, arm));
    c->L = (v4){y[0], y[1], y[2], 0.0} + cyclic_transposed_times(c->G, a);
    c->p = (v4){y[3], y[4], y[5], 0.0} + symmetric_times(c->M, a);
    translate(arm, c);
    const double ratio = 1.0 + sqrt(sum3(arm * arm)) / run->tree->length;
    c->kappa = bound[0];
    c->spread = bound[1] * ratio * ratio;
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

/* What comes together at body i: its own, with its successors', and loads. */
MBSRI_INLINE void gather_masses(const mbsri_sweep_run *run, int i, bool exact, back *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const int flags = b->flags;
    blocks *c = &at->c, *W = &at->W;
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
}

/* m |r|^2 of the arm before what the body slides along, which may take it back to nothing but
 * rounding (mbsri_trace_of_arms in recursion/errors.h), a share of it: see squared_sweep_arm. */
MBSRI_INLINE double trace_of_arm(const mbsri_sweep_body *b, const blocks *c)
{
    if (!(b->flags & (MBSRI_SLIDES | MBSRI_MULTI))) return 0.0;
    const v4 x = load3(b->x);
    return 1e-3 * sum3(x * x) * fmax(c->M[0][0], fmax(c->M[0][1], c->M[0][2]));
}

/* Past body i; false: its rank is not clear. any: there are blocks. kept: the carry is not handed
 * on. */
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
    gather_masses(run, i, exact, at);
    if (!pass_joint(run, i, c, exact ? W : NULL)) return false;
    if (exact) W->spread += trace_of_arm(b, c);
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

/* By the exact bound, which costs more than asking each body what it is. */
MBSRI_OUTLINE bool sweep_exactly(const mbsri_sweep_run *run)
{
    return sweep_back(run, true, true);
}

MBSRI_INLINE bool backward(const mbsri_sweep_run *run)
{
    if (run->tree->whole || run->tree->modal) return sweep_exactly(run);
    if (run->tree->blocks > 0) return sweep_back(run, false, true) || sweep_exactly(run);
    return sweep_back(run, false, false) || sweep_exactly(run);
}

#endif
