/* Kinematics of the vectorised sweeps, root to leaves: R, rho, omega, c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i: R its axes, Z = R e_z the joint's axis, rho from the predecessor's origin to its own,
 * S = (alpha Z, h Z) with alpha = 1 where the joint turns and h = pitch where it slides. With
 * X = [1 0; -[rho]x 1],
 *
 *   V_i = X V_pi + S u,   A_i = X A_pi + c + S u'
 *   c   = (alpha omega_pi x Z u, omega_pi x (omega_pi x rho) + 2 h omega_pi x Z u)
 *
 * which are (8) and (9) with K = 1, H = -X, J = -S, kII = -c. */
#ifndef MBSRI_SWEEPS_MOTION_H
#define MBSRI_SWEEPS_MOTION_H

#include "sweeps/lane.h"
#include "sweeps/block.h"
#include "sweeps/multi_motion.h"
#include "sweeps/show.h"
#include "sweeps/tree.h"
#include "sweeps/users_joint.h"

/* Of the body before, in registers: mostly the predecessor. */
typedef struct motion {
    v4 R[3], omega, v;
} motion;

MBSRI_INLINE void motion_from_memory(const mbsri_sweep_state *s, bool velocity, motion *m)
{
    for (int j = 0; j < 3; ++j) m->R[j] = load(s->R + 4 * j);
    m->omega = load(s->omega);
    if (velocity) m->v = load(s->v);
}

/* m: of the predecessor, then of the body. */
MBSRI_INLINE void move_body(const mbsri_sweep_run *run, const mbsri_sweep_body *b, bool velocity,
                            mbsri_sweep_state *s, motion *m)
{
    const v4 P[3] = {m->R[0], m->R[1], m->R[2]}, omega_pred = m->omega;
    v4 B[3];
    for (int j = 0; j < 3; ++j) B[j] = times_stored(P, b->A + 4 * j);
    const v4 Z = B[2];
    v4 rho = times_stored(P, b->x), omega = omega_pred, c_w = splat(0.0), c_v = splat(0.0);
    v4 slide = splat(0.0);
    if (b->flags & (MBSRI_TURNS | MBSRI_SLIDES)) {
        const v4 u = splat(run->u[b->u]), turning = cross(omega_pred, Z) * u;
        if (b->flags & MBSRI_SLIDES) {
            rho += Z * splat(b->pitch * run->q[b->q]);
            c_v = splat(2.0 * b->pitch) * turning;
            slide = Z * splat(b->pitch) * u;
        }
        if (b->flags & MBSRI_TURNS) {
            const v4 cosine = splat(run->sincos[2 * b->q]), sine = splat(run->sincos[2 * b->q + 1]);
            const v4 x = B[0] * cosine + B[1] * sine, y = B[1] * cosine - B[0] * sine;
            B[0] = x;
            B[1] = y;
            omega += Z * u;
            c_w = turning;
        }
    }
    const v4 swing = cross(omega_pred, rho);
    if (velocity) store(s->v, m->v += swing + slide);
    c_v += cross(omega_pred, swing);
    for (int j = 0; j < 3; ++j) store(s->R + 4 * j, m->R[j] = B[j]);
    store(s->rho, rho);
    store(s->omega, m->omega = omega);
    store(s->A_w, c_w);
    store(s->A_v, c_v);
}

/* A body of another kind than one axis. */
MBSRI_OUTLINE int move_other(const mbsri_sweep_run *run, int i, bool velocity)
{
    if (run->tree->body[i].flags & MBSRI_BLOCK) return mbsri_block_move(run, i);
    if (run->tree->body[i].flags & MBSRI_USERS) return mbsri_users_move(run, i);
    return multi_kinematics(run, i, velocity);
}

/* The origin of body i in the world, and its angle in the plane behind it. */
MBSRI_INLINE void place(const mbsri_sweep_run *run, int i, const mbsri_sweep_body *b, v4 rho,
                        const mbsri_sweep_own *own, const double *q, mbsri_sweep_load *loads)
{
    const double *from = loads[b->parent].r;
    double *to = loads[i].r;
    store(to, load(from) + rho);
    if (!(b->flags & MBSRI_PLANE))
        to[3] = 0.0;
    else if (own[i].coordinate >= 0)
        to[3] = from[3] + own[i].angle + q[own[i].coordinate];
    else
        to[3] = mbsri_sweeps_angle(run, i, from[3]);
}

/* Bodies first .. last; placed: with the origins of those that somebody looks at. */
MBSRI_INLINE int move_part(const mbsri_sweep_run *run, int first, int last, bool velocity,
                           bool placed)
{
    const mbsri_sweep_body *const body = run->tree->body;
    mbsri_sweep_state *const s = run->state;
    const mbsri_sweep_own *const own = run->tree->own;
    const double *const q = run->q;
    mbsri_sweep_load *const loads = run->load;
    if (first > last) return 0;
    int at = body[first].parent; /* the body whose motion is in registers */
    motion m;
    motion_from_memory(s + at, velocity, &m);
    for (int i = first; i <= last; ++i) {
        const mbsri_sweep_body *b = body + i;
        if (b->flags & (MBSRI_MULTI | MBSRI_BLOCK)) {
            const int status = move_other(run, i, velocity);
            if (status) return status;
        } else {
            if (b->parent != at) motion_from_memory(s + b->parent, velocity, &m);
            move_body(run, b, velocity, s + i, &m);
            at = i;
        }
        if (placed && b->flags & MBSRI_PLACED) place(run, i, b, load(s[i].rho), own, q, loads);
    }
    return 0;
}

MBSRI_INLINE int move(const mbsri_sweep_run *run, bool velocity, bool placed)
{
    if (placed) mbsri_sweeps_place_root(run);
    return move_part(run, 1, run->tree->bodies, velocity, placed);
}

static int kinematics(const mbsri_sweep_run *run)
{
    return move(run, false, false);
}

static int velocities(const mbsri_sweep_run *run)
{
    return run->load ? move(run, true, true) : move(run, true, false);
}

#endif
