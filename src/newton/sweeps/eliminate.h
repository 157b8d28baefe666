/* The elimination, leaves to root, beside the backward recursion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_ELIMINATE_H
#define MBSRI_NEWTON_ELIMINATE_H

#include "newton/sweeps/border.h"
#include "newton/sweeps/element_slopes.h"
#include "newton/sweeps/multi_axis.h"
#include "newton/sweeps/reaction.h"
#include "sweeps/backward.h"
#include "sweeps/forward.h"

/* A joint of one axis on the way: C, U, the row over x_h and what it becomes. */
typedef struct passage {
    axis a;
    v4 motion[4], by_r[4]; /* of the body by du and by r_q */
    v4 C[4], U[4], row[4], K[4], Q[4];
    double E, size, gain; /* what du and r_q add to the row; the size of what was summed */
    double tau_q, tau_u;  /* slopes of the joint force over c^2 and c, the latter less armature */
    reaction t;
} passage;

/* C = P (S_w / c, S + S' / c, S_v / c) + J / c,  U = C - P (0, S, 0);
 * E du + R x_h = r_p / c + w - row . b - gain r_q */
MBSRI_INLINE void open_passage(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                               const slab *y, passage *p, bool full)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *pred = run->state + b->parent, *s = run->state + i;
    const v4 Z = load(s->R + 8), rho = load(s->rho), omega = load(pred->omega);
    const v4 by_c = splat(newton->by_c);
    axis *a = &p->a;
    a->S_w = b->flags & MBSRI_TURNS ? Z : splat(0.0);
    a->S_v = splat(b->pitch) * Z;
    a->rate_w = cross(omega, a->S_w);
    a->rate_v = cross(omega, a->S_v) + cross(load(pred->v) + cross(omega, rho), a->S_w);
    finish_axis(y, newton->by_c, a);
    p->motion[ROTATION] = p->by_r[ROTATION] = by_c * a->S_w;
    p->by_r[SPIN] = by_c * a->rate_w;
    p->by_r[DRIFT] = by_c * a->rate_v;
    p->motion[SPIN] = a->S_w + p->by_r[SPIN];
    p->motion[DRIFT] = a->S_v + p->by_r[DRIFT];
    p->motion[DISPLACEMENT] = p->by_r[DISPLACEMENT] = by_c * a->S_v;
    apply_slab(y, p->motion, p->C, full);
    for (int r = 0; r < groups(full); ++r) {
        p->C[r] += by_c * a->J[r];
        v4 inertia = splat(0.0);
        for (int j = 0; j < 3; ++j)
            inertia += y->P[SPIN][j][r] * splat(a->S_w[j]) + y->P[DRIFT][j][r] * splat(a->S_v[j]);
        p->U[r] = p->C[r] - inertia;
    }
    p->tau_q = newton->tau_q ? newton->tau_q[b->u] * newton->by_c * newton->by_c : 0.0;
    p->tau_u = newton->tau_u ? newton->tau_u[b->u] * newton->by_c : 0.0;
    p->E = sum3(along_row(a, by_c, p->C, full)) - p->tau_q - p->tau_u;
    p->size = size_of_row(a, by_c, p->C, full) + fabs(p->tau_q) + fabs(p->tau_u);
    p->gain = sum3(along_row(a, by_c, p->U, full)) - p->tau_q;
}

/* The row of F_p determines du. */
MBSRI_INLINE bool by_momentum(passage *p, bool full)
{
    if (!(fabs(p->E) > MBSRI_LEAST_PIVOT * p->size)) return false;
    const v4 inverse = splat(1.0 / p->E),
             SC = splat(sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]));
    for (int g = 0; g < groups(full); ++g) {
        p->K[g] = p->row[g] * inverse;
        p->Q[g] -= SC * p->K[g];
    }
    return true;
}

/* The balance of forces does; delta p = d(Mu) + r_p / c - the row of F_p. */
MBSRI_INLINE bool by_reaction(passage *p, bool full)
{
    if (!(fabs(p->t.along_C) > MBSRI_LEAST_PIVOT * p->t.size)) return false;
    const v4 inverse = splat(1.0 / p->t.along_C), E = splat(p->E),
             SC = splat(sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]));
    for (int g = 0; g < groups(full); ++g) {
        p->K[g] = p->t.row[g] * inverse;
        p->Q[g] += (E - SC) * p->K[g] - p->row[g];
    }
    return true;
}

/* Elements between the body and its predecessor: what they exert on the latter. */
MBSRI_OUTLINE void close_pair(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                              passage *p, slab *y, bool deep)
{
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    apply_slopes(&on, p->motion, p->C);
    apply_slopes(&on, p->by_r, p->U);
    add_slopes(&on, y);
    if (!deep) return;
    v4 forces[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)}, by_r[4];
    memcpy(by_r, forces, sizeof by_r);
    apply_slopes(&on, p->motion, forces);
    apply_slopes(&on, p->by_r, by_r);
    for (int r = 0; r < 2; ++r) {
        p->t.C[r] -= forces[MOMENT + r];
        p->t.U[r] -= by_r[MOMENT + r];
    }
    subtract_slopes(&on, y);
}

/* Of a deep body: psi over x_h, and what u' takes up of it. */
MBSRI_OUTLINE void pass_reaction(const mbsri_sweep_run *run, int i,
                                 const mbsri_newton_sweeps *newton, const v4 G[2], passage *p,
                                 slab *y, bool full)
{
    open_reaction(i, newton, &p->a, p->motion, p->by_r, p->tau_q,
                  p->tau_u + run->tree->body[i].armature, y, &p->t, full);
    if (is_pair(newton, i, full)) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        subtract_slopes(&by, y);
    }
    reaction_row(y, &p->a, &p->t, full);
    if (!(newton->step[i].deep & MBSRI_NO_INERTIA)) take_up(G, &p->t, y, full);
}

MBSRI_INLINE void keep_deep(mbsri_newton_sweeps *newton, int i, int u, const passage *p)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    mbsri_newton_deep *below = newton->below + u;
    store3(below->C, p->t.C[0]), store3(below->C + 3, p->t.C[1]);
    store3(below->U, p->t.U[0]), store3(below->U + 3, p->t.U[1]);
    if (!(newton->step[i].deep & MBSRI_NO_INERTIA)) return;
    below->pivot = p->E;
    below->gain = p->gain;
    col->inverse = 1.0 / p->t.along_C;
    col->gain = p->t.along_U;
}

/* A joint of one axis; false: its row is singular. */
MBSRI_INLINE bool eliminate(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, slab *y,
                            bool full, bool deep)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 rho = load(s->rho), by_c = splat(newton->by_c);
    const v4 G[2] = {load(s->U_L) * splat(s->Dinv), load(s->U_p) * splat(s->Dinv)};
    mbsri_newton_column *col = mbsri_newton_column_at(newton, b->u);
    passage p;
    memset(&p.t, 0, sizeof p.t);
    open_passage(run, i, newton, y, &p, full);
    const bool pair = is_pair(newton, i, full);
    if (deep) pass_reaction(run, i, newton, G, &p, y, full);
    if (pair) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        add_slopes(&by, y);
    }
    joint_row(y, &p.a, by_c, p.row, full);
    momentum_row(y, p.a.S_w, p.a.S_v, p.Q, full);
    const bool balance_of_forces = deep && newton->step[i].deep & MBSRI_NO_INERTIA;
    if (!(balance_of_forces ? by_reaction(&p, full) : by_momentum(&p, full))) return false;
    if (pair) close_pair(run, i, newton, &p, y, deep);
    if (b->parent > 0) subtract_column(y, p.C, p.K, full);
    if (deep) subtract_reaction(y, p.t.C, p.K, full);
    translate_row(rho, p.K, full);
    translate_row(rho, p.Q, full);
    keep_column(col, &p.a, p.K, p.Q, p.C, p.U, G, full);
    col->inverse = 1.0 / p.E;
    col->gain = p.gain;
    if (deep) keep_deep(newton, i, b->u, &p);
    return true;
}

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

/* A weld: only elements act through it. */
MBSRI_OUTLINE void pass_weld(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                             slab *y, bool deep)
{
    slopes by, on;
    place_by_predecessor(run, i, newton, &by);
    place_on_predecessor(run, i, newton, &on);
    add_slopes(&by, y);
    add_slopes(&on, y);
    if (!deep) return;
    subtract_slopes(&by, y);
    subtract_slopes(&on, y);
}

/* To the predecessor, whose slab this is. */
MBSRI_INLINE void queue(int flags, elimination *at, bool full, bool deep)
{
    slab *y = &at->y;
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) {
        add_slab(--at->top, y, full);
        if (deep) add_reaction(at->top, y);
    }
    slab_to_memory(y, at->top, full);
    if (deep) reaction_to_memory(y, at->top);
    ++at->top;
}

/* From body i to its predecessor. */
MBSRI_INLINE void hand_over(const mbsri_sweep_run *run, int i, elimination *at, bool full,
                            bool deep)
{
    const int flags = run->tree->body[i].flags;
    const v4 rho = load(run->state[i].rho);
    translate_slab(rho, &at->y, full);
    if (deep) translate_reaction(rho, &at->y, full);
    queue(flags, at, full, deep);
}

/* Past body i, which the backward sweep has passed, too; false: the rows of its joint are singular.
 * any: there are deep bodies. What reaches others of Y is not used. */
MBSRI_INLINE bool eliminate_body(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 elimination *at, bool full, bool any)
{
    const mbsri_sweeps *tree = run->tree;
    const mbsri_sweep_body *b = tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 g = load3(tree->gravity);
    const int flags = b->flags;
    const bool deep = any && newton->step[i].deep & MBSRI_DEEP;
    slab *y = &at->y;
    expect_column(newton, b->u - 2);
    if (flags & MBSRI_LEAF) clear_slab(y, full);
    if (any && flags & MBSRI_LEAF) clear_reaction(y);
    if (flags & MBSRI_BRANCHES) {
        add_slab(--at->top, y, full);
        if (any) add_reaction(at->top, y);
    }
    if (!(flags & MBSRI_MASSLESS)) add_own_slab(b, s, g, y);
    if (full && flags & MBSRI_LOADED) add_elements(run, i, newton, y, deep);
    if (flags & MBSRI_MULTI) {
        _Alignas(32) mbsri_newton_carry multi;
        slab_to_memory(y, &multi, full);
        if (!eliminate_multi(run, i, newton, &multi, full)) return false;
        clear_slab(y, full);
        add_slab(&multi, y, full);
    } else if (b->n) {
        if (!eliminate(run, i, newton, y, full, deep)) return false;
    } else if (is_pair(newton, i, full)) {
        pass_weld(run, i, newton, y, deep);
    }
    store(newton->step[i].rho, load(s->rho));
    if (b->parent > 0) hand_over(run, i, at, full, any);
    return true;
}

MBSRI_INLINE void start_elimination(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton,
                                    elimination *at, bool full)
{
    clear_slab(&at->y, full);
    at->top = newton->carry;
    for (int i = 1; i <= run->tree->bodies && full; ++i) place_own(run, i, newton->own + i);
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

/* After the backward sweep, where the bound does not tell or bodies are deep; their reactions are
 * known. */
MBSRI_INLINE int deep_sweep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, bool full)
{
    elimination of;
    start_elimination(run, newton, &of, full);
    clear_reaction(&of.y);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!eliminate_body(run, i, newton, &of, full, true)) return i;
    }
    return 0;
}

static int newton_factor_deep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    if (!backward(run) || !find_deep(run, newton)) return MBSRI_NOT_CLEAR;
    newton->unclear = true;
    if (newton->deep) forward(run);
    if (newton->deep) find_reactions(run, newton);
    return run->load ? deep_sweep(run, newton, true) : deep_sweep(run, newton, false);
}

/* ---- trees with blocks ---- */

/* Past block i; false: see newton->status. */
MBSRI_OUTLINE bool eliminate_block(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                   elimination *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const bool deep = newton->deep;
    _Alignas(32) mbsri_newton_carry carry;
    newton->status = mbsri_border_eliminate(run, newton, i, &carry);
    if (newton->status) return false;
    if (b->parent == 0 || b->flags & MBSRI_TO_BLOCK) return true;
    const v4 arm = load(newton->own[b->parent].arm);
    slab *y = &at->y;
    clear_slab(y, true);
    clear_reaction(y);
    add_slab(&carry, y, true);
    if (deep) add_reaction(&carry, y);
    translate_slab(arm, y, true);
    if (deep) translate_reaction(arm, y, true);
    queue(b->flags, at, true, deep);
    return true;
}

MBSRI_OUTLINE void give_slab(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             const elimination *at)
{
    _Alignas(32) mbsri_newton_carry carry;
    slab_to_memory(&at->y, &carry, true);
    if (newton->deep) reaction_to_memory(&at->y, &carry);
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
        if (!eliminate_body(run, i, newton, &of, true, newton->deep)) return i;
        if (flags & MBSRI_TO_BLOCK) give_slab(run, i, newton, &of);
    }
    newton->status = mbsri_border_close(run, newton);
    return newton->status ? MBSRI_BLOCK_FAILED : 0;
}

/* After the backward sweep, as there. */
static int newton_factor_mixed(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    if (!backward(run) || !find_deep(run, newton)) return MBSRI_NOT_CLEAR;
    if (newton->deep) {
        forward(run);
        memcpy(run->data->udot, run->out, (size_t)run->model->nu * sizeof *run->out);
        find_reactions(run, newton);
    }
    newton->status = mbsri_border_open(run, newton);
    if (!newton->status) newton->status = mbsri_block_open_momentum(run);
    return newton->status ? MBSRI_BLOCK_FAILED : mixed_sweep(run, newton);
}

#endif
