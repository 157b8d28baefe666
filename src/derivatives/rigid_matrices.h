/* Matrices of derivatives of trees of rigid bodies, O(N depth): from the leaves to the root.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Behind a joint all move as its column says, so that the sums of inertia and of forces by omega
 * over a body and all behind it, M and B, give what column k makes of the force there,
 *
 *   f_q = B T + M Q + C,   f_u = B S_w + M U,   g = (B^T S, M S) by omega, alpha and a,
 *
 * and these go to the root, all that are behind a joint at once: dtau_j / dq_k = S_j^T f_q of k,
 * dtau_k / dq_j = g . (T, Q) of j, for each joint j before k.
 *
 * Of forward dynamics joints give way on the way to the root: M and B are those of articulated
 * bodies, and each joint takes G S^T f of what passes it. With M_tree = L D L^T, L with ones on its
 * diagonal, the same sweep then leaves
 *
 *   Lambda = L^-1,   Y = -D^-1 L^-1 (dtau/dq, dtau/du) and D^-1 L^-1
 *
 * where Lambda has columns -S_j^T f of f = G_k. What is left is L^-T Y, rigid_leaves.h. */
#ifndef MBSRI_DERIVATIVES_RIGID_MATRICES_H
#define MBSRI_DERIVATIVES_RIGID_MATRICES_H

#include "derivatives/rigid_leaves.h"
#include "sweeps/carry.h"

/* ---- sums over a body and all behind it ---- */

MBSRI_INLINE blocks inertia_of(const mbsri_rigid_composite *s)
{
    blocks c;
    clear(&c);
    for (int j = 0; j < 2; ++j) {
        c.I[j] = load(s->I + 4 * j);
        c.M[j] = load(s->M + 4 * j);
    }
    for (int j = 0; j < 3; ++j) c.G[j] = load(s->G + 4 * j);
    return c;
}

MBSRI_INLINE void keep_inertia(const blocks *c, mbsri_rigid_composite *s)
{
    for (int j = 0; j < 2; ++j) {
        store(s->I + 4 * j, c->I[j]);
        store(s->M + 4 * j, c->M[j]);
    }
    for (int j = 0; j < 3; ++j) store(s->G + 4 * j, c->G[j]);
}

/* Components of e x a, for e along each axis. */
MBSRI_INLINE void cross_axes(const double a[3], v4 rows[3])
{
    rows[0] = (v4){0.0, a[2], -a[1], 0.0};
    rows[1] = (v4){-a[2], 0.0, a[0], 0.0};
    rows[2] = (v4){a[1], -a[0], 0.0, 0.0};
}

/* Components of a x (e x b) = e (a . b) - b (a . e), added. */
MBSRI_INLINE void add_cross_cross(const double a[4], const double b[4], v4 rows[3])
{
    const double along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const v4 by = load(a);
    rows[0] += (v4){along, 0.0, 0.0, 0.0} - splat(b[0]) * by;
    rows[1] += (v4){0.0, along, 0.0, 0.0} - splat(b[1]) * by;
    rows[2] += (v4){0.0, 0.0, along, 0.0} - splat(b[2]) * by;
}

/* Of the body alone. B: forces by omega, component by component, along the world's axes. */
MBSRI_INLINE void open_composite(const mbsri_rigid_body *b, mbsri_rigid_composite *s)
{
    const v4 c = load(b->c), none = splat(0.0);
    blocks own;
    clear(&own);
    if (b->flags & MBSRI_MASSLESS) {
        keep_inertia(&own, s);
        for (int l = 0; l < 6; ++l) store(s->B[l], none);
        return;
    }
    own.I[0] = load(b->I);
    own.I[1] = load(b->I + 4);
    own.G[1] = zxy(c);
    own.G[2] = -yzx(c);
    own.M[0] = (v4){b->c[3], b->c[3], b->c[3], 0.0};
    keep_inertia(&own, s);
    const double *I = b->I, *omega = b->omega;
    const v4 row[3] = {{I[0], I[6], I[5], 0.0}, {I[6], I[1], I[4], 0.0}, {I[5], I[4], I[2], 0.0}};
    _Alignas(32) double swing[4];
    v4 L[3], p[3];
    store(swing, cross(load(omega), c));
    cross_axes(b->spin, L);
    cross_axes(swing, p);
    add_cross_cross(omega, b->c, p);
    for (int l = 0; l < 3; ++l) {
        const int x = (l + 1) % 3, y = (l + 2) % 3;
        store(s->B[l], L[l] + splat(omega[x]) * row[y] - splat(omega[y]) * row[x]);
        store(s->B[3 + l], p[l]);
    }
}

/* f += M A of motions side by side. */
MBSRI_INLINE void add_inertia_times(const mbsri_rigid_composite *s, const v4 A[6], v4 f[6])
{
    for (int l = 0; l < 3; ++l) {
        for (int m = 0; m < 3; ++m) {
            const int both = l == m ? l : 4 + 3 - l - m;
            f[l] += splat(s->I[both]) * A[m];
            f[l] += splat(s->G[4 * ((l + 3 - m) % 3) + m]) * A[3 + m];
            f[3 + l] += splat(s->G[4 * ((m + 3 - l) % 3) + l]) * A[m];
            f[3 + l] += splat(s->M[both]) * A[3 + m];
        }
    }
}

/* ---- past a joint, four forces side by side in six components ---- */

MBSRI_INLINE v4 dot_many(const double S[8], const v4 f[6])
{
    v4 sum = splat(S[0]) * f[0];
    for (int l = 1; l < 6; ++l) sum += splat(S[component(l)]) * f[l];
    return sum;
}

MBSRI_INLINE v4 add_dot3(v4 sum, const double x[3], const v4 y[3])
{
    for (int l = 0; l < 3; ++l) sum += splat(x[l]) * y[l];
    return sum;
}

/* f -= G t */
MBSRI_INLINE void give_way_many(const double G[8], v4 t, v4 f[6])
{
    for (int l = 0; l < 6; ++l) f[l] -= splat(G[component(l)]) * t;
}

/* y += a x b, of four columns in each component of b. */
MBSRI_INLINE void add_cross_many(const double a[3], const v4 b[3], v4 y[3])
{
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        y[k] += splat(a[l]) * b[m];
        y[k] -= splat(a[m]) * b[l];
    }
}

MBSRI_INLINE void load_many(const double *x, int count, v4 *f)
{
    for (int l = 0; l < count; ++l) f[l] = load(x + 4 * l);
}

MBSRI_INLINE void store_many(double *x, int count, const v4 *f)
{
    for (int l = 0; l < count; ++l) store(x + 4 * l, f[l]);
}

/* S^T f of the joint's n columns. */
MBSRI_INLINE void dot_joint(const mbsri_rigid_body *b, const mbsri_rigid_column *c, const int n,
                            const v4 f[6], v4 *t)
{
    const bool free = n != 1 && b->flags & MBSRI_FREE;
    for (int j = 0; j < n; ++j) t[j] = free ? f[c[j].place - b->first] : dot_many(c[j].S, f);
}

/* To the predecessor: M and B. */
MBSRI_INLINE void hand_composite_on(const mbsri_rigid *r, int i, const int n, bool forward)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_column *c = r->column + b->first;
    const mbsri_rigid_composite *s = r->composite + i;
    mbsri_rigid_composite *to = r->composite + b->parent;
    blocks at = inertia_of(s), sum;
    v4 A[6], f[6], t[6];
    cross_axes(b->w, A);
    cross_axes(b->s, A + 3);
    add_cross_cross(r->body[b->parent].omega, b->r, A + 3);
    for (int l = 0; l < 6; ++l) f[l] = load(s->B[l]);
    add_inertia_times(s, A, f);
    if (forward) dot_joint(b, c, n, f, t);
    for (int k = 0; k < n && forward; ++k) {
        give_way_many(c[k].G, t[k], f);
        subtract_dyad(load(c[k].G), load(c[k].G + 4), load(c[k].F), load(c[k].F + 4), &at);
    }
    add_cross_many(b->r, f + 3, f);
    for (int l = 0; l < 6; ++l) store(to->B[l], load(to->B[l]) + f[l]);
    translate(load(b->r), &at);
    sum = inertia_of(to);
    for (int j = 0; j < 2; ++j) {
        sum.I[j] += at.I[j];
        sum.M[j] += at.M[j];
    }
    for (int j = 0; j < 3; ++j) sum.G[j] += at.G[j];
    keep_inertia(&sum, to);
}

/* ---- results ---- */

/* Where they go. Packed: to the rows of the order, all of them. Else to matrices by u, of nu rows;
 * NULL: nowhere. */
typedef struct results {
    double *matrix[3];
    bool packed, forward;
} results;

/* Parts of the rows. dtau / du' stands in that of Lambda, which is read above the diagonal alone:
 * D^-1 L^-1 has zeros below it that nothing writes over. */
enum { BY_Q, BY_U, BY_LOAD, LAMBDA };

MBSRI_INLINE int part_of(int which, bool forward)
{
    return which == BY_LOAD && !forward ? LAMBDA : which;
}

/* Row j, column k. */
MBSRI_INLINE void put(const mbsri_rigid *r, const results *to, int which, int j, int k, double x)
{
    const mbsri_rigid_order *o = &r->order;
    const size_t part = (size_t)part_of(which, to->forward);
    if (to->packed)
        o->rows[(size_t)j * o->down + part * o->part + (size_t)k] = x;
    else if (to->matrix[which])
        to->matrix[which][(size_t)o->u[k] * (size_t)r->model->nu + (size_t)o->u[j]] = x;
}

/* ---- columns of a joint set out ---- */

/* Four places of travel: what each takes to the root, component by component. */
enum { OF_Q = 0, OF_U = 24, OF_G = 48, OF_A = 72, OF_W = 96 };

/* D^-1 of a joint of n columns, row k. */
MBSRI_INLINE const double *inverse_row(const mbsri_rigid *r, const mbsri_rigid_body *b, const int n,
                                       int k)
{
    return n == 1 ? &r->column[b->first].Dinv : r->Dinv[b->multi][k];
}

/* What column k takes along. */
typedef struct traveller {
    pair f_q, f_u, of_A;
    v4 of_w;
} traveller;

MBSRI_INLINE void send(double *to, pair f)
{
    for (int l = 0; l < 3; ++l) {
        to[4 * l] = f.w[l];
        to[12 + 4 * l] = f.v[l];
    }
}

/* Past the own joint to the predecessor, and to its place there. */
MBSRI_INLINE void set_out(const mbsri_rigid *r, int i, int k, bool forward, traveller *t)
{
    const mbsri_rigid_body *b = r->body + i;
    const int slot = r->order.slot[r->order.first[i] + k];
    double *to = r->order.travel + MBSRI_RIGID_TRAVEL * (size_t)(slot / 4) + slot % 4;
    const v4 rho = load(b->r), omega = load(r->body[b->parent].omega), a = t->of_A.v;
    /* r x (a x omega) = a (r . omega) - omega (r . a) */
    const v4 of_w = t->of_w + cross(load(b->w), t->of_A.w) + cross(load(b->s), a) +
                    splat(sum3(rho * omega)) * a - splat(sum3(rho * a)) * omega;
    for (int l = 0; l < 3; ++l) to[OF_W + 4 * l] = of_w[l];
    t->f_q.w += cross(rho, t->f_q.v);
    t->f_u.w += cross(rho, t->f_u.v);
    t->of_A.w += cross(rho, a);
    send(to + OF_Q, t->f_q);
    send(to + OF_U, t->f_u);
    send(to + OF_A, t->of_A);
    const pair away = {-t->of_A.w, -t->of_A.v};
    if (!forward) return;
    store_pair(r->column[b->first + k].P, away);
    send(to + OF_G, away);
}

/* Column k's forces on the axes of its own joint, less what elements give. */
MBSRI_INLINE void meet_own(const mbsri_rigid_column *first, const int n, int k, traveller *t,
                           double *t_q, double *t_u)
{
    const mbsri_rigid_column *c = first + k;
    int link = k; /* the first of its link */
    while (c->link > 1 && link > 0 && first[link - 1].link > 1) --link;
    const int past = link + c->link;
    for (int j = past; j < n; ++j) t_q[j] = dot(load_pair(first[j].S), t->f_q);
    t->f_q = plus(t->f_q, 1.0, load_pair(c->C));
    for (int j = 0; j < past && j < n; ++j) t_q[j] = dot(load_pair(first[j].S), t->f_q);
    for (int j = 0; j < n; ++j) t_u[j] = dot(load_pair(first[j].S), t->f_u);
    t_q[k] -= c->tau_q;
    t_u[k] -= c->tau_u;
}

/* D^-1 x, by the negative */
MBSRI_INLINE double pushed(const mbsri_rigid *r, const mbsri_rigid_body *b, const int n, int j,
                           const double *x)
{
    const double *D = inverse_row(r, b, n, j);
    double y = 0.0;
    for (int l = 0; l < n; ++l) y -= D[l] * x[l];
    return y;
}

/* M S of column k, or -M S D^-1. */
MBSRI_INLINE pair gradient_by_A(const blocks *c, const mbsri_rigid_column *column, bool forward)
{
    const pair G = load_pair(column->G);
    pair f;
    if (forward) return (pair){-G.w, -G.v};
    times_masses(c, load(column->S), load(column->S + 4), &f.w, &f.v);
    return f;
}

/* Entries of the joint's own rows and columns; then all columns go. */
MBSRI_INLINE void start_columns(const mbsri_rigid *r, int i, const int n, const results *to)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_column *first = r->column + b->first;
    const mbsri_rigid_composite *s = r->composite + i;
    const int place = r->order.first[i];
    const blocks inertia = inertia_of(s);
    v4 B[6], by_w[6], w[3], v[3];
    for (int l = 0; l < 6; ++l) B[l] = load(s->B[l]);
    transpose(B, w);
    transpose(B + 3, v);
    for (int k = 0; k < n; ++k) by_w[k] = dot_many(first[k].S, B);
    for (int k = 0; k < n; ++k) {
        const mbsri_rigid_column *c = first + k;
        const v4 Q[2] = {load(c->Q), load(c->Q + 4)}, U[2] = {load(c->U), load(c->U + 4)};
        double t_q[6], t_u[6];
        traveller t;
        times_masses(&inertia, Q[0], Q[1], &t.f_q.w, &t.f_q.v);
        times_masses(&inertia, U[0], U[1], &t.f_u.w, &t.f_u.v);
        for (int l = 0; l < 3; ++l) {
            const pair by = {w[l], v[l]};
            t.f_q = plus(t.f_q, c->T[l], by);
            t.f_u = plus(t.f_u, c->S[l], by);
        }
        t.of_A = gradient_by_A(&inertia, c, to->forward);
        t.of_w = by_w[k];
        meet_own(first, n, k, &t, t_q, t_u);
        for (int j = 0; j < n; ++j) {
            put(r, to, BY_Q, place + j, place + k, to->forward ? pushed(r, b, n, j, t_q) : t_q[j]);
            put(r, to, BY_U, place + j, place + k, to->forward ? pushed(r, b, n, j, t_u) : t_u[j]);
            const double armature = j == k ? c->armature : 0.0;
            put(r, to, BY_LOAD, place + j, place + k,
                to->forward ? inverse_row(r, b, n, j)[k]
                            : dot(load_pair(first[j].S), t.of_A) + armature);
        }
        if (b->parent == 0) continue;
        if (to->forward) t.of_w = splat(0.0);
        for (int j = 0; j < n && to->forward; ++j) {
            const pair G = load_pair(first[j].G);
            t.f_q = plus(t.f_q, -t_q[j], G);
            t.f_u = plus(t.f_u, -t_u[j], G);
            t.of_w -= splat(inverse_row(r, b, n, k)[j]) * by_w[j];
        }
        set_out(r, i, k, to->forward, &t);
    }
}

/* ---- columns that pass a joint ---- */

/* Four places of travel at `x`, from place k on, at the joint of body b, whose columns begin with
 * `place`; those from .. end - 1 are behind it, and the others are zero. Packed: `row` has row
 * `place`, columns from k on, `column` its transpose, of rows and parts `down` and `part` apart. */
typedef struct passage {
    const mbsri_rigid_body *b;
    const mbsri_rigid_column *c;
    int place, k, from, end;
    size_t down, part;
    double *x, *row, *column;
} passage;

/* To a row or column by u, `step` numbers from one to the next: what is behind the joint. */
MBSRI_INLINE void put_four(const mbsri_rigid *r, const passage *p, double *to, size_t step, v4 x)
{
    const int *u = r->order.u + p->k, first = p->from - p->k, end = p->end - p->k;
    if (first <= 0 && end >= 4) {
        for (int l = 0; l < 4; ++l) to[(size_t)u[l] * step] = x[l];
        return;
    }
    for (int l = 0; l < 4; ++l) {
        if (l >= first && l < end) to[(size_t)u[l] * step] = x[l];
    }
}

/* Column j of the joint: a row of the matrix. Packed, what is zero goes where zeros are or are
 * written over later. */
MBSRI_INLINE void put_row(const mbsri_rigid *r, const passage *p, const results *to, int which,
                          int j, v4 x)
{
    if (to->packed) {
        const int part = part_of(which, to->forward);
        store3(p->row + ((size_t)j * p->down + (size_t)part * p->part), x);
        return;
    }
    if (to->matrix[which])
        put_four(r, p, to->matrix[which] + r->order.u[p->place + j], (size_t)r->model->nu, x);
}

/* A column of it. */
MBSRI_INLINE void put_column(const mbsri_rigid *r, const passage *p, const results *to, int which,
                             int j, v4 x)
{
    if (to->packed) {
        const size_t down = p->down, part = (size_t)part_of(which, to->forward);
        double *at = p->column + (part * p->part + (size_t)j);
        at[0] = x[0];
        at[down] = x[1];
        at[2 * down] = x[2];
        at[3 * down] = x[3];
        return;
    }
    const size_t u = (size_t)r->order.u[p->place + j];
    if (to->matrix[which]) put_four(r, p, to->matrix[which] + u * (size_t)r->model->nu, 1, x);
}

/* -D^-1 t of the joint's column j. */
MBSRI_INLINE v4 row_of(const mbsri_rigid *r, const mbsri_rigid_body *b, const int n, int j,
                       const v4 *t)
{
    const double *D = inverse_row(r, b, n, j);
    v4 y = splat(D[0]) * t[0];
    for (int l = 1; l < n; ++l) y += splat(D[l]) * t[l];
    return -y;
}

/* `count` kinds of forces at `x`: rows of matrices from `which` on, and on to the predecessor. */
MBSRI_INLINE void pass_forces(const mbsri_rigid *r, const passage *p, const int n, const int count,
                              double *x, int which, const results *to)
{
    const v4 less = splat(n == 1 && to->forward ? -p->c->Dinv : 1.0);
    v4 f[2][6], t[2][6];
    for (int h = 0; h < count; ++h) {
        load_many(x + 24 * h, 6, f[h]);
        dot_joint(p->b, p->c, n, f[h], t[h]);
        for (int j = 0; j < n; ++j) {
            v4 y = less * t[h][j];
            if (n != 1 && to->forward) y = row_of(r, p->b, n, j, t[h]);
            put_row(r, p, to, which + h, j, y);
            if (to->packed && which == BY_LOAD) put_row(r, p, to, LAMBDA, j, -t[h][j]);
        }
    }
    if (p->b->parent == 0) return;
    for (int j = 0; j < n && to->forward; ++j) {
        for (int l = 0; l < 6; ++l) {
            const v4 G = splat(p->c[j].G[component(l)]);
            for (int h = 0; h < count; ++h) f[h][l] -= G * t[h][j];
        }
    }
    for (int h = 0; h < count; ++h) {
        add_cross_many(p->b->r, f[h] + 3, f[h]);
        store_many(x + 24 * h, to->forward ? 6 : 3, f[h]);
    }
}

/* Gradients: columns of matrices, and on. */
MBSRI_INLINE void pass_gradients(const mbsri_rigid *r, const passage *p, const int n,
                                 const results *to)
{
    const mbsri_rigid_body *b = p->b;
    v4 A[6], w[3];
    load_many(p->x + OF_A, 6, A);
    load_many(p->x + OF_W, 3, w);
    for (int j = 0; j < n; ++j) {
        const mbsri_rigid_column *c = p->c + j;
        put_column(r, p, to, BY_Q, j, add_dot3(dot_many(c->Q, A), c->T, w));
        put_column(r, p, to, BY_U, j, add_dot3(dot_many(c->U, A), c->S, w));
        if (to->forward) continue;
        const v4 mass = dot_many(c->S, A);
        put_row(r, p, to, BY_LOAD, j, mass);
        put_column(r, p, to, BY_LOAD, j, mass);
    }
    if (b->parent == 0) return;
    const double *omega = r->body[b->parent].omega, *rho = b->r,
                 along = rho[0] * omega[0] + rho[1] * omega[1] + rho[2] * omega[2];
    const v4 far = add_dot3(splat(0.0), rho, A + 3);
    add_cross_many(b->w, A, w);
    add_cross_many(b->s, A + 3, w);
    for (int l = 0; l < 3; ++l) {
        w[l] += splat(along) * A[3 + l];
        w[l] -= splat(omega[l]) * far;
    }
    add_cross_many(rho, A + 3, A);
    store_many(p->x + OF_A, 3, A);
    store_many(p->x + OF_W, 3, w);
}

/* All behind body i past its joint of n columns. */
MBSRI_INLINE void pass_joint(const mbsri_rigid *r, int i, const int n, const results *to)
{
    const mbsri_rigid_order *o = &r->order;
    const mbsri_rigid_body *b = r->body + i;
    passage p = {.b = b,
                 .c = r->column + b->first,
                 .place = o->first[i],
                 .down = o->down,
                 .part = o->part,
                 .from = o->first[i] + n,
                 .end = o->end[i]};
    if (p.from >= p.end) return;
    const int last = o->slot[p.end - 1] / 4;
    double *const rows = o->rows, *const travel = o->travel;
    for (int m = o->slot[p.from] / 4; m <= last; ++m) {
        p.k = o->block_place[m];
        p.x = travel + MBSRI_RIGID_TRAVEL * (size_t)m;
        if (to->packed) {
            p.row = rows + ((size_t)p.place * p.down + (size_t)p.k);
            p.column = rows + ((size_t)p.k * p.down + (size_t)p.place);
        }
        pass_forces(r, &p, n, 2, p.x + OF_Q, BY_Q, to);
        if (to->forward) pass_forces(r, &p, n, 1, p.x + OF_G, BY_LOAD, to);
        pass_gradients(r, &p, n, to);
    }
}

MBSRI_INLINE void sweep_to_root(const mbsri_rigid *r, const results *to)
{
    const int bodies = r->tree->bodies;
    const mbsri_rigid_order *o = &r->order;
    for (size_t k = 0; k < o->blocks * MBSRI_RIGID_TRAVEL; k += 4) store(o->travel + k, splat(0.0));
    for (int i = 0; i <= bodies; ++i) open_composite(r->body + i, r->composite + i);
    for (int place = bodies; place >= 1; --place) {
        const int i = r->along[place], n = r->body[i].n;
        if (n == 1) {
            pass_joint(r, i, 1, to);
            start_columns(r, i, 1, to);
            if (r->body[i].parent > 0) hand_composite_on(r, i, 1, to->forward);
        } else {
            if (n == 6 && to->packed)
                pass_joint(r, i, 6, to);
            else
                pass_joint(r, i, n, to);
            start_columns(r, i, n, to);
            if (r->body[i].parent > 0) hand_composite_on(r, i, n, to->forward);
        }
    }
}

/* To the rows. */
MBSRI_OUTLINE void sweep_rows(const mbsri_rigid *r)
{
    const results to = {{NULL, NULL, NULL}, true, true};
    sweep_to_root(r, &to);
}

MBSRI_OUTLINE void sweep_inverse_rows(const mbsri_rigid *r)
{
    const results to = {{NULL, NULL, NULL}, true, false};
    sweep_to_root(r, &to);
}

/* To matrices by u, which become zero first. */
MBSRI_OUTLINE void sweep_matrices(const mbsri_rigid *r, double *const matrix[3], bool forward)
{
    const size_t nu = (size_t)r->model->nu;
    for (int k = 0; k < 3; ++k) {
        if (matrix[k]) memset(matrix[k], 0, nu * nu * sizeof *matrix[k]);
    }
    const results to = {{matrix[0], matrix[1], matrix[2]}, false, forward};
    sweep_to_root(r, &to);
}

static bool rigid_matrices(mbsri_rigid *r, double *by_q, double *by_u, double *by_load,
                           bool forward)
{
    const size_t nu = (size_t)r->model->nu;
    const mbsri_rigid_order *o = &r->order;
    double *const all[3] = {by_q, by_u, by_load};
    bool half = true; /* whether places are u */
    v4 check = splat(0.0);
    for (int i = 1; i <= r->tree->bodies; ++i) {
        const mbsri_rigid_body *b = r->body + i;
        for (int k = 0; k < b->n; ++k) {
            const int place = o->first[i] + k, u = r->column[b->first + k].u;
            o->u[place] = u;
            o->place[u] = place;
            half = half && u == place;
        }
    }
    const bool packed = o->down > 0;
    if (!packed)
        sweep_matrices(r, all, forward);
    else if (forward)
        sweep_rows(r);
    else
        sweep_inverse_rows(r);
    for (int k = 0; k < 3; ++k) {
        if (!all[k]) continue;
        if (!forward)
            check += packed ? rows_as_they_are(r, (size_t)part_of(k, false) * o->part, all[k])
                            : nothing_of(nu * nu, all[k]);
        else if (!packed)
            check += matrix_to_leaves(r, half && k == 2, all[k]);
        else if (o->path)
            check += rows_by_factor(r, (size_t)k * o->part, all[k]);
        else
            check += rows_by_sweep(r, (size_t)k * o->part, half && k == 2, all[k]);
    }
    return check[0] + check[1] + check[2] + check[3] == 0.0;
}

#endif
