/* Articulated-body inertia and bias force on the way to the root: Mbar and p, in registers.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_CARRY_H
#define MBSRI_SWEEPS_CARRY_H

#include "sweeps/lane.h"
#include "sweeps/tree.h"

/* The carry in registers, laid out as in memory. */
typedef struct blocks {
    v4 I[2], G[3], M[2], L, p;
    double kappa, spread;
} blocks;

MBSRI_INLINE void to_memory(const blocks *c, mbsri_carry *m)
{
    for (int j = 0; j < 2; ++j) {
        store(m->I + 4 * j, c->I[j]);
        store(m->M + 4 * j, c->M[j]);
    }
    for (int j = 0; j < 3; ++j) store(m->G + 4 * j, c->G[j]);
    store(m->L, c->L);
    store(m->p, c->p);
    m->kappa = c->kappa;
    m->spread = c->spread;
}

MBSRI_INLINE void from_memory(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 2; ++j) {
        c->I[j] = load(m->I + 4 * j);
        c->M[j] = load(m->M + 4 * j);
    }
    for (int j = 0; j < 3; ++j) c->G[j] = load(m->G + 4 * j);
    c->L = load(m->L);
    c->p = load(m->p);
    c->kappa = m->kappa;
    c->spread = m->spread;
}

/* c += what other successors left. */
MBSRI_INLINE void add(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 2; ++j) {
        c->I[j] += load(m->I + 4 * j);
        c->M[j] += load(m->M + 4 * j);
    }
    for (int j = 0; j < 3; ++j) c->G[j] += load(m->G + 4 * j);
    c->L += load(m->L);
    c->p += load(m->p);
    c->kappa = m->kappa > c->kappa ? m->kappa : c->kappa;
    c->spread += m->spread;
}

MBSRI_INLINE void clear(blocks *c)
{
    const v4 none = splat(0.0);
    c->I[0] = c->I[1] = c->G[0] = c->G[1] = c->G[2] = c->M[0] = c->M[1] = c->L = c->p = none;
    c->kappa = c->spread = 0.0;
}

/* (y_L, y_p) = Mbar (x_L, x_p) */
MBSRI_INLINE void times_masses(const blocks *c, v4 x_L, v4 x_p, v4 *y_L, v4 *y_p)
{
    *y_L = symmetric_times(c->I, x_L) + cyclic_transposed_times(c->G, x_p);
    *y_p = cyclic_times(c->G, x_L) + symmetric_times(c->M, x_p);
}

/* Mbar -= (a_L, a_p) (b_L, b_p)^T, which is symmetric, or one of two that are together. */
MBSRI_INLINE void subtract_dyad(v4 a_L, v4 a_p, v4 b_L, v4 b_p, blocks *c)
{
    const v4 L1 = yzx(b_L), L2 = zxy(b_L);
    c->I[0] -= a_L * b_L, c->I[1] -= yzx(a_L) * L2;
    c->G[0] -= a_p * b_L, c->G[1] -= a_p * L1, c->G[2] -= a_p * L2;
    c->M[0] -= a_p * b_p, c->M[1] -= yzx(a_p) * zxy(b_p);
}

/* Own inertia, turned into the world, and its gyroscopic force. */
MBSRI_INLINE void add_own(const mbsri_sweep_body *b, const mbsri_sweep_state *s, blocks *c)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)}, omega = load(s->omega);
    v4 I[2] = {splat(0.0), splat(0.0)};
    for (int j = 0; j < 3; ++j) {
        const v4 RI = times_stored(R, b->I + 4 * j);
        I[0] += RI * R[j];
        I[1] += yzx(RI) * zxy(R[j]);
    }
    const v4 h = times_stored(R, b->c);
    c->L += cross(omega, symmetric_times(I, omega));
    c->p += cross(omega, cross(omega, h));
    c->I[0] += I[0], c->I[1] += I[1];
    c->G[1] += zxy(h), c->G[2] -= yzx(h); /* -[h]x */
    c->M[0] += splat(b->c[3]);
}

/* (L, p) = M A + gyroscopic force. */
MBSRI_INLINE void own_load(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 A_w, v4 A_v,
                           v4 *L, v4 *p)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)};
    const v4 omega = load(s->omega), h = times_stored(R, b->c);
    v4 D[3];
    by_diagonals(R, D);
    const v4 w = cyclic_transposed_times(D, omega), a = cyclic_transposed_times(D, A_w);
    const v4 in_body = times(I, a) + cross(w, times(I, w));
    *L = cyclic_times(D, in_body) + cross(h, A_v);
    *p = splat(b->c[3]) * A_v + cross(A_w, h) + cross(omega, cross(omega, h));
}

/* From body i's origin to its predecessor's: Mbar <- X^T Mbar X, p <- X^T p. With B = M [rho]x, N =
 * G - B / 2: I += [rho]x N + ([rho]x N)^T, G -= B. */
MBSRI_INLINE void translate(v4 rho, blocks *c)
{
    const v4 r1 = yzx(rho), r2 = zxy(rho), half = splat(0.5), m1 = yzx(c->M[1]), m2 = zxy(c->M[1]);
    const v4 B[3] = {m2 * r2 - m1 * r1, m1 * rho - c->M[0] * r2, c->M[0] * r1 - m2 * rho};
    v4 N[3];
    for (int j = 0; j < 3; ++j) {
        N[j] = c->G[j] - half * B[j];
        c->G[j] -= B[j];
    }
    c->I[0] += (r1 + r1) * zxy(N[1]) - (r2 + r2) * yzx(N[2]);
    c->I[1] += r2 * N[2] - r1 * N[1] + rho * (yzx(N[0]) - zxy(N[0]));
    c->L += cross(rho, c->p);
}

#endif
