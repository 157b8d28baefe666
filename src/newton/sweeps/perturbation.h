/* The Newton system of the momentum form over a tree of rigid bodies, eliminated leaves to root and
 * solved root to leaves; here its perturbations, and what a body hands to its predecessor.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body, at its point: dtheta and xi, its rotation and the displacement of the
 * point, nu the change of (omega, v) seen in the moving body (nu = dV - xi x V). Those of the
 * subtree's momentum (L, p), chi, are seen in the moving body, those of the wrench (N, F) of the
 * applied forces, phi, along the world's axes and about the moving point. Below, h is what moves
 * with the joint's near side, a with its far side. With the axis S = (S_w, S_v) at the body's
 * point, V_h = (omega_pi, v_pi + omega_pi x rho) and S' = V_h x S,
 *
 *   dtheta_a = dtheta_h + S_w dq     xi_a = xi_h + S_v dq     nu_a = nu_h + S du + S' dq
 *   chi_h = chi_a + dq (S_w x L + S_v x p, S_w x p)           phi_h = phi_a + dq (S_v x F, 0)
 *   d(Mu) = S^T chi_h
 *   dP    = S^T phi_h + (S_w x N + S_v x F) . dtheta_h
 *           + S'^T chi_h + (S_w x L + S_v x p, S_w x p) . nu_h + dtau
 *
 * From the predecessor's point to the body's, xi_h = xi + dtheta x rho, nu likewise; back, moments
 * + rho x forces, phi also + (dtheta x rho) x F. A body adds chi = M nu and, by its weight m g with
 * the first moment h, the moment (dtheta x h) x g. So no force depends on xi, and no change of the
 * force F on anything, unless elements act on bodies (`full`): what is left out then is zero.
 *
 * Equations of a joint, with w = L r_u (forms/momentum.c) and dq = (du + r_q) / c:
 *
 *   d(Mu) - dP / c = r_p / c + w,      delta p = d(Mu) - w
 *
 * Leaves to root, (chi, phi) = P (dtheta, nu, xi) + b, a row of P and of b a joint. */
#ifndef MBSRI_NEWTON_PERTURBATION_H
#define MBSRI_NEWTON_PERTURBATION_H

#include "newton/sweeps/record.h"
#include "sweeps/carry.h"

MBSRI_INLINE int groups(bool full)
{
    return full ? 4 : 3;
}

/* The fourth group of a column stands apart from the others. */
MBSRI_INLINE double *group_of(double *first, double *last, int g)
{
    return g < 3 ? first + 3 * g : last;
}

/* P, Y (reaction.h), and the flows of the subtree. */
typedef struct slab {
    v4 P[4][3][4], Y[4][3][2], L, p, N, F;
} slab;

MBSRI_INLINE void clear_slab(slab *y, bool full)
{
    const v4 none = splat(0.0);
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] = none;
        }
    }
    y->L = y->p = y->N = y->F = none;
}

MBSRI_INLINE void slab_to_memory(const slab *y, mbsri_newton_carry *m, bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) store(m->P[g][j][r], y->P[g][j][r]);
        }
    }
    store(m->L, y->L), store(m->p, y->p);
    store(m->N, y->N), store(m->F, y->F);
}

MBSRI_INLINE void add_slab(const mbsri_newton_carry *m, slab *y, bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] += load(m->P[g][j][r]);
        }
    }
    y->L += load(m->L), y->p += load(m->p);
    y->N += load(m->N), y->F += load(m->F);
}

/* The same of Y. */
MBSRI_INLINE void clear_reaction(slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) y->Y[g][j][0] = y->Y[g][j][1] = splat(0.0);
    }
}

MBSRI_INLINE void add_reaction(const mbsri_newton_carry *m, slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] += load(m->Y[g][j][r]);
        }
    }
}

MBSRI_INLINE void reaction_to_memory(const slab *y, mbsri_newton_carry *m)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) store(m->Y[g][j][r], y->Y[g][j][r]);
        }
    }
}

/* Own tensor of inertia turned into the world, by columns. */
MBSRI_INLINE void turned_inertia(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 I[3])
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)};
    v4 RI[3];
    for (int j = 0; j < 3; ++j) RI[j] = times_stored(R, b->I + 4 * j);
    for (int j = 0; j < 3; ++j)
        I[j] = RI[0] * splat(s->R[j]) + RI[1] * splat(s->R[4 + j]) + RI[2] * splat(s->R[8 + j]);
}

/* chi = M nu;  the moment (dtheta x h) x g of the weight;  the flows. */
MBSRI_INLINE void add_own_slab(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 g, slab *y)
{
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)};
    const v4 omega = load(s->omega), v = load(s->v), h = times_stored(R, b->c),
             mass = splat(b->c[3]), hg = splat(sum3(h * g));
    v4 I[3];
    turned_inertia(b, s, I);
    for (int j = 0; j < 3; ++j) {
        const v4 G = cross(e[j], h);
        y->P[SPIN][j][CHI_L] += I[j];
        y->P[SPIN][j][CHI_P] += G;
        y->P[DRIFT][j][CHI_L] -= G;
        y->P[DRIFT][j][CHI_P] += mass * e[j];
        y->P[ROTATION][j][MOMENT] += h * splat(g[j]) - hg * e[j];
    }
    y->L += times(I, omega) + cross(h, v);
    y->p += mass * v + cross(omega, h);
    y->N += cross(h, g);
    y->F += mass * g;
}

/* (a, b, c) -> sums over the components of each */
MBSRI_INLINE v4 sums(v4 a, v4 b, v4 c)
{
    const v4 product[3] = {a, b, c};
    v4 row[3];
    transpose(product, row);
    return row[0] + row[1] + row[2];
}

/* From body i's point to its predecessor's: P, and the flows. */
MBSRI_INLINE void translate_slab(v4 rho, slab *y, bool full)
{
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 x = xxx(rho), by_y = yyy(rho), z = zzz(rho), rho_F = splat(sum3(rho * y->F));
    /* nu_h = nu + nu_w x rho, xi likewise: columns */
    for (int g = 0; g < (full ? 2 : 1); ++g) {
        v4(*turn)[4] = y->P[g ? ROTATION : SPIN], (*shift)[4] = y->P[g ? DISPLACEMENT : DRIFT];
        for (int r = 0; r < groups(full); ++r) {
            turn[0][r] += by_y * shift[2][r] - z * shift[1][r];
            turn[1][r] += z * shift[0][r] - x * shift[2][r];
            turn[2][r] += x * shift[1][r] - by_y * shift[0][r];
        }
    }
    /* moments + rho x forces: rows; and (dtheta x rho) x F */
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            y->P[g][j][CHI_L] += cross(rho, y->P[g][j][CHI_P]);
            if (full) y->P[g][j][MOMENT] += cross(rho, y->P[g][j][FORCE]);
        }
    }
    for (int j = 0; j < 3; ++j) y->P[ROTATION][j][MOMENT] += rho * splat(y->F[j]) - rho_F * e[j];
    y->L += cross(rho, y->p);
    y->N += cross(rho, y->F);
}

/* The same of Y. */
MBSRI_INLINE void translate_reaction(v4 rho, slab *y, bool full)
{
    const v4 x = xxx(rho), by_y = yyy(rho), z = zzz(rho);
    for (int g = 0; g < (full ? 2 : 1); ++g) {
        v4(*turn)[2] = y->Y[g ? ROTATION : SPIN], (*shift)[2] = y->Y[g ? DISPLACEMENT : DRIFT];
        for (int r = 0; r < 2; ++r) {
            turn[0][r] += by_y * shift[2][r] - z * shift[1][r];
            turn[1][r] += z * shift[0][r] - x * shift[2][r];
            turn[2][r] += x * shift[1][r] - by_y * shift[0][r];
        }
    }
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) y->Y[g][j][0] += cross(rho, y->Y[g][j][1]);
    }
}

/* A row over the body's motion to one over its predecessor's. */
MBSRI_INLINE void translate_row(v4 rho, v4 row[4], bool full)
{
    row[SPIN] += cross(rho, row[DRIFT]);
    if (full) row[ROTATION] += cross(rho, row[DISPLACEMENT]);
}

#endif
