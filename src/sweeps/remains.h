/* What is left of a joint's motion beside that of the joint behind it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The joint j behind a body has taken its own motion out of what it hands on, Mbar^a S_j = 0, or
 * without rank leaves U_j, which is next to nothing. So where body i has no other successor, Mbar_i
 * = X^T Mbar^a X + M_i, with S_j about body i's point and o = alpha Mbar_i S_j, of M_i and what is
 * left,
 *
 *   U = Mbar S = Mbar S' + o,                             S' = S - alpha S_j
 *   D = S^T U  = S'^T Mbar S' + 2 S'^T o + alpha S_j^T o
 *
 * for any alpha. Where both axes are nearly one line, or parallel in a long chain, S^T Mbar S is
 * the difference of large numbers, and this is not: S' is small, or what it moves is; and a link
 * without mass between two joints of one axis has D = 0. Errors dMbar of the sums enter as P'^T
 * dMbar P', P' = 1 - S' G^T. */
#ifndef MBSRI_SWEEPS_REMAINS_H
#define MBSRI_SWEEPS_REMAINS_H

#include "sweeps/carry.h"

#include <math.h>

typedef struct remains {
    v4 w, v;       /* S': angular and linear part */
    v4 U_L, U_p;   /* Mbar S */
    v4 o_L, o_p;   /* o */
    double D;      /* without armature */
    double shared; /* alpha S_j^T o */
    double own;    /* errors of alpha S_j^T o, in units of the machine precision */
    double behind; /* alpha^2 D_j */
    double square; /* |S|^2 in units of length^2 */
    bool massless; /* whether body i has no inertia */
} remains;

/* Whether body i has one successor, which has one axis and no armature, and nothing else adds to
 * its Mbar. */
MBSRI_INLINE bool has_remains(const mbsri_sweeps *tree, int i, int flags)
{
    const mbsri_sweep_body *b = tree->body + i;
    if (b->flags & (MBSRI_LEAF | MBSRI_BRANCHES) || flags & MBSRI_STIFFENED) return false;
    const mbsri_sweep_body *next = b + 1;
    return next->parent == i && !(next->flags & (MBSRI_MULTI | MBSRI_BLOCK)) &&
           next->flags & (MBSRI_TURNS | MBSRI_SLIDES) && !(next->armature > 0.0);
}

/* (w, v) of a joint of one axis. */
MBSRI_INLINE void axis_of(const mbsri_sweep_body *b, v4 Z, v4 *w, v4 *v)
{
    *w = Z * splat(b->flags & MBSRI_TURNS ? 1.0 : 0.0);
    *v = Z * splat(b->flags & MBSRI_SLIDES ? b->pitch : 0.0);
}

/* (L, p) = M (w, v) of the body's own inertia. */
MBSRI_INLINE void own_times(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 w, v4 v,
                            v4 *L, v4 *p)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)}, h = times_stored(R, b->c);
    *L = times(R, times(I, transposed_times(R, w))) + cross(h, v);
    *p = splat(b->c[3]) * v + cross(w, h);
}

/* alpha is what leaves least to S' by the traces of Mbar; false: nothing is in common. */
MBSRI_INLINE bool find_remains(const mbsri_sweep_run *run, int i, const blocks *c, remains *r)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i, *next = s + 1;
    static const double eps = 2.2204460492503131e-16;
    const double turning = sum3(c->I[0]), sliding = sum3(c->M[0]), area = run->tree->area;
    v4 w, v, w_j, v_j, L, p;
    axis_of(b, load(s->R + 8), &w, &v);
    axis_of(b + 1, load(next->R + 8), &w_j, &v_j);
    v_j += cross(load(next->rho), w_j);
    const double weight = turning * sum3(w_j * w_j) + sliding * sum3(v_j * v_j),
                 common = turning * sum3(w * w_j) + sliding * sum3(v * v_j);
    if (!(weight > 0.0) || common == 0.0) return false;
    const double alpha = common / weight;
    w_j *= splat(alpha), v_j *= splat(alpha);
    r->w = w - w_j, r->v = v - v_j;
    own_times(b, s, w_j, v_j, &L, &p);
    r->own = (b->I[0] + b->I[5] + b->I[10]) * sum3(w_j * w_j) + b->c[3] * sum3(v_j * v_j);
    r->behind = alpha * alpha * next->D;
    if (!(next->Dinv > 0.0)) {
        const v4 U_p = load(next->U_p) * splat(alpha);
        L += load(next->U_L) * splat(alpha) + cross(load(next->rho), U_p);
        p += U_p;
        r->own += fabs(r->behind) / eps; /* rounding, all of it */
    }
    times_masses(c, r->w, r->v, &r->U_L, &r->U_p);
    r->shared = sum3(w_j * L + v_j * p);
    r->D = sum3(r->w * (r->U_L + splat(2.0) * L) + r->v * (r->U_p + splat(2.0) * p)) + r->shared;
    r->U_L += L, r->U_p += p;
    r->o_L = L, r->o_p = p;
    r->square = area * sum3(w * w) + sum3(v * v) + sum3(v_j * v_j);
    r->massless = (b->flags & MBSRI_MASSLESS) != 0;
    return true;
}

#endif
