/* Inverse dynamics with loops by the vectorised sweeps: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * After the inverse dynamics of the tree. Nothing but motors has inertia, so that joints take
 * nothing of what is carried past them, every axis is passed by itself, and no acceleration is
 * looked for: loops are in balance where they close, but for the moment of their gap, which is
 * carried on. */
#ifndef MBSRI_SWEEPS_INVERSE_LOOPS_H
#define MBSRI_SWEEPS_INVERSE_LOOPS_H

#include "sweeps/loops.h"
#include "sweeps/open_loops.h"

/* Column j of S. */
MBSRI_INLINE void column_of(const mbsri_sweep_run *run, int i, int j, v4 *S_L, v4 *S_p)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    if (b->flags & MBSRI_MULTI) {
        *S_L = load(run->multi[b->multi].S[j]);
        *S_p = load(run->multi[b->multi].S[j] + 4);
    } else {
        axis_of(b, load(run->state[i].R + 8), S_L, S_p);
    }
}

/* The motor of a rate makes e + X^T v of least square: F += X X^T, s -= X e. */
MBSRI_INLINE void drive(mbsri_loop_run *w, const mbsri_open *open, double e, int count, int stride,
                        const double *X)
{
    for (int k = 0; k < count; ++k) {
        const double x = X[stride * k];
        w->s[open->id[k]] -= x * e;
        for (int l = 0; l < count; ++l) {
            const double part = x * X[stride * l];
            open->F[k * open->count + l] += part;
            open->sizes[k * open->count + l] += fabs(part);
        }
    }
}

/* What is open at body i past its joint, to its predecessor; the joint has to make `out`, of which
 * gaps behind take their part. False: more motions are open than rows. */
MBSRI_OUTLINE bool pass_motors(mbsri_loop_run *w, int i, bool gaps)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    mbsri_open open = mbsri_open_at(w->part + w->parts - 1);
    const int count = open.count, n = b->n;
    const v4 rho = load(s->rho);
    double *X = w->store, *sizes = w->top; /* neither is kept */
    for (int j = 0; j < n; ++j) {
        v4 S_L, S_p;
        column_of(run, i, j, &S_L, &S_p);
        project(&open, S_L, S_p, n, X + j, sizes + j);
    }
    if (w->loops->joints) mbsri_open_loops_read_joint(w, i, &open, X, sizes);
    clear_rounding(n * count, sizes, X);
    for (int k = 0; k < count; ++k) {
        double *Q = open.Q + 8 * k, *lengths = open.lengths + 8 * k;
        move_unknown(&open, k, rho, load3(Q), load3(Q + 4), load3(lengths), load3(lengths + 4));
    }
    for (int j = 0; j < n; ++j) {
        const int rate = b->u + j;
        double e = run->out[rate];
        if (gaps) {
            v4 S_L, S_p;
            column_of(run, i, j, &S_L, &S_p);
            e += sum3(S_L * load(s->U_L) + S_p * load(s->U_p));
        }
        if (w->motor[rate] > 0.0)
            drive(w, &open, e, count, n, X + j);
        else if (is_held(count, n, X + j) && !carry_motion(w, rate, e, count, n, X + j))
            return false;
        open = mbsri_open_at(w->part + w->parts - 1);
    }
    w->part[w->parts - 1].body = b->parent;
    return true;
}

/* What loops that closed at body i leave to the joints before it, in the place of U. False: that
 * depends on what these do, by motors to spare. */
MBSRI_OUTLINE bool take_gap(const mbsri_loop_run *w, int i, bool *gaps)
{
    const mbsri_sweep_run *run = w->run;
    const int bodies = run->tree->bodies;
    bool some = false;
    for (int k = 0; k < 36; ++k) {
        if (w->Mbar[k] != 0.0) return false;
    }
    for (int k = 0; k < 6; ++k) some = some || w->force[k] != 0.0;
    for (int j = 0; j <= bodies && some && !*gaps; ++j) {
        store(run->state[j].U_L, splat(0.0));
        store(run->state[j].U_p, splat(0.0));
    }
    *gaps = *gaps || some;
    if (!some) return true;
    mbsri_sweep_state *s = run->state + i;
    const double *force = w->force;
    store(s->U_L, load(s->U_L) + (v4){force[0], force[1], force[2], 0.0});
    store(s->U_p, load(s->U_p) + (v4){force[3], force[4], force[5], 0.0});
    return true;
}

MBSRI_INLINE void hand_gap_on(const mbsri_sweep_run *run, int i)
{
    const mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_state *to = run->state + run->tree->body[i].parent;
    const v4 p = load(s->U_p);
    store(to->U_L, load(to->U_L) + load(s->U_L) + cross(load(s->rho), p));
    store(to->U_p, load(to->U_p) + p);
}

static bool loops_inverse(mbsri_loop_run *w)
{
    const mbsri_sweep_run *run = w->run;
    bool closed, gaps = false;
    mbsri_open_loops_start(w);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (run->tree->body[i].flags & (MBSRI_FRONT | MBSRI_CLOSES)) {
            if (!mbsri_open_loops_meet(w, i, &closed)) return false;
            if (closed && !take_gap(w, i, &gaps)) return false;
            const bool open = w->parts > 0 && w->part[w->parts - 1].body == i;
            if (open && !pass_motors(w, i, gaps)) return false;
        }
        if (gaps) hand_gap_on(run, i);
    }
    if (!mbsri_open_loops_meet(w, 0, &closed) || w->parts > 0) return false;
    for (const mbsri_open_record *at = w->last; at; at = at->before)
        mbsri_pivots_backward((const mbsri_pivots *)(const void *)(at + 1), w->s, NULL, w->v);
    return true;
}

#endif
