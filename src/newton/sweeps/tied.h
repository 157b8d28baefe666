/* Bodies that force elements tie across the tree (newton/blocks/linked.h), in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Their x and y are those of perturbation.h and reaction.h, in groups of four with an idle number: (dtheta,
 * nu_w, nu_v, xi), and (chi, phi, psi). What is tied past a joint is what a solution makes of a load on
 * its body, and of a motion of its predecessor. */
#ifndef MBSRI_NEWTON_TIED_H
#define MBSRI_NEWTON_TIED_H

#include "newton/blocks/linked.h"
#include "newton/blocks/solve.h"
#include "newton/sweeps/solve.h"

/* b, from `arm` beside the point of body i, becomes the load on it. */
static void put_load(const mbsri_newton_sweeps *newton, int i, v4 arm, const loads *f)
{
    double *to = mbsri_links_load(newton->blocks, i);
    store3(to + 4 * CHI_L, first_three(f->b[CHI_L] + cross(arm, f->b[CHI_P])));
    store3(to + 4 * CHI_P, first_three(f->b[CHI_P]));
    store3(to + 4 * MOMENT, first_three(f->b[MOMENT] + cross(arm, f->b[FORCE])));
    store3(to + 4 * FORCE, first_three(f->b[FORCE]));
    store3(to + 16, first_three(f->psi[PSI_L] + cross(arm, f->psi[PSI_P])));
    store3(to + 20, first_three(f->psi[PSI_P]));
}

MBSRI_INLINE void take_tied_motion(const mbsri_newton_sweeps *newton, int i, v4 x[4])
{
    const double *from = mbsri_links_motion(newton->blocks, i);
    for (int g = 0; g < 4; ++g) x[g] = load3(from + 4 * g);
}

/* ---- passes ---- */

static void reduce_tied_block(mbsri_newton_sweeps *newton, int i)
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

static void reduce_tied(mbsri_newton_sweeps *newton, int i)
{
    const mbsri_newton_step *s = newton->step + i;
    const right_sides none = parts_of(newton->model, NULL, NULL);
    loads f;
    if (s->flags & MBSRI_BLOCK) {
        reduce_tied_block(newton, i);
        return;
    }
    clear_loads(&f);
    add_tied_load(newton, i, &f);
    condense_joint(newton, s, i, s->flags, none, &f, true, newton->deep, true);
    if (s->parent == 0) return;
    if (!(s->flags & MBSRI_TO_BLOCK)) {
        put_load(newton, s->parent, load(s->rho), &f);
        return;
    }
    mbsri_newton_flow *top = newton->flow;
    hand_loads_over(s, &f, &top, true, newton->deep);
    give_loads(newton, i, &f, newton->deep);
}

static void move_tied(mbsri_newton_sweeps *newton, int i, const double *r, double *delta)
{
    const mbsri_newton_step *s = newton->step + i;
    const bool inside = s->parent > 0 && !(s->flags & MBSRI_TO_BLOCK);
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    if (inside) take_tied_motion(newton, s->parent, x);
    if (s->flags & MBSRI_BLOCK) {
        double *room = mbsri_border_room(newton, s->parent);
        if (inside) {
            report_motion(newton, s->parent, x, room);
            mbsri_border_still(newton, s->parent);
        }
        mbsri_tree_move(newton->blocks, i);
        return;
    }
    if (s->parent > 0 && !inside) take_motion(newton, i, x);
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

/* What bodies do that were eliminated before. */
static void add_tied(const mbsri_newton_sweeps *newton, int i, slab *y)
{
    const double *own = mbsri_links_own(newton->blocks, i);
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j, own += MBSRI_SWEPT_ACTIONS) {
            for (int r = 0; r < 4; ++r) y->P[g][j][r] += load3(own + 4 * r);
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] += load3(own + 16 + 4 * r);
        }
        own += MBSRI_SWEPT_ACTIONS; /* idle */
    }
}

#endif
