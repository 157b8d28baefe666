/* Bodies that force elements tie across the tree (newton/blocks/linked.h), in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Their x and y are those of perturbation.h and reaction.h, in groups of four with an idle number: (dtheta,
 * nu_w, nu_v, xi), and (chi, phi, psi). What is tied past a joint is what a solution makes of a load on
 * its body, and of a motion of its predecessor. Bodies are passed in an order that keeps the ties few, which need not go branch by
 * branch: what one hands on stands in memory of its predecessor. */
#ifndef MBSRI_NEWTON_TIED_H
#define MBSRI_NEWTON_TIED_H

#include "newton/blocks/linked.h"
#include "newton/blocks/solve.h"
#include "newton/sweeps/eliminate.h"
#include "newton/sweeps/solve.h"

MBSRI_INLINE void add_stored(double *to, v4 x)
{
    store3(to, load3(to) + first_three(x));
}

/* + b, from `arm` beside the point of body i, as a load on it. */
static void put_load(const mbsri_newton_sweeps *newton, int i, v4 arm, const loads *f)
{
    double *to = mbsri_links_load(newton->blocks, i);
    add_stored(to + 4 * CHI_L, f->b[CHI_L] + cross(arm, f->b[CHI_P]));
    add_stored(to + 4 * CHI_P, f->b[CHI_P]);
    add_stored(to + 4 * MOMENT, f->b[MOMENT] + cross(arm, f->b[FORCE]));
    add_stored(to + 4 * FORCE, f->b[FORCE]);
    add_stored(to + 16, f->psi[PSI_L] + cross(arm, f->psi[PSI_P]));
    add_stored(to + 20, f->psi[PSI_P]);
    add_stored(to + 24, f->L_bar + cross(arm, f->p_bar));
    add_stored(to + 28, f->p_bar);
}

static void take_load_of(const mbsri_newton_sweeps *newton, int i, loads *f)
{
    const double *from = mbsri_links_load(newton->blocks, i);
    for (int r = 0; r < 4; ++r) f->b[r] = load3(from + 4 * r);
    f->psi[0] = load3(from + 16), f->psi[1] = load3(from + 20);
    f->L_bar = load3(from + 24), f->p_bar = load3(from + 28);
}

MBSRI_INLINE void keep_tied_motion(const mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    double *to = mbsri_links_motion(newton->blocks, i);
    for (int g = 0; g < 4; ++g) store3(to + 4 * g, first_three(x[g]));
}

/* ---- passes ---- */

/* The loads behind block i, to its predecessor. */
static void hand_block_loads(mbsri_newton_sweeps *newton, int i)
{
    const mbsri_newton_step *s = newton->step + i;
    _Alignas(32) mbsri_newton_flow flow;
    loads f;
    mbsri_border_reduce(newton, i, NULL, &flow);
    if (s->parent == 0 || s->flags & MBSRI_TO_BLOCK) return;
    clear_loads(&f);
    add_loads(&flow, &f, true, true);
    put_load(newton, s->parent, load(newton->own[s->parent].arm), &f);
}

/* Those behind body i past its joint, to its predecessor. */
static void hand_tied_loads(mbsri_newton_sweeps *newton, int i, const double *r)
{
    const mbsri_newton_step *s = newton->step + i;
    const bool deep = newton->deep;
    loads f;
    if (s->flags & MBSRI_BLOCK) {
        hand_block_loads(newton, i);
        return;
    }
    take_load_of(newton, i, &f);
    condense_joint(newton, s, i, s->flags, parts_of(newton->model, r, NULL), &f, true, deep, true);
    if (s->parent == 0) return;
    if (!(s->flags & MBSRI_TO_BLOCK)) {
        put_load(newton, s->parent, load(s->rho), &f);
        return;
    }
    mbsri_newton_flow *top = newton->flow;
    hand_loads_over(s, &f, &top, true, deep);
    give_loads(newton, i, &f, deep);
}

static void reduce_tied(mbsri_newton_sweeps *newton, int i)
{
    const mbsri_newton_step *s = newton->step + i;
    if (s->parent > 0 && !(s->flags & MBSRI_TO_BLOCK)) {
        double *above = mbsri_links_load(newton->blocks, s->parent);
        for (int k = 0; k < MBSRI_TIED_LOAD; ++k) above[k] = 0.0;
    }
    if (!(s->flags & MBSRI_BLOCK)) { /* no r_u */
        double *own = mbsri_links_load(newton->blocks, i);
        for (int k = MBSRI_SWEPT_ACTIONS; k < MBSRI_TIED_LOAD; ++k) own[k] = 0.0;
    }
    hand_tied_loads(newton, i, NULL);
}

/* x of body i's predecessor, where that or the body is in vector code. */
static void motion_above(const mbsri_newton_sweeps *newton, int i, v4 x[4])
{
    const mbsri_newton_step *s = newton->step + i;
    for (int g = 0; g < 4; ++g) x[g] = splat(0.0);
    if (s->parent == 0) return;
    if (!(s->flags & MBSRI_TO_BLOCK)) {
        const double *from = mbsri_links_motion(newton->blocks, s->parent);
        for (int g = 0; g < 4; ++g) x[g] = load3(from + 4 * g);
    } else if (!(s->flags & MBSRI_BLOCK)) {
        take_motion(newton, i, x);
    }
}

static void move_tied(mbsri_newton_sweeps *newton, int i, const double *r, double *delta)
{
    const mbsri_newton_step *s = newton->step + i;
    v4 x[4];
    motion_above(newton, i, x);
    if (s->flags & MBSRI_BLOCK) {
        if (s->parent > 0 && !(s->flags & MBSRI_TO_BLOCK)) {
            report_motion(newton, s->parent, x, mbsri_border_room(newton, s->parent));
            mbsri_border_still(newton, s->parent);
        }
        mbsri_tree_move(newton->blocks, i);
        return;
    }
    move_joint(newton, s, i, s->flags, r, solution_of(newton->model, delta), x, true, true);
    keep_tied_motion(newton, i, x);
}

static void tell_tied(const mbsri_newton_sweeps *newton, int i, const double *x, double *motion)
{
    const v4 at[4] = {load3(x), load3(x + 4), load3(x + 8), load3(x + 12)};
    report_motion(newton, i, at, motion);
}

static void act_tied(const mbsri_newton_sweeps *newton, int i, const double *f, double *y)
{
    loads of;
    clear_loads(&of);
    add_wrench(newton, i, f, &of, newton->deep);
    for (int r = 0; r < 4; ++r) store3(y + 4 * r, load3(y + 4 * r) + first_three(of.b[r]));
    for (int r = 0; r < 2; ++r)
        store3(y + 16 + 4 * r, load3(y + 16 + 4 * r) + first_three(of.psi[r]));
}

static const mbsri_link_passes tied_passes = {reduce_tied, move_tied, tell_tied, act_tied};

/* ---- elimination ---- */

/* What stands in memory for body i, and its own. */
static void gather_tied(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                        slab *y)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const double *own = mbsri_links_own(newton->blocks, i),
                 *sums = newton->blocks->links.sums + MBSRI_TIED_SUMS * (size_t)i;
    for (int g = 0; g < 4; ++g, own += MBSRI_SWEPT_ACTIONS) {
        for (int j = 0; j < 3; ++j, own += MBSRI_SWEPT_ACTIONS) {
            for (int r = 0; r < 4; ++r) y->P[g][j][r] = load3(own + 4 * r);
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] = load3(own + 16 + 4 * r);
        }
    }
    y->L = load3(sums), y->p = load3(sums + 4);
    y->N = load3(sums + 8), y->F = load3(sums + 12);
    if (!(b->flags & MBSRI_MASSLESS)) add_own_slab(b, run->state + i, load3(run->tree->gravity), y);
    if (b->flags & MBSRI_LOADED)
        add_elements(run, i, newton, y, newton->deep && newton->step[i].deep & MBSRI_DEEP);
}

/* To the predecessor, about whose point it is. */
static void hand_slab(const mbsri_newton_sweeps *newton, int parent, const slab *y)
{
    double *own = mbsri_links_own(newton->blocks, parent),
           *sums = newton->blocks->links.sums + MBSRI_TIED_SUMS * (size_t)parent;
    for (int g = 0; g < 4; ++g, own += MBSRI_SWEPT_ACTIONS) {
        for (int j = 0; j < 3; ++j, own += MBSRI_SWEPT_ACTIONS) {
            for (int r = 0; r < 4; ++r) add_stored(own + 4 * r, y->P[g][j][r]);
            for (int r = 0; r < 2 && newton->deep; ++r) add_stored(own + 16 + 4 * r, y->Y[g][j][r]);
        }
    }
    add_stored(sums, y->L), add_stored(sums + 4, y->p);
    add_stored(sums + 8, y->N), add_stored(sums + 12, y->F);
}

/* Block i; false: see newton->status. */
static bool eliminate_tied_block(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    _Alignas(32) mbsri_newton_carry carry;
    slab y;
    newton->status = mbsri_border_eliminate(run, newton, i, &carry);
    if (newton->status) return false;
    if (b->parent == 0 || b->flags & MBSRI_TO_BLOCK) return true;
    const v4 arm = load(newton->own[b->parent].arm);
    clear_slab(&y, true);
    clear_reaction(&y);
    add_slab(&carry, &y, true);
    if (newton->deep) add_reaction(&carry, &y);
    translate_slab(arm, &y, true);
    if (newton->deep) translate_reaction(arm, &y, true);
    hand_slab(newton, b->parent, &y);
    return true;
}

/* Body i in vector code; false: its rows are singular. */
static bool eliminate_tied(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const bool deep = newton->deep && newton->step[i].deep & MBSRI_DEEP;
    const v4 rho = load(run->state[i].rho);
    elimination at;
    gather_tied(run, i, newton, &at.y);
    if (!eliminate_joint(run, i, newton, &at.y, true, deep)) return false;
    store(newton->step[i].rho, rho);
    if (b->parent == 0) return true;
    translate_slab(rho, &at.y, true);
    if (newton->deep) translate_reaction(rho, &at.y, true);
    if (b->flags & MBSRI_TO_BLOCK)
        give_slab(run, i, newton, &at);
    else
        hand_slab(newton, b->parent, &at.y);
    return true;
}

static int tied_sweep(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    mbsr_newton *w = newton->blocks;
    for (int i = 1; i <= run->tree->bodies; ++i) place_own(run, i, newton->own + i);
    newton->status = mbsri_links_open(w, run->data, &tied_passes);
    if (newton->status) return MBSRI_BLOCK_FAILED;
    for (int k = 0; k < run->model->bodies; ++k) {
        const int i = mbsri_links_turn(w, k);
        if (i > run->tree->bodies) continue; /* welded to another */
        if (run->tree->body[i].flags & MBSRI_BLOCK) {
            if (!eliminate_tied_block(run, i, newton)) return MBSRI_BLOCK_FAILED;
        } else if (!eliminate_tied(run, i, newton)) {
            return i;
        }
        mbsri_links_pass(w, i);
    }
    return 0;
}

/* Trees with blocks, or ties. After the backward sweep. */
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
    if (newton->status) return MBSRI_BLOCK_FAILED;
    return newton->blocks->linked ? tied_sweep(run, newton) : mixed_sweep(run, newton);
}

/* ---- solution ---- */

static void solve_tied(mbsri_newton_sweeps *newton, const double *r, double *delta)
{
    mbsr_newton *w = newton->blocks;
    const solution of = solution_of(newton->model, delta);
    mbsri_border_load(newton, r, NULL);
    mbsri_links_clear(w);
    for (int k = 0; k < newton->model->bodies; ++k) {
        const int i = mbsri_links_turn(w, k);
        if (i > newton->tree->bodies) continue;
        hand_tied_loads(newton, i, r);
        mbsri_links_reduce(w, i, r);
    }
    mbsri_border_turn(newton);
    for (int k = newton->model->bodies - 1; k >= 0; --k) {
        const int i = mbsri_links_turn(w, k);
        if (i > newton->tree->bodies) continue;
        const int flags = newton->step[i].flags;
        v4 x[4];
        mbsri_links_substitute(w, i);
        motion_above(newton, i, x);
        if (flags & MBSRI_BLOCK) {
            move_block(newton, i, x, NULL, delta);
            continue;
        }
        move_joint(newton, newton->step + i, i, flags, r, of, x, true, true);
        keep_tied_motion(newton, i, x);
    }
}

#endif
