/* Articulated-body inertia and bias force on the way to the root: Mbar and p, in registers.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_CARRY_H
#define MBSRI_SWEEPS_CARRY_H

#include "sweeps/lane.h"
#include "sweeps/tree.h"

/* The carry in registers. */
typedef struct blocks {
    v4 I[3], G[3], M[3], L, p;
    double kappa, spread;
} blocks;

MBSRI_INLINE void to_memory(const blocks *c, mbsri_carry *m)
{
    for (int j = 0; j < 3; ++j) {
        store(m->I + 4 * j, c->I[j]);
        store(m->G + 4 * j, c->G[j]);
        store(m->M + 4 * j, c->M[j]);
    }
    store(m->L, c->L);
    store(m->p, c->p);
    m->kappa = c->kappa;
    m->spread = c->spread;
}

MBSRI_INLINE void from_memory(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 3; ++j) {
        c->I[j] = load(m->I + 4 * j);
        c->G[j] = load(m->G + 4 * j);
        c->M[j] = load(m->M + 4 * j);
    }
    c->L = load(m->L);
    c->p = load(m->p);
    c->kappa = m->kappa;
    c->spread = m->spread;
}

/* c += what other successors left. */
MBSRI_INLINE void add(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 3; ++j) {
        c->I[j] += load(m->I + 4 * j);
        c->G[j] += load(m->G + 4 * j);
        c->M[j] += load(m->M + 4 * j);
    }
    c->L += load(m->L);
    c->p += load(m->p);
    c->kappa = m->kappa > c->kappa ? m->kappa : c->kappa;
    c->spread += m->spread;
}

MBSRI_INLINE void clear(blocks *c)
{
    const v4 none = splat(0.0);
    for (int j = 0; j < 3; ++j) c->I[j] = c->G[j] = c->M[j] = none;
    c->L = c->p = none;
    c->kappa = c->spread = 0.0;
}

/* Own inertia, turned into the world, and its gyroscopic force. */
MBSRI_INLINE void add_own(const mbsri_sweep_body *b, const mbsri_sweep_state *s, blocks *c)
{
    const v4 ex = {1.0, 0.0, 0.0, 0.0}, ey = {0.0, 1.0, 0.0, 0.0}, ez = {0.0, 0.0, 1.0, 0.0};
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)}, omega = load(s->omega);
    v4 RI[3], I[3];
    for (int j = 0; j < 3; ++j) RI[j] = times_stored(R, b->I + 4 * j);
    for (int j = 0; j < 3; ++j)
        I[j] = RI[0] * splat(s->R[j]) + RI[1] * splat(s->R[4 + j]) + RI[2] * splat(s->R[8 + j]);
    const v4 h = times_stored(R, b->c), mass = splat(b->c[3]);
    c->L += cross(omega, times(I, omega));
    c->p += cross(omega, cross(omega, h));
    for (int j = 0; j < 3; ++j) c->I[j] += I[j];
    /* G = -[h]x */
    c->G[0] += yyy(h) * ez - zzz(h) * ey;
    c->G[1] += zzz(h) * ex - xxx(h) * ez;
    c->G[2] += xxx(h) * ey - yyy(h) * ex;
    c->M[0] += mass * ex;
    c->M[1] += mass * ey;
    c->M[2] += mass * ez;
}

/* (L, p) = M A + gyroscopic force. */
MBSRI_INLINE void own_load(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 A_w, v4 A_v,
                           v4 *L, v4 *p)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)};
    const v4 omega = load(s->omega), h = times_stored(R, b->c);
    const v4 w = transposed_times(R, omega), a = transposed_times(R, A_w);
    const v4 in_body = times(I, a) + cross(w, times(I, w));
    *L = times(R, in_body) + cross(h, A_v);
    *p = splat(b->c[3]) * A_v + cross(A_w, h) + cross(omega, cross(omega, h));
}

/* From body i's origin to its predecessor's: Mbar <- X^T Mbar X, p <- X^T p. */
MBSRI_INLINE void translate(v4 rho, blocks *c)
{
    const v4 x = xxx(rho), y = yyy(rho), z = zzz(rho), half = splat(0.5);
    /* M [rho]x */
    const v4 Mr[3] = {c->M[1] * z - c->M[2] * y, c->M[2] * x - c->M[0] * z,
                      c->M[0] * y - c->M[1] * x};
    v4 Y[3], T[3];
    for (int j = 0; j < 3; ++j) {
        Y[j] = cross(rho, c->G[j] - half * Mr[j]);
        c->G[j] -= Mr[j];
    }
    transpose(Y, T);
    for (int j = 0; j < 3; ++j) c->I[j] += Y[j] + T[j];
    c->L += cross(rho, c->p);
}

#endif
