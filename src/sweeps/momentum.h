/* The momentum form in the vectorised sweeps, after the backward recursion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With subtree sums (L, p) of momentum about body i's origin and (N, F) of the external wrench,
 *
 *   p_i' = S^T (N - v x p, F) + S'^T (L, p) + tau,   S' = (alpha omega_pi x Z, h omega_pi x Z)
 *   0    = D u - ep + U^T X V_pi,   ep = p_i - S^T (L_bar, p_bar)
 *
 * or, where D = 0, the balance of forces 0 = -e. (v x p comes from the motion of the origin.) */
#ifndef MBSRI_SWEEPS_MOMENTUM_H
#define MBSRI_SWEEPS_MOMENTUM_H

#include "sweeps/block.h"
#include "sweeps/lane.h"
#include "sweeps/multi_axis.h"
#include "sweeps/users_joint.h"

/* ---- joints of several axes ---- */

static void multi_momentum(const mbsri_sweep_run *run, int i, mbsri_flow *f)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    _Alignas(32) double wrench[8] = {0.0};
    double vp[3];
    mbsri_cross3(run->state[i].v, f->p, vp);
    memcpy(wrench, f->N, 3 * sizeof *wrench);
    mbsri_add3(-1.0, vp, wrench);
    memcpy(wrench + 4, f->F, 3 * sizeof *wrench);
    mbsri_add3(1.0, multi->driven, f->L_bar);
    mbsri_add3(1.0, multi->driven + 4, f->p_bar);
    for (int k = 0; k < b->n; ++k) {
        const double *S = multi->S[k], *rate = multi->Sdot[k];
        run->out[b->u + k] = run->tau[b->u + k] + product(S, wrench) + mbsri_dot3(rate, f->L) +
                             mbsri_dot3(rate + 4, f->p);
        multi->x[k] = run->p[b->u + k] - mbsri_dot3(S, f->L_bar) - mbsri_dot3(S + 4, f->p_bar);
    }
    for (int k = 0; k < b->n && b->parent > 0; ++k) {
        mbsri_add3(multi->x[k], multi->G[k], f->L_bar);
        mbsri_add3(multi->x[k], multi->G[k] + 4, f->p_bar);
    }
}

/* D u - ep + U^T X V_pi, or -e; V = X V_pi */
static void multi_balance(const mbsri_sweep_run *run, int i, const double V[8])
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    for (int k = 0; k < b->n; ++k) {
        double r = product(multi->U[k], V) - multi->x[k];
        if (run->rank[i] == 0) r = -multi->e[k];
        for (int l = 0; l < b->n; ++l) r += multi->D[k][l] * run->u[b->u + l];
        run->balance[b->u + k] = r;
    }
}

/* ---- joints of one axis, and the sweep ---- */

typedef struct flow {
    v4 L, p, N, F, L_bar, p_bar;
} flow;

MBSRI_INLINE void flow_to_memory(const flow *f, mbsri_flow *m)
{
    store(m->L, f->L), store(m->p, f->p);
    store(m->N, f->N), store(m->F, f->F);
    store(m->L_bar, f->L_bar), store(m->p_bar, f->p_bar);
}

MBSRI_INLINE void add_flow(const mbsri_flow *m, flow *f)
{
    f->L += load(m->L), f->p += load(m->p);
    f->N += load(m->N), f->F += load(m->F);
    f->L_bar += load(m->L_bar), f->p_bar += load(m->p_bar);
}

MBSRI_INLINE void add_own_flow(const mbsri_sweep_body *b, const mbsri_sweep_state *s, v4 g, flow *f)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)};
    const v4 omega = load(s->omega), v = load(s->v), h = times_stored(R, b->c),
             mass = splat(b->c[3]);
    f->L += times(R, times(I, transposed_times(R, omega))) + cross(h, v);
    f->p += mass * v + cross(omega, h);
    f->N += cross(h, g);
    f->F += mass * g;
}

/* p' and ep of a joint of one axis; (L_bar, p_bar) += U D^-1 ep. */
MBSRI_INLINE void flow_through(const mbsri_sweep_run *run, int i, flow *f)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *pred = run->state + b->parent;
    mbsri_sweep_state *s = run->state + i;
    const v4 Z = load(s->R + 8), rate = cross(load(pred->omega), Z);
    if (!b->n) return;
    double pdot = run->tau[b->u], ep = run->p[b->u];
    if (b->flags & MBSRI_TURNS) {
        pdot += sum3(Z * (f->N - cross(load(s->v), f->p)) + rate * f->L);
        ep -= sum3(Z * f->L_bar);
    }
    if (b->flags & MBSRI_SLIDES) {
        pdot += b->pitch * sum3(Z * f->F + rate * f->p);
        ep -= b->pitch * sum3(Z * f->p_bar);
    }
    run->out[b->u] = pdot;
    s->ep = ep;
    const v4 share = splat(s->Dinv * ep);
    f->L_bar += load(s->U_L) * share;
    f->p_bar += load(s->U_p) * share;
}

/* Of bodies first .. last. any: there are blocks, or force elements on bodies. */
MBSRI_INLINE void balance_part(const mbsri_sweep_run *run, int first, int last, bool any)
{
    for (int i = first; i <= last; ++i) {
        const mbsri_sweep_body *b = run->tree->body + i;
        const mbsri_sweep_state *s = run->state + i, *pred = run->state + b->parent;
        if (any && b->flags & MBSRI_BLOCK) {
            mbsri_block_balance(run, i);
            continue;
        }
        const v4 omega = load(pred->omega), v = load(pred->v) + cross(omega, load(s->rho));
        if (b->flags & MBSRI_MULTI) {
            _Alignas(32) double V[8];
            store(V, omega);
            store(V + 4, v);
            multi_balance(run, i, V);
        } else if (b->n) {
            const double r =
                s->D * run->u[b->u] - s->ep + sum3(load(s->U_L) * omega + load(s->U_p) * v);
            run->balance[b->u] = s->Dinv > 0.0 ? r : -s->e;
        }
    }
}

/* Where the sweep stands. */
typedef struct flows {
    flow f;
    mbsri_flow *top;
} flows;

MBSRI_INLINE void hand_flow_on(int flags, flows *at)
{
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) add_flow(--at->top, &at->f);
    flow_to_memory(&at->f, at->top++);
}

/* Past body i; kept: not handed on. */
MBSRI_INLINE void pass_flow(const mbsri_sweep_run *run, int i, v4 g, bool any, bool kept, flows *at)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const int flags = b->flags;
    const v4 none = splat(0.0);
    flow *f = &at->f;
    if (any && flags & MBSRI_BLOCK) {
        _Alignas(32) mbsri_flow m;
        memset(&m, 0, sizeof m);
        mbsri_block_momentum(run, i, &m);
        *f = (flow){none, none, none, none, none, none};
        add_flow(&m, f);
        hand_flow_on(flags, at);
        return;
    }
    if (flags & MBSRI_LEAF) *f = (flow){none, none, none, none, none, none};
    if (flags & MBSRI_BRANCHES) add_flow(--at->top, f);
    if (!(flags & MBSRI_MASSLESS)) add_own_flow(b, s, g, f);
    if (any && flags & MBSRI_LOADED) {
        f->N += load(run->load[i].L);
        f->F += load(run->load[i].p);
    }
    if (flags & MBSRI_MULTI) {
        _Alignas(32) mbsri_flow m;
        flow_to_memory(f, &m);
        multi_momentum(run, i, &m);
        f->L_bar = load(m.L_bar);
        f->p_bar = load(m.p_bar);
    } else {
        flow_through(run, i, f);
    }
    const v4 rho = load(s->rho);
    f->L += cross(rho, f->p);
    f->N += cross(rho, f->F);
    f->L_bar += cross(rho, f->p_bar);
    if (any && flags & MBSRI_TO_BLOCK) {
        _Alignas(32) mbsri_flow m;
        flow_to_memory(f, &m);
        mbsri_block_receive_flow(run, b->parent, &m);
    }
    if (!kept) hand_flow_on(flags, at);
}

MBSRI_INLINE int momentum_sweep(const mbsri_sweep_run *run, bool any)
{
    const mbsri_sweeps *tree = run->tree;
    const v4 none = splat(0.0), g = load3(tree->gravity);
    flows at = {{none, none, none, none, none, none}, run->flows};
    int status = any && tree->blocks > 0 ? mbsri_block_open_momentum(run) : 0;
    if (!status && any && tree->users > 0) status = mbsri_users_rates(run);
    if (status) return status;
    for (int i = tree->bodies; i >= 1; --i) pass_flow(run, i, g, any, false, &at);
    balance_part(run, 1, tree->bodies, any);
    return 0;
}

MBSRI_OUTLINE int momentum_of_kinds(const mbsri_sweep_run *run)
{
    return momentum_sweep(run, true);
}

static int momentum(const mbsri_sweep_run *run)
{
    return run->load ? momentum_of_kinds(run) : momentum_sweep(run, false);
}

#endif
