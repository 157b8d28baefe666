/* Joints of one axis, and welds, in the elimination of the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_ONE_AXIS_H
#define MBSRI_NEWTON_ONE_AXIS_H

#include "newton/sweeps/axis.h"
#include "newton/sweeps/element_slopes.h"
#include "newton/sweeps/reaction.h"

#include <math.h>
#include <string.h>

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
                              passage *p, slab *y, bool below_massless)
{
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    apply_slopes(&on, p->motion, p->C);
    apply_slopes(&on, p->by_r, p->U);
    add_slopes(&on, y);
    if (!below_massless) return;
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

/* Of a body below a massless joint: psi over x_h, and what u' takes up of it. */
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
    if (!(newton->step[i].below_massless & MBSRI_NO_INERTIA)) take_up(G, &p->t, y, full);
}

MBSRI_INLINE void keep_below_massless(mbsri_newton_sweeps *newton, int i, int u, const passage *p)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    mbsri_newton_below_massless *below = newton->below + u;
    store3(below->C, p->t.C[0]), store3(below->C + 3, p->t.C[1]);
    store3(below->U, p->t.U[0]), store3(below->U + 3, p->t.U[1]);
    if (!(newton->step[i].below_massless & MBSRI_NO_INERTIA)) return;
    below->pivot = p->E;
    below->gain = p->gain;
    col->inverse = 1.0 / p->t.along_C;
    col->gain = p->t.along_U;
}

/* U, which is of the order of C / c, without a difference. */
MBSRI_INLINE void sharpen(const mbsri_newton_sweeps *newton, const slab *y, passage *p)
{
    const v4 by_c = splat(newton->by_c);
    apply_slab(y, p->by_r, p->U, true);
    for (int r = 0; r < 4; ++r) p->U[r] += by_c * p->a.J[r];
    p->gain = sum3(along_row(&p->a, by_c, p->U, true)) - p->tau_q;
}

/* Before its unknown is eliminated: p, and in y what elements owe to the predecessor's motion.
 * sharp: not r_q alone, which is small, moves the joint beside du. */
MBSRI_INLINE void meet_joint(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y, const v4 G[2], passage *p, bool full, bool below_massless,
                             bool sharp)
{
    memset(&p->t, 0, sizeof p->t);
    open_passage(run, i, newton, y, p, full);
    if (sharp) sharpen(newton, y, p);
    if (below_massless) pass_reaction(run, i, newton, G, p, y, full);
    if (!is_pair(newton, i, full)) return;
    slopes by;
    place_by_predecessor(run, i, newton, &by);
    add_slopes(&by, y);
}

/* For the solution, over the predecessor's motion. */
MBSRI_INLINE void keep_joint(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             const v4 G[2], passage *p, bool full, bool below_massless)
{
    const int u = run->tree->body[i].u;
    const v4 rho = load(run->state[i].rho);
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    translate_row(rho, p->K, full);
    translate_row(rho, p->Q, full);
    keep_column(col, &p->a, p->K, p->Q, p->C, p->U, G, full);
    col->inverse = 1.0 / p->E;
    col->gain = p->gain;
    if (below_massless) keep_below_massless(newton, i, u, p);
}

/* A joint of one axis; false: its row is singular. */
MBSRI_INLINE bool eliminate(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, slab *y,
                            bool full, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 by_c = splat(newton->by_c);
    const v4 G[2] = {load(s->U_L) * splat(s->Dinv), load(s->U_p) * splat(s->Dinv)};
    passage p;
    meet_joint(run, i, newton, y, G, &p, full, below_massless, false);
    joint_row(y, &p.a, by_c, p.row, full);
    momentum_row(y, p.a.S_w, p.a.S_v, p.Q, full);
    const bool balance_of_forces =
        below_massless && newton->step[i].below_massless & MBSRI_NO_INERTIA;
    if (!(balance_of_forces ? by_reaction(&p, full) : by_momentum(&p, full))) return false;
    if (is_pair(newton, i, full)) close_pair(run, i, newton, &p, y, below_massless);
    if (b->parent > 0) subtract_column(y, p.C, p.K, full);
    if (below_massless) subtract_reaction(y, p.t.C, p.K, full);
    keep_joint(run, i, newton, G, &p, full, below_massless);
    return true;
}

/* A weld: only elements act through it. */
MBSRI_OUTLINE void pass_weld(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                             slab *y, bool below_massless)
{
    slopes by, on;
    place_by_predecessor(run, i, newton, &by);
    place_on_predecessor(run, i, newton, &on);
    add_slopes(&by, y);
    add_slopes(&on, y);
    if (!below_massless) return;
    subtract_slopes(&by, y);
    subtract_slopes(&on, y);
}

#endif
