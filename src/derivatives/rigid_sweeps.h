/* The sweeps of rigid_record.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_RIGID_SWEEPS_H
#define MBSRI_DERIVATIVES_RIGID_SWEEPS_H

#include "derivatives/rigid_matrices.h"

#include "joints/chain.h"
#include "newton/sweeps/perturbation.h"
#include "sweeps/multi_arguments.h"

#include <string.h>

/* ---- at the state ---- */

/* The axes of body i in the order of its chain, and their rates and accelerations. */
typedef struct axes {
    int count;
    pair S[MBSRI_MAX_STEPS];
    double u[MBSRI_MAX_STEPS], udot[MBSRI_MAX_STEPS];
    int place[MBSRI_MAX_STEPS], link[MBSRI_MAX_STEPS]; /* place: -1 of a driven one */
} axes;

MBSRI_OUTLINE int look_at_chain(const mbsri_sweep_run *run, int i, const double *udot, axes *a)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    double pose[MBSR_POSE_SIZE], V[6];
    mbsri_chain_axis axis[MBSRI_MAX_STEPS];
    const mbsr_joint_args args = mbsri_multi_arguments(run, i, pose, V);
    const int status = mbsri_chain_axes(&args, axis, &a->count);
    for (int k = 0; k < a->count && !status; ++k) {
        const double *S = axis[k].S;
        const int place = axis[k].place, u = b->u + place;
        a->S[k] = (pair){{S[0], S[1], S[2], 0.0}, {S[3], S[4], S[5], 0.0}};
        a->place[k] = place;
        a->link[k] = axis[k].ball ? 3 : 1;
        a->u[k] = place < 0 ? axis[k].rate : run->u[u];
        a->udot[k] = place < 0 ? axis[k].acceleration : udot[run->model->order.u_of[u]];
    }
    return status;
}

MBSRI_INLINE void look_at_axis(const mbsri_sweep_run *run, int i, const double *udot, axes *a)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const v4 Z = load(run->state[i].R + 8), none = splat(0.0);
    a->count = 1;
    a->S[0] = (pair){none, none};
    if (b->flags & MBSRI_TURNS) a->S[0].w = Z;
    if (b->flags & MBSRI_SLIDES) a->S[0].v = Z * splat(b->pitch);
    a->u[0] = run->u[b->u];
    a->udot[0] = udot[run->model->order.u_of[b->u]];
    a->place[0] = 0;
    a->link[0] = 1;
}

/* Inertia, and the force that it takes. */
MBSRI_INLINE pair take_inertia(const mbsri_sweep_run *run, int i, mbsri_rigid_body *to)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)}, omega = load(s->omega),
             alpha = load(s->A_w), a = load(s->A_v);
    v4 I[2] = {splat(0.0), splat(0.0)}, c = times_stored(R, b->c);
    for (int j = 0; j < 3; ++j) {
        const v4 RI = times_stored(R, b->I + 4 * j);
        I[0] += RI * R[j];
        I[1] += yzx(RI) * zxy(R[j]);
    }
    const v4 spin = symmetric_times(I, omega);
    store(to->I, I[0]);
    store(to->I + 4, I[1]);
    store(to->spin, spin);
    store(to->c, c);
    to->c[3] = b->c[3];
    return (pair){symmetric_times(I, alpha) + cross(c, a) + cross(omega, spin),
                  splat(b->c[3]) * a + cross(alpha, c) + cross(omega, cross(omega, c))};
}

/* S, T, Q, U of axis k of those of a joint, with V and A before it (of a quaternion: behind it), V
 * at the joint's end, both less the motion of the predecessor's point. */
MBSRI_INLINE void keep_column(pair S, pair V, pair V_before, pair A, pair V_end,
                              mbsri_rigid_column *to)
{
    const pair rest = plus(V_end, -1.0, V), T = cross_motion(V, S);
    pair Q = cross_motion(T, rest), U = cross_motion(S, rest);
    Q = plus(Q, 1.0, cross_motion(A, S));
    U = plus(U, 1.0, cross_motion(V_before, S));
    Q.v += cross(T.w, V_end.v) + cross(V_end.w, T.v);
    U.v += cross(S.w, V_end.v) + cross(V_end.w, S.v);
    store_pair(to->S, S);
    store_pair(to->T, T);
    store_pair(to->Q, Q);
    store_pair(to->U, U);
}

/* r, w, s and the columns of a joint. */
MBSRI_INLINE void take_joint(const mbsri_sweep_run *run, int i, const axes *a, mbsri_rigid_body *to,
                             mbsri_rigid_column *column)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i, *pred = run->state + b->parent;
    const v4 r = load(s->rho), omega = load(pred->omega), alpha = load(pred->A_w),
             none = splat(0.0);
    pair V = {omega, cross(omega, r)}, A = {alpha, load(pred->A_v) + cross(alpha, r)},
         own = {none, none};
    for (int k = 0; k < a->count; ++k) own = plus(own, a->u[k], a->S[k]);
    const pair V_end = plus(V, 1.0, own);
    store(to->r, r);
    store(to->w, own.w);
    store(to->s, V.v + splat(2.0) * own.v);
    store(to->omega, load(s->omega));
    for (int k = 0; k < a->count;) {
        const int link = a->link[k];
        pair by = {none, none}, push = {none, none};
        for (int j = k; j < k + link; ++j) {
            by = plus(by, a->u[j], a->S[j]);
            push = plus(push, a->udot[j], a->S[j]);
        }
        const pair V_after = plus(V, 1.0, by);
        const pair A_after = plus(plus(A, 1.0, push), 1.0, cross_motion(V, by));
        for (int j = k; j < k + link; ++j) {
            if (a->place[j] < 0) continue;
            keep_column(a->S[j], link > 1 ? V_after : V, V, link > 1 ? A_after : A, V_end, column);
            column->link = link;
            column->place = b->u + a->place[j];
            column->u = run->model->order.u_of[column->place];
            ++column;
        }
        V = V_after;
        A = A_after;
        k += link;
    }
}

/* D^-1 of the joint of body i, in the order of its columns, and G. */
MBSRI_OUTLINE void take_block(const mbsri_sweep_run *run, int i, const mbsri_rigid_body *to,
                              mbsri_rigid_column *column, double Dinv[6][6])
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const int n = to->n;
    double x[6];
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) x[l] = column[k].place == b->u + l;
        mbsri_solve_joint(n, multi->factor, x);
        pair G = {splat(0.0), splat(0.0)};
        for (int l = 0; l < n; ++l) {
            Dinv[k][l] = x[column[l].place - b->u];
            G = plus(G, x[l], load_pair(multi->U[l]));
        }
        store_pair(column[k].G, G);
        memcpy(column[k].F, multi->U[column[k].place - b->u], sizeof column[k].F);
    }
}

MBSRI_INLINE void take_factors(const mbsri_rigid *r, const mbsri_sweep_run *run, int i,
                               const mbsri_rigid_body *to, mbsri_rigid_column *column)
{
    const mbsri_sweep_state *s = run->state + i;
    if (to->multi >= 0) {
        take_block(run, i, to, column, r->Dinv[to->multi]);
        column->Dinv = r->Dinv[to->multi][0][0];
        return;
    }
    const v4 Dinv = splat(s->Dinv);
    column->Dinv = s->Dinv;
    store_pair(column->F, (pair){load(s->U_L), load(s->U_p)});
    store_pair(column->G, (pair){load(s->U_L) * Dinv, load(s->U_p) * Dinv});
}

/* reads the state with A and, with `factors`, U and D of the articulated inertia. */
static int rigid_prepare(mbsri_rigid *r, const mbsri_sweep_run *run, const double *udot,
                         bool factors)
{
    const mbsri_sweeps *tree = run->tree;
    const int bodies = tree->bodies;
    store(r->body->omega, load(run->state->omega));
    memset(r->work, 0, sizeof *r->work);
    for (int i = 1; i <= bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        mbsri_rigid_body *to = r->body + i;
        mbsri_rigid_column *column = r->column + b->u;
        mbsri_rigid_work *work = r->work + i;
        pair f = {splat(0.0), splat(0.0)};
        axes a;
        a.count = 0;
        to->parent = b->parent;
        to->flags = b->flags;
        to->n = b->n;
        to->first = b->u;
        to->place = r->order.first[i];
        to->multi = b->flags & MBSRI_MULTI ? b->multi : -1;
        if (b->flags & MBSRI_MULTI) {
            const int status = look_at_chain(run, i, udot, &a);
            if (status) return status;
        } else if (b->n > 0) {
            look_at_axis(run, i, udot, &a);
        }
        take_joint(run, i, &a, to, column);
        if (factors && b->n > 0) take_factors(r, run, i, to, column);
        if (!(b->flags & MBSRI_MASSLESS)) f = take_inertia(run, i, to);
        if (b->flags & MBSRI_LOADED) {
            f.w -= load(run->load[i].L);
            f.v -= load(run->load[i].p);
        }
        store(work->f, f.w);
        store(work->f + 4, f.v);
    }
    for (int i = bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        const pair f = load_pair(r->work[i].f);
        mbsri_rigid_work *pred = r->work + b->parent;
        mbsri_rigid_column *c = r->column + b->first;
        for (int k = 0; k < b->n; ++k, ++c) {
            store_pair(c->C, cross_force(load_pair(c->S), f));
            c->tau_q = r->tau_q[c->place];
            c->tau_u = r->tau_u[c->place];
            c->armature = run->model->armature[c->place];
        }
        store(pred->f, load(pred->f) + f.w + cross(load(b->r), f.v));
        store(pred->f + 4, load(pred->f + 4) + f.v);
    }
    return MBSR_OK;
}

/* ---- tangents ---- */

/* What the chosen parameters change of the frame of body i, or NULL. */
MBSRI_INLINE const mbsri_rigid_frame *frame_along(const mbsri_rigid *r, int i)
{
    const mbsri_rigid_seeds *s = r->seeds;
    return s && s->active && s->frame[i] >= 0 ? s->sum + s->frame[i] : NULL;
}

/* Root to leaves: changes of motion, and of the forces that own inertia takes. z: NULL is zero. */
MBSRI_INLINE void change_motions(mbsri_rigid *r, const double *x, const double *y, const double *z)
{
    const int bodies = r->tree->bodies;
    memset(r->work, 0, sizeof *r->work);
    for (int i = 1; i <= bodies; ++i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_work *pred = r->work + b->parent;
        const mbsri_rigid_column *c = r->column + b->first;
        mbsri_rigid_work *to = r->work + i;
        const v4 spin = load(pred->x[0]), rho = load(b->r);
        v4 w = spin, alpha = load(pred->x[1]), a = load(pred->x[2]), L = splat(0.0), p = L;
        a += cross(alpha, rho) + cross(spin, load(b->s)) +
             cross(load(r->body[b->parent].omega), cross(spin, rho));
        alpha += cross(spin, load(b->w));
        for (int k = 0; k < b->n; ++k, ++c) {
            const v4 dq = splat(x[c->u]), du = splat(y[c->u]), S = load(c->S);
            w += load(c->T) * dq + S * du;
            alpha += load(c->Q) * dq + load(c->U) * du;
            a += load(c->Q + 4) * dq + load(c->U + 4) * du;
            if (!z) continue;
            alpha += S * splat(z[c->u]);
            a += load(c->S + 4) * splat(z[c->u]);
        }
        const mbsri_rigid_frame *frame = frame_along(r, i);
        if (frame) {
            w += load(frame->x[0]);
            alpha += load(frame->x[1]);
            a += load(frame->x[2]);
        }
        store(to->x[0], w);
        store(to->x[1], alpha);
        store(to->x[2], a);
        if (!(b->flags & MBSRI_MASSLESS)) {
            const v4 I[2] = {load(b->I), load(b->I + 4)}, m = load(b->c), omega = load(b->omega);
            L = symmetric_times(I, alpha) + cross(m, a) + cross(w, load(b->spin)) +
                cross(omega, symmetric_times(I, w));
            p = splat(b->c[3]) * a + cross(alpha, m) + cross(w, cross(omega, m)) +
                cross(omega, cross(w, m));
        }
        if (r->load && b->flags & MBSRI_LOADED) {
            L -= load(r->load + 8 * i);
            p -= load(r->load + 8 * i + 4);
        }
        if (r->seeds && r->seeds->active) {
            L -= load(r->seeds->load + 8 * i);
            p -= load(r->seeds->load + 8 * i + 4);
        }
        store(to->f, L);
        store(to->f + 4, p);
    }
}

MBSRI_INLINE void hand_force_on(const mbsri_rigid *r, const mbsri_rigid_body *b, pair f)
{
    mbsri_rigid_work *pred = r->work + b->parent;
    store(pred->f, load(pred->f) + f.w + cross(load(b->r), f.v));
    store(pred->f + 4, load(pred->f + 4) + f.v);
}

/* f with what turns of the link that ends with column c make of it. */
MBSRI_INLINE pair turn_link(const mbsri_rigid_column *c, const double *dq, pair f)
{
    for (int j = 0; j < c->link; ++j) f = plus(f, dq[c[-j].u], load_pair(c[-j].C));
    return f;
}

static void rigid_tangent(mbsri_rigid *r, const double *dq, const double *du, const double *dudot,
                          double *dtau)
{
    change_motions(r, dq, du, dudot);
    for (int i = r->tree->bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_frame *frame = frame_along(r, i);
        pair f = load_pair(r->work[i].f);
        if (frame) f = plus(f, 1.0, load_pair(frame->C[1]));
        for (int k = b->n - 1; k >= 0;) {
            const mbsri_rigid_column *c = r->column + b->first + k;
            f = turn_link(c, dq, f);
            k -= c->link;
            for (const mbsri_rigid_column *at = c; at > c - c->link; --at) {
                const int u = at->u;
                dtau[u] = dot(load_pair(at->S), f) + at->armature * dudot[u] - at->tau_q * dq[u] -
                          at->tau_u * du[u];
            }
        }
        if (frame) f = plus(f, 1.0, load_pair(frame->C[0]));
        hand_force_on(r, b, f);
    }
}

/* y = D^-1 e of a joint, and f with G e. */
MBSRI_INLINE pair give_way(const mbsri_rigid *r, const mbsri_rigid_body *b, double *e, pair f)
{
    const mbsri_rigid_column *c = r->column + b->first;
    for (int k = 0; k < b->n; ++k) f = plus(f, e[k], load_pair(c[k].G));
    if (b->multi < 0) {
        if (b->n > 0) e[0] *= c->Dinv;
        return f;
    }
    const double(*Dinv)[6] = (const double(*)[6])r->Dinv[b->multi];
    double x[6];
    for (int k = 0; k < b->n; ++k) {
        x[k] = 0.0;
        for (int l = 0; l < b->n; ++l) x[k] += Dinv[k][l] * e[l];
    }
    memcpy(e, x, (size_t)b->n * sizeof *e);
    return f;
}

/* Root to leaves, with y of each joint: accelerations, and their rates into x. */
MBSRI_INLINE void find_rates(mbsri_rigid *r, double *x)
{
    store_pair(r->work->f, (pair){splat(0.0), splat(0.0)});
    for (int i = 1; i <= r->tree->bodies; ++i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_column *c = r->column + b->first;
        pair A = load_pair(r->work[b->parent].f);
        A.v += cross(A.w, load(b->r));
        const pair before = A;
        for (int k = 0; k < b->n; ++k, ++c) {
            const double rate = r->y[b->first + k] - dot(load_pair(c->G), before);
            x[c->u] = rate;
            A = plus(A, rate, load_pair(c->S));
        }
        store_pair(r->work[i].f, A);
    }
}

static void rigid_forward_tangent(mbsri_rigid *r, const double *dq, const double *du,
                                  const double *dtau, double *dudot)
{
    change_motions(r, dq, du, NULL);
    for (int i = r->tree->bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_frame *frame = frame_along(r, i);
        pair f = load_pair(r->work[i].f);
        if (frame) f = plus(f, 1.0, load_pair(frame->C[1]));
        double *e = r->y + b->first;
        for (int k = b->n - 1; k >= 0;) {
            const mbsri_rigid_column *c = r->column + b->first + k;
            f = turn_link(c, dq, f);
            for (int j = 0; j < c->link; ++j, --k) {
                const mbsri_rigid_column *at = c - j;
                const int u = at->u;
                e[k] = dtau[u] + at->tau_q * dq[u] + at->tau_u * du[u] - dot(load_pair(at->S), f);
            }
        }
        f = give_way(r, b, e, f);
        if (frame) f = plus(f, 1.0, load_pair(frame->C[0]));
        hand_force_on(r, b, f);
    }
    find_rates(r, dudot);
}

/* ---- adjoints ---- */

/* M^-1 by, into x. */
static void solve_masses(mbsri_rigid *r, const double *by, double *x)
{
    memset(r->work, 0, ((size_t)r->tree->bodies + 1) * sizeof *r->work);
    for (int i = r->tree->bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_column *c = r->column + b->first;
        pair f = load_pair(r->work[i].f);
        double *e = r->y + b->first;
        for (int k = 0; k < b->n; ++k) e[k] = by[c[k].u] - dot(load_pair(c[k].S), f);
        f = give_way(r, b, e, f);
        hand_force_on(r, b, f);
    }
    find_rates(r, x);
}

/* Y behind the link that begins with column c. */
MBSRI_INLINE pair move_link(const mbsri_rigid_column *c, const double *by, pair Y)
{
    for (int j = 0; j < c->link; ++j) Y = plus(Y, by[c[j].u], load_pair(c[j].S));
    return Y;
}

/* Gradients by what the frame of body i changes: Y before its joint, and by its motion. */
MBSRI_INLINE void keep_frame(const mbsri_rigid *r, int i, pair Y, v4 of_w, v4 of_alpha, v4 of_a)
{
    if (!r->seeds || r->seeds->frame[i] < 0) return;
    mbsri_rigid_frame *to = r->seeds->by + r->seeds->frame[i];
    store(to->x[0], of_w);
    store(to->x[1], of_alpha);
    store(to->x[2], of_a);
    store_pair(to->C[0], Y);
    store_pair(to->C[1], load_pair(r->work[i].f));
}

/* sign times the gradient of sum by_k dtau_k, where work has the motion Y = sum of S by: by dq, du
 * and, where it is not NULL, du'. x of the work becomes the gradient by omega, alpha, a; f is Y. */
static void collect_gradients(mbsri_rigid *r, double sign, const double *by, double *dq, double *du,
                              double *dudot)
{
    for (int i = r->tree->bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        mbsri_rigid_work *at = r->work + i, *pred = r->work + b->parent;
        const v4 rho = load(b->r);
        v4 of_w = load(at->x[0]), of_alpha = load(at->x[1]), of_a = load(at->x[2]);
        if (!(b->flags & MBSRI_MASSLESS)) {
            const v4 I[2] = {load(b->I), load(b->I + 4)}, m = load(b->c), omega = load(b->omega),
                     w = load(at->f), v = load(at->f + 4);
            of_alpha += symmetric_times(I, w) + cross(m, v);
            of_a += splat(b->c[3]) * v + cross(w, m);
            of_w += cross(load(b->spin), w) + symmetric_times(I, cross(w, omega)) +
                    cross(cross(omega, m), v) + cross(m, cross(v, omega));
        }
        pair Y = load_pair(pred->f);
        Y.v += cross(Y.w, rho);
        keep_frame(r, i, Y, of_w, of_alpha, of_a);
        for (int k = 0; k < b->n; ++k) {
            const mbsri_rigid_column *c = r->column + b->first + k;
            const int u = c->u;
            const pair S = load_pair(c->S);
            if (k == 0 || c->link == 1 || c[-1].link == 1) Y = move_link(c, by, Y);
            const v4 of_q = of_w * load(c->T) + of_alpha * load(c->Q) + of_a * load(c->Q + 4) +
                            Y.w * load(c->C) + Y.v * load(c->C + 4),
                     of_u = of_w * S.w + of_alpha * load(c->U) + of_a * load(c->U + 4);
            dq[u] = sign * (sum3(of_q) - c->tau_q * by[u]);
            du[u] = sign * (sum3(of_u) - c->tau_u * by[u]);
            if (dudot) dudot[u] = sign * (sum3(of_alpha * S.w + of_a * S.v) + c->armature * by[u]);
        }
        store(pred->x[0], load(pred->x[0]) + of_w + cross(load(b->w), of_alpha) +
                              cross(load(b->s), of_a) +
                              cross(rho, cross(of_a, load(r->body[b->parent].omega))));
        store(pred->x[1], load(pred->x[1]) + of_alpha + cross(rho, of_a));
        store(pred->x[2], load(pred->x[2]) + of_a);
    }
}

static void rigid_move(mbsri_rigid *r, const double *by)
{
    memset(r->work, 0, ((size_t)r->tree->bodies + 1) * sizeof *r->work);
    for (int i = 1; i <= r->tree->bodies; ++i) {
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_column *c = r->column + b->first;
        pair Y = load_pair(r->work[b->parent].f);
        Y.v += cross(Y.w, load(b->r));
        for (int k = 0; k < b->n; ++k) Y = plus(Y, by[c[k].u], load_pair(c[k].S));
        store_pair(r->work[i].f, Y);
    }
}

#define MBSRI_RIGID_KERNELS                                                                        \
    {                                                                                              \
        rigid_prepare, rigid_tangent, rigid_forward_tangent, rigid_move, solve_masses,             \
            collect_gradients, rigid_matrices                                                      \
    }

#endif
