/* Rows of joints of one axis whose block is zero.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Such a joint has no momentum that its rate could follow from; its algebraic equation is the
 * balance of forces at given accelerations, S^T W = tau, with the reaction W, the sum over the
 * subtree of the forces that the motion takes, less those of elements. With psi, the change of W
 * seen in the moving body,
 *
 *   psi_h = psi_a + dq S x* W,      r_u = S^T psi_h - dtau  where D = 0
 *
 * In the subtrees of such joints ("bodies below a massless joint") psi is carried on. Where D > 0,
 * the acceleration u' takes up what S^T sees of it, psi <- psi - G (S^T psi - dtau) with G = Mbar S
 * D^-1.
 *
 * What the accelerations do to psi is left out, for it is seen in none of these rows: it is M x for
 * some x, of each body, and so is what turning it does, nu x* h + V x* M nu (M is a sum over mass
 * points; a motion that moves none does no work on either). Behind joints that take up their part,
 * M x becomes Mbar x', and Mbar S = 0 where D = 0.
 *
 * Then psi = Y (dtheta, nu, xi) + b. The row of F_p gives delta p = r_p / c + dP / c where D = 0;
 * nothing is handed on to a predecessor that is not below a massless joint. */
#ifndef MBSRI_NEWTON_REACTION_H
#define MBSRI_NEWTON_REACTION_H

#include "newton/sweeps/axis.h"
#include "newton/sweeps/element_slopes.h"
#include "sweeps/block.h"

/* psi -= slopes of elements */
MBSRI_OUTLINE void subtract_slopes(const slopes *by, slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            y->Y[g][j][PSI_L] -= by->by[g][j][0];
            y->Y[g][j][PSI_P] -= by->by[g][j][1];
        }
    }
}

/* out = Y x */
MBSRI_INLINE void apply_reaction(const slab *y, const v4 x[4], v4 out[2], bool full)
{
    out[0] = out[1] = splat(0.0);
    for (int g = 0; g < groups(full); ++g) {
        const v4 one = xxx(x[g]), two = yyy(x[g]), three = zzz(x[g]);
        for (int r = 0; r < 2; ++r)
            out[r] += y->Y[g][0][r] * one + y->Y[g][1][r] * two + y->Y[g][2][r] * three;
    }
}

/* What du and r_q add to psi_h, before u' takes up its part; the row S^T psi over x_h. */
typedef struct reaction {
    v4 C[2], U[2], row[4];
    double along_C, along_U; /* S^T of them, less dtau */
    double size;             /* of what was summed in the former */
} reaction;

/* motion, by_r: of the body by du and by r_q. */
MBSRI_INLINE void open_reaction(int i, const mbsri_newton_sweeps *newton, const axis *a,
                                const v4 motion[4], const v4 by_r[4], double tau_q, double tau_u,
                                const slab *y, reaction *t, bool full)
{
    const double c = newton->c; /* the slopes come divided by c^2 and c */
    const v4 by_c = splat(newton->by_c), W_L = load(newton->reaction[i].W),
             W_p = load(newton->reaction[i].W + 4);
    const v4 jump[2] = {by_c * (cross(a->S_w, W_L) + cross(a->S_v, W_p)),
                        by_c * cross(a->S_w, W_p)};
    apply_reaction(y, motion, t->C, full);
    apply_reaction(y, by_r, t->U, full);
    for (int r = 0; r < 2; ++r) {
        t->C[r] += jump[r];
        t->U[r] += jump[r];
    }
    t->along_C = sum3(a->S_w * t->C[PSI_L] + a->S_v * t->C[PSI_P]) - c * (tau_q + tau_u);
    t->along_U = sum3(a->S_w * t->U[PSI_L] + a->S_v * t->U[PSI_P]) - c * tau_q;
    t->size = sum3(magnitude(a->S_w * t->C[PSI_L])) + sum3(magnitude(a->S_v * t->C[PSI_P])) +
              fabs(c * tau_q) + fabs(c * tau_u);
}

MBSRI_INLINE void reaction_row(const slab *y, const axis *a, reaction *t, bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        v4 product[3];
        for (int j = 0; j < 3; ++j)
            product[j] = a->S_w * y->Y[g][j][PSI_L] + a->S_v * y->Y[g][j][PSI_P];
        t->row[g] = sums(product[0], product[1], product[2]);
    }
}

/* Y -= C K^T */
MBSRI_INLINE void subtract_reaction(slab *y, const v4 C[2], const v4 K[4], bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        const v4 k[3] = {xxx(K[g]), yyy(K[g]), zzz(K[g])};
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] -= C[r] * k[j];
        }
    }
}

/* u' takes up what S^T sees. */
MBSRI_INLINE void take_up(const v4 G[2], reaction *t, slab *y, bool full)
{
    for (int r = 0; r < 2; ++r) {
        t->C[r] -= G[r] * splat(t->along_C);
        t->U[r] -= G[r] * splat(t->along_U);
    }
    subtract_reaction(y, G, t->row, full);
}

/* To the predecessor, whose wrench this is. */
MBSRI_INLINE mbsri_flow *queue_wrench(int flags, v4 L, v4 p, mbsri_flow *top)
{
    if (flags & MBSRI_NEXT) return top;
    if (!(flags & MBSRI_OPENS)) --top, L += load(top->L), p += load(top->p);
    store(top->L, L);
    store(top->p, p);
    return top + 1;
}

/* W of all bodies, after the forward sweep. */
static void find_reactions(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    const mbsri_sweeps *tree = run->tree;
    mbsri_flow *top = run->flows;
    v4 L = splat(0.0), p = splat(0.0);
    mbsri_block_open_reaction(run);
    for (int i = tree->bodies; i >= 1; --i) {
        const mbsri_sweep_body *b = tree->body + i;
        const mbsri_sweep_state *s = run->state + i;
        const int flags = b->flags;
        if (flags & MBSRI_BLOCK) {
            _Alignas(32) double force[8];
            mbsri_block_react(run, i, force, force + 4);
            if (flags & MBSRI_TO_BLOCK) continue;
            L = load(force);
            p = load(force + 4);
            top = queue_wrench(flags, L, p, top);
            continue;
        }
        if (flags & MBSRI_LEAF) L = p = splat(0.0);
        if (flags & MBSRI_BRANCHES) --top, L += load(top->L), p += load(top->p);
        if (!(flags & MBSRI_MASSLESS)) {
            v4 own_L, own_p;
            own_load(b, s, load(s->A_w), load(s->A_v), &own_L, &own_p);
            L += own_L;
            p += own_p;
        }
        if (flags & MBSRI_LOADED) {
            L -= load(run->load[i].L);
            p -= load(run->load[i].p);
        }
        store(newton->reaction[i].W, L), store(newton->reaction[i].W + 4, p);
        L += cross(load(s->rho), p);
        if (flags & MBSRI_TO_BLOCK) {
            _Alignas(32) double force[8];
            store(force, L);
            store(force + 4, p);
            mbsri_block_receive_force(run, b->parent, force, force + 4);
        }
        top = queue_wrench(flags, L, p, top);
    }
}

/* Whether joint i lacks some of its rank, or is of a group that does and is eliminated as one;
 * false in *as_one: of one that would not have to be. */
static bool lacks_rank(const mbsri_sweep_run *run, int i, bool *as_one)
{
    const mbsr_model *m = run->model;
    const int head = m->body[i].group.head;
    if (m->body[head].group.members < 2 || mbsri_apart(m, run->data, head))
        return run->rank[i] < run->tree->body[i].n;
    const mbsri_group g = mbsri_group_in_model(m, head);
    *as_one = *as_one && mbsri_coupled(m, run->data, &g);
    return true;
}

/* Which bodies are below a massless joint; false: some joint is none of one axis among them, there
 * is no memory for them, or a group needs to be taken apart. */
static bool find_below_massless(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    newton->last.below_massless = false;
    newton->last.marked = false;
    newton->step[0].below_massless = 0;
    bool as_one = true;
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_sweep_body *b = run->tree->body + i;
        const int above = newton->step[b->parent].below_massless & MBSRI_BELOW_MASSLESS;
        const bool deficient = lacks_rank(run, i, &as_one);
        int *below_massless = &newton->step[i].below_massless;
        *below_massless = above || deficient ? MBSRI_BELOW_MASSLESS : 0;
        if (deficient) *below_massless |= MBSRI_NO_INERTIA;
        if (!(*below_massless & MBSRI_BELOW_MASSLESS)) continue;
        newton->last.below_massless = true;
        if (b->flags & MBSRI_MULTI) return false;
    }
    return as_one && (!newton->last.below_massless || newton->below);
}

#endif
