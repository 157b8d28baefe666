/* Matrices of derivatives of trees of rigid bodies, O(N depth).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Behind a joint all move as its column says, so that the sums of inertia and of forces by omega
 * over a body and all behind it, Ic and B, give what column k makes of the force there,
 *
 *   f_q = B T + Ic Q + C,   f_u = B S_w + Ic U,   g = (B^T S, Ic S) by omega, alpha and a,
 *
 * and these go to the root, all that are behind a joint at once: dtau_j / dq_k = S_j^T f_q of k,
 * dtau_k / dq_j = g . (T, Q) of j, for each joint j before k. Of forward dynamics M^-1 times the
 * columns, some side by side: by L and D where the tree is shallow, else by sweeps. */
#ifndef MBSRI_DERIVATIVES_RIGID_MATRICES_H
#define MBSRI_DERIVATIVES_RIGID_MATRICES_H

#include "derivatives/rigid_pairs.h"
#include "derivatives/rigid_record.h"

#include <string.h>

/* ---- inverse dynamics ---- */

/* Forces that inertia takes at the acceleration A. */
MBSRI_INLINE pair times_inertia(const mbsri_rigid_composite *s, pair A)
{
    const v4 I[2] = {load(s->I), load(s->I + 4)}, c = load(s->c);
    return (pair){symmetric_times(I, A.w) + cross(c, A.v), splat(s->c[3]) * A.v + cross(A.w, c)};
}

/* B omega, and B^T f. */
MBSRI_INLINE pair times_rates(const mbsri_rigid_composite *s, v4 omega)
{
    pair f = {splat(0.0), splat(0.0)};
    for (int k = 0; k < 3; ++k) f = plus(f, omega[k], load_pair(s->B[k]));
    return f;
}

MBSRI_INLINE v4 rates_transposed(const mbsri_rigid_composite *s, pair f)
{
    return (v4){dot(load_pair(s->B[0]), f), dot(load_pair(s->B[1]), f), dot(load_pair(s->B[2]), f),
                0.0};
}

MBSRI_INLINE void open_composite(const mbsri_rigid_body *b, mbsri_rigid_composite *s)
{
    memset(s, 0, sizeof *s);
    if (b->flags & MBSRI_MASSLESS) return;
    const v4 I[2] = {load(b->I), load(b->I + 4)}, c = load(b->c), omega = load(b->omega);
    store(s->I, I[0]);
    store(s->I + 4, I[1]);
    store(s->c, c);
    for (int k = 0; k < 3; ++k) {
        const v4 e = {k == 0, k == 1, k == 2, 0.0};
        store(s->B[k], cross(e, load(b->spin)) + cross(omega, symmetric_times(I, e)));
        store(s->B[k] + 4, cross(e, cross(omega, c)) + cross(omega, cross(e, c)));
    }
}

MBSRI_INLINE pair about_predecessor(const mbsri_rigid_body *b, pair f)
{
    f.w += cross(load(b->r), f.v);
    return f;
}

/* To the predecessor: J + (2 r.c + m r.r) 1 - c r^T - r c^T - m r r^T, c + m r; and B. */
MBSRI_INLINE void hand_composite_on(const mbsri_rigid *r, int i)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_composite *s = r->composite + i;
    mbsri_rigid_composite *to = r->composite + b->parent;
    const v4 rho = load(b->r), c = load(s->c), m = splat(s->c[3]), far = c + m * rho,
             omega = load(r->body[b->parent].omega);
    const double trace = sum3(rho * c) + sum3(rho * far);
    store(to->I, load(to->I) + load(s->I) + splat(trace) - c * rho - rho * far);
    store(to->I + 4, load(to->I + 4) + load(s->I + 4) - yzx(c) * zxy(rho) - yzx(rho) * zxy(far));
    const double mass = to->c[3] + s->c[3];
    store(to->c, load(to->c) + far);
    to->c[3] = mass;
    for (int k = 0; k < 3; ++k) {
        const v4 e = {k == 0, k == 1, k == 2, 0.0};
        const pair A = {cross(e, load(b->w)), cross(e, load(b->s)) + cross(omega, cross(e, rho))},
                   f = about_predecessor(b, plus(load_pair(s->B[k]), 1.0, times_inertia(s, A)));
        store_pair(to->B[k], plus(load_pair(to->B[k]), 1.0, f));
    }
}

/* What column k takes to the root: its forces, its gradients, its row and column. */
typedef struct traveller {
    pair f_q, f_u, of_A;
    v4 of_w;
    const mbsri_rigid_column *column;
} traveller;

/* Where results go; NULL: nowhere. The row of place j begins `down` times row[j] from the start,
 * and the column of place k stands `across` times column[k] behind that. `sign` times those by q,
 * u. */
typedef struct results {
    size_t down, across;
    const int *row, *column;
    double *by_q, *by_u, *by_load, sign;
} results;

/* Entry of row j and column k, of places of both. */
MBSRI_INLINE size_t entry_at(const results *to, int j, int k)
{
    return (size_t)to->row[j] * to->down + (size_t)to->column[k] * to->across;
}

/* Row j, column k of one joint, whose places begin with `first`. */
MBSRI_INLINE void put_column(const traveller *t, int first, int j, int k, const results *to)
{
    const size_t at = entry_at(to, first + j, first + k);
    const pair S = load_pair(t->column[j - k].S);
    if (to->by_q) to->by_q[at] = to->sign * dot(S, t->f_q);
    if (to->by_u) to->by_u[at] = to->sign * dot(S, t->f_u);
}

/* Column k, and the rows of its own joint. */
MBSRI_INLINE void start_traveller(const mbsri_rigid *r, int i, int k, const results *to,
                                  traveller *t)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_composite *s = r->composite + i;
    const mbsri_rigid_column *first = r->column + b->first, *c = first + k;
    const pair S = load_pair(c->S);
    const int place = r->order.first[i];
    t->column = c;
    t->f_q = plus(times_inertia(s, load_pair(c->Q)), 1.0, times_rates(s, load(c->T)));
    t->f_u = plus(times_inertia(s, load_pair(c->U)), 1.0, times_rates(s, S.w));
    t->of_A = times_inertia(s, S);
    t->of_w = rates_transposed(s, S);
    int link = k; /* the first of its link */
    while (c->link > 1 && link > 0 && first[link - 1].link > 1) --link;
    const int past = link + c->link;
    for (int j = past; j < b->n; ++j) put_column(t, place, j, k, to);
    t->f_q = plus(t->f_q, 1.0, load_pair(c->C));
    for (int j = 0; j < past && j < b->n; ++j) put_column(t, place, j, k, to);
    for (int j = 0; j <= k && to->by_load; ++j) {
        const double entry = dot(t->of_A, load_pair(first[j].S)) + (j == k ? c->armature : 0.0);
        to->by_load[entry_at(to, place + j, place + k)] = entry;
        to->by_load[entry_at(to, place + k, place + j)] = entry;
    }
    const size_t diagonal = entry_at(to, place + k, place + k);
    if (to->by_q) to->by_q[diagonal] -= to->sign * c->tau_q;
    if (to->by_u) to->by_u[diagonal] -= to->sign * c->tau_u;
}

/* Travellers side by side: component by component, four places in each. */
enum { OF_Q = 0, OF_U = 6, OF_A = 12, OF_W = 18, OF_G = 21 };

MBSRI_INLINE void send(const mbsri_rigid *r, const traveller *t, int place)
{
    const size_t n = r->order.stride;
    double *to = r->order.travel + place;
    for (int l = 0; l < 3; ++l) {
        to[(size_t)(OF_Q + l) * n] = t->f_q.w[l];
        to[(size_t)(OF_Q + 3 + l) * n] = t->f_q.v[l];
        to[(size_t)(OF_U + l) * n] = t->f_u.w[l];
        to[(size_t)(OF_U + 3 + l) * n] = t->f_u.v[l];
        to[(size_t)(OF_A + l) * n] = t->of_A.w[l];
        to[(size_t)(OF_A + 3 + l) * n] = t->of_A.v[l];
        to[(size_t)(OF_W + l) * n] = t->of_w[l];
        to[(size_t)(OF_G + l) * n] = t->column->G[l];
        to[(size_t)(OF_G + 3 + l) * n] = t->column->G[4 + l];
    }
}

/* S^T x of the six components from x on. */
MBSRI_INLINE v4 dot_many(const double S[8], const double *x, size_t n)
{
    v4 a = splat(S[0]) * load3(x), b = splat(S[4]) * load3(x + 3 * n);
    for (size_t l = 1; l < 3; ++l) {
        a += splat(S[l]) * load3(x + l * n);
        b += splat(S[4 + l]) * load3(x + (3 + l) * n);
    }
    return a + b;
}

MBSRI_INLINE v4 dot3_many(const double T[4], const double *x, size_t n)
{
    return splat(T[0]) * load3(x) + splat(T[1]) * load3(x + n) + splat(T[2]) * load3(x + 2 * n);
}

/* Numbers at places `at`, so far from one to the next. */
MBSRI_INLINE void scatter(double *matrix, v4 x, const int *at, int count, size_t step)
{
    if (count >= 4) {
        for (int l = 0; l < 4; ++l) matrix[(size_t)at[l] * step] = x[l];
    } else {
        for (int l = 0; l < count; ++l) matrix[(size_t)at[l] * step] = x[l];
    }
}

/* Row j and columns from place k on; column j and rows from there. */
MBSRI_INLINE void put_both(const results *to, double *matrix, int j, int k, int count, v4 row,
                           v4 column)
{
    double *of_row = matrix + (size_t)to->row[j] * to->down;
    if (to->across == 1 && count >= 4)
        store3(of_row + to->column[k], row);
    else
        scatter(of_row, row, to->column + k, count, to->across);
    scatter(matrix + (size_t)to->column[j] * to->across, column, to->row + k, count, to->down);
}

/* Column j of a joint and all behind it from place `from` to `end`; `place` is that of j. */
MBSRI_INLINE void meet(const mbsri_rigid *r, const mbsri_rigid_column *j, int place, int from,
                       int end, const results *to)
{
    const mbsri_rigid_order *o = &r->order;
    const size_t n = o->stride;
    const v4 sign = splat(to->sign);
    for (int k = from; k < end; k += 4) {
        const double *x = o->travel + k;
        const int count = end - k;
        if (to->by_q)
            put_both(to, to->by_q, place, k, count, sign * dot_many(j->S, x + OF_Q * n, n),
                     sign * (dot3_many(j->T, x + OF_W * n, n) + dot_many(j->Q, x + OF_A * n, n)));
        if (to->by_u)
            put_both(to, to->by_u, place, k, count, sign * dot_many(j->S, x + OF_U * n, n),
                     sign * (dot3_many(j->S, x + OF_W * n, n) + dot_many(j->U, x + OF_A * n, n)));
        if (to->by_load) {
            const v4 row = dot_many(j->S, x + OF_A * n, n);
            put_both(to, to->by_load, place, k, count, row, row);
        } else if (o->base) {
            store3(o->down + (o->base[place] + (size_t)k), dot_many(j->S, x + OF_G * n, n));
        }
    }
}

/* The moment of a force at r on top of that about it. */
MBSRI_INLINE void shift_many(const v4 r[3], double *f, size_t n)
{
    const v4 x = load3(f + 3 * n), y = load3(f + 4 * n), z = load3(f + 5 * n);
    store3(f, load3(f) + r[1] * z - r[2] * y);
    store3(f + n, load3(f + n) + r[2] * x - r[0] * z);
    store3(f + 2 * n, load3(f + 2 * n) + r[0] * y - r[1] * x);
}

/* Travellers past the joint of body b: from place `from` to `end`; what stands there in the same
 * four stays. */
MBSRI_INLINE void travel_on(const mbsri_rigid *r, const mbsri_rigid_body *b, int from, int end)
{
    const size_t n = r->order.stride;
    const double *omega = r->body[b->parent].omega, *w = b->w, *s = b->s, *rho = b->r,
                 along = rho[0] * omega[0] + rho[1] * omega[1] + rho[2] * omega[2];
    for (int k = from; k < end; k += 4) {
        double *x = r->order.travel + k, *to = x + OF_W * n;
        const v4 keep = {1.0, k + 1 < end, k + 2 < end, k + 3 < end},
                 way[3] = {keep * splat(rho[0]), keep * splat(rho[1]), keep * splat(rho[2])};
        v4 m[3], a[3];
        for (size_t l = 0; l < 3; ++l) {
            m[l] = load3(x + (OF_A + l) * n);
            a[l] = load3(x + (OF_A + 3 + l) * n);
        }
        /* r x (a x omega) = a (r . omega) - omega (r . a) */
        const v4 far = splat(rho[0]) * a[0] + splat(rho[1]) * a[1] + splat(rho[2]) * a[2];
        for (int l = 0; l < 3; ++l) {
            const int p = (l + 1) % 3, q = (l + 2) % 3;
            const v4 more = splat(w[p]) * m[q] - splat(w[q]) * m[p] + splat(s[p]) * a[q] -
                            splat(s[q]) * a[p] + splat(along) * a[l] - splat(omega[l]) * far;
            store3(to + (size_t)l * n, load3(to + (size_t)l * n) + keep * more);
        }
        shift_many(way, x + OF_Q * n, n);
        shift_many(way, x + OF_U * n, n);
        shift_many(way, x + OF_A * n, n);
        shift_many(way, x + OF_G * n, n);
    }
}

static void inverse_matrices(const mbsri_rigid *r, const results *to)
{
    const int bodies = r->tree->bodies;
    const mbsri_rigid_order *o = &r->order;
    for (int i = 0; i <= bodies; ++i) open_composite(r->body + i, r->composite + i);
    for (int place = bodies; place >= 1; --place) {
        const int i = r->along[place];
        const mbsri_rigid_body *b = r->body + i;
        const int first = o->first[i], behind = first + b->n, end = o->end[i];
        for (int k = 0; k < b->n; ++k) {
            traveller t;
            start_traveller(r, i, k, to, &t);
            if (behind < end) meet(r, r->column + b->first + k, first + k, behind, end, to);
            if (b->parent > 0) send(r, &t, first + k);
        }
        if (b->parent == 0) continue;
        travel_on(r, b, first, end);
        hand_composite_on(r, i);
    }
}

/* ---- forward dynamics ---- */

/* Place of component k in vectors of four. */
MBSRI_INLINE int component(int k)
{
    return k < 3 ? k : k + 1;
}

/* y += a x b, of four columns in each component of b. */
MBSRI_INLINE void add_cross_many(const double a[3], const v4 b[3], v4 y[3])
{
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        y[k] += splat(a[l]) * b[m] - splat(a[m]) * b[l];
    }
}

/* Whether it is the first that hands forces to its predecessor. */
MBSRI_INLINE bool is_first(const mbsri_rigid *r, const mbsri_rigid_body *b)
{
    return !(r->body[b->parent].flags & MBSRI_BRANCHES) || b->flags & MBSRI_OPENS;
}

/* Past body i with n rates, of four columns from `at` on: y = D^-1 e for e, and the forces. */
MBSRI_INLINE void lean_back(const mbsri_rigid *r, int i, int n, int at)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_column *c = r->column + b->first;
    double(*e)[MBSRI_RIGID_SIDE] = r->side + r->order.first[i], (*to)[MBSRI_RIGID_SIDE];
    v4 f[6], rate[6];
    to = r->force[b->parent];
    for (int l = 0; l < 6; ++l) {
        f[l] = splat(0.0);
        if (!(b->flags & MBSRI_LEAF)) f[l] = load(r->force[i][l] + at);
    }
    for (int k = 0; k < n; ++k) {
        v4 more = splat(c[k].S[4]) * f[3];
        rate[k] = load(e[k] + at);
        for (int l = 0; l < 3; ++l) rate[k] -= splat(c[k].S[l]) * f[l];
        for (int l = 1; l < 3; ++l) more += splat(c[k].S[4 + l]) * f[3 + l];
        rate[k] -= more;
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 6; ++l) f[l] += splat(c[k].G[component(l)]) * rate[k];
    }
    for (int k = 0; k < n; ++k) {
        v4 y = splat(b->multi < 0 ? c->Dinv : r->Dinv[b->multi][k][0]) * rate[0];
        for (int j = 1; j < n; ++j) y += splat(r->Dinv[b->multi][k][j]) * rate[j];
        store(e[k] + at, y);
    }
    if (b->parent == 0) return;
    add_cross_many(b->r, f + 3, f);
    const bool first = is_first(r, b);
    for (int l = 0; l < 6 && !first; ++l) f[l] += load(to[l] + at);
    for (int l = 0; l < 6; ++l) store(to[l] + at, f[l]);
}

/* x = y - G^T A, and A of the body. */
MBSRI_INLINE void go_forth(const mbsri_rigid *r, int i, int n, int at)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_column *c = r->column + b->first;
    double(*x)[MBSRI_RIGID_SIDE] = r->side + r->order.first[i];
    const double back[3] = {-b->r[0], -b->r[1], -b->r[2]};
    v4 A[6], rate[6];
    for (int l = 0; l < 6; ++l) A[l] = load(r->force[b->parent][l] + at);
    add_cross_many(back, A, A + 3);
    for (int k = 0; k < n; ++k) {
        v4 more = splat(c[k].G[4]) * A[3];
        rate[k] = load(x[k] + at);
        for (int l = 0; l < 3; ++l) rate[k] -= splat(c[k].G[l]) * A[l];
        for (int l = 1; l < 3; ++l) more += splat(c[k].G[4 + l]) * A[3 + l];
        rate[k] -= more;
        store(x[k] + at, rate[k]);
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 6; ++l) A[l] += splat(c[k].S[component(l)]) * rate[k];
    }
    if (!(b->flags & MBSRI_LEAF))
        for (int l = 0; l < 6; ++l) store(r->force[i][l] + at, A[l]);
}

/* No forces on body i, of `width` columns. */
MBSRI_INLINE void clear_forces(const mbsri_rigid *r, int i, int width)
{
    for (int at = 0; at < width; at += 4) {
        for (int l = 0; l < 6; ++l) store(r->force[i][l] + at, splat(0.0));
    }
}

/* M^-1 times the columns side by side, `width` of them. What none of them reaches has neither e nor
 * forces. */
MBSRI_INLINE void solve_side(const mbsri_rigid *r, int width)
{
    for (int i = r->tree->bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        const int n = b->n;
        if (!r->reach[i]) {
            if (r->reach[b->parent] && is_first(r, b)) clear_forces(r, b->parent, width);
            continue;
        }
        for (int at = 0; at < width; at += 4) {
            if (n == 1)
                lean_back(r, i, 1, at);
            else
                lean_back(r, i, n, at);
        }
    }
    clear_forces(r, 0, width);
    for (int i = 1; i <= r->tree->bodies; ++i) {
        const int n = r->body[i].n;
        for (int at = 0; at < width; at += 4) {
            if (n == 1)
                go_forth(r, i, 1, at);
            else
                go_forth(r, i, n, at);
        }
    }
}

/* Rows of four columns from columns of four rows, and back. */
MBSRI_INLINE void turn_four(v4 x[4])
{
    const v4 a = MBSRI_SHUFFLE(x[0], x[1], 0, 4, 2, 6), b = MBSRI_SHUFFLE(x[0], x[1], 1, 5, 3, 7),
             c = MBSRI_SHUFFLE(x[2], x[3], 0, 4, 2, 6), d = MBSRI_SHUFFLE(x[2], x[3], 1, 5, 3, 7);
    x[0] = MBSRI_SHUFFLE(a, c, 0, 1, 4, 5);
    x[1] = MBSRI_SHUFFLE(b, d, 0, 1, 4, 5);
    x[2] = MBSRI_SHUFFLE(a, c, 2, 3, 6, 7);
    x[3] = MBSRI_SHUFFLE(b, d, 2, 3, 6, 7);
}

/* Four columns of the caller's to those side by side from `at` on, or with `back` from there. */
MBSRI_INLINE void exchange_four(const mbsri_rigid *r, double *const column[4], int at, bool back)
{
    const int nu = r->model->nu, *place = r->order.u;
    int k = 0;
    while (k < nu) {
        const int u = place[k];
        if (k + 4 > nu || place[k + 1] != u + 1 || place[k + 2] != u + 2 || place[k + 3] != u + 3) {
            for (int l = 0; l < 4; ++l) {
                double *own = r->side[k] + at + l, *given = column[l] + u;
                if (back)
                    *given = *own;
                else
                    *own = *given;
            }
            ++k;
            continue;
        }
        v4 x[4];
        for (int l = 0; l < 4; ++l) x[l] = back ? load(r->side[k + l] + at) : load3(column[l] + u);
        turn_four(x);
        for (int l = 0; l < 4; ++l) {
            if (back)
                store3(column[l] + u, x[l]);
            else
                store(r->side[k + l] + at, x[l]);
        }
        k += 4;
    }
}

/* Sixteen numbers. */
typedef struct row16 {
    v4 a, b, c, d;
} row16;

MBSRI_INLINE row16 load_row(const double *x)
{
    return (row16){load(x), load(x + 4), load(x + 8), load(x + 12)};
}

MBSRI_INLINE void store_row(double *x, row16 y)
{
    store(x, y.a);
    store(x + 4, y.b);
    store(x + 8, y.c);
    store(x + 12, y.d);
}

/* x + s y */
MBSRI_INLINE row16 add_row(row16 x, double s, const double *y)
{
    const v4 f = splat(s);
    return (row16){x.a + f * load(y), x.b + f * load(y + 4), x.c + f * load(y + 8),
                   x.d + f * load(y + 12)};
}

/* x - s y */
MBSRI_INLINE row16 take_row(row16 x, double s, const double *y)
{
    const v4 f = splat(s);
    return (row16){x.a - f * load(y), x.b - f * load(y + 4), x.c - f * load(y + 8),
                   x.d - f * load(y + 12)};
}

MBSRI_INLINE row16 sum_of(row16 x, row16 y)
{
    return (row16){x.a + y.a, x.b + y.b, x.c + y.c, x.d + y.d};
}

/* L^-1 of sixteen columns side by side, rows `down` apart; they are zero from place `last` on, and
 * where nothing leads to `first`. */
MBSRI_INLINE void factor_to_root(const mbsri_rigid *r, double *rows, size_t down, int first,
                                 int last)
{
    const row16 none = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    const mbsri_rigid_order *o = &r->order;
    for (int place = r->tree->bodies; place >= 1; --place) {
        const int i = r->along[place], behind = o->first[i] + r->body[i].n,
                  end = o->end[i] < last ? o->end[i] : last;
        if (o->end[i] <= first || behind >= end) continue;
        for (int j = o->first[i]; j < behind; ++j) {
            const double *a = o->down + (o->base[j] + (size_t)behind),
                         *row = rows + (size_t)behind * down;
            double *own = rows + (size_t)j * down;
            row16 x = load_row(own), y = none;
            int left = end - behind;
            for (; left > 1; left -= 2, a += 2, row += 2 * down) {
                x = take_row(x, a[0], row);
                y = take_row(y, a[1], row + down);
            }
            if (left > 0) x = take_row(x, a[0], row);
            store_row(own, sum_of(x, y));
        }
    }
}

/* e <- D^-1 e of a joint, whose rows begin at `rows`. */
MBSRI_INLINE void divide(const mbsri_rigid *r, const mbsri_rigid_body *b, double *rows, size_t down)
{
    const row16 none = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    if (b->multi < 0) {
        store_row(rows, add_row(none, r->column[b->first].Dinv, rows));
        return;
    }
    double y[6][MBSRI_RIGID_SIDE] __attribute__((aligned(32)));
    for (int k = 0; k < b->n; ++k) {
        const double *D = r->Dinv[b->multi][k];
        row16 x = none;
        for (int j = 0; j < b->n; ++j) x = add_row(x, D[j], rows + (size_t)j * down);
        store_row(y[k], x);
    }
    for (int k = 0; k < b->n; ++k) store_row(rows + (size_t)k * down, load_row(y[k]));
}

/* L^-T D^-1 of them. */
MBSRI_INLINE void factor_to_leaves(const mbsri_rigid *r, double *rows, size_t down)
{
    const row16 none = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    const mbsri_rigid_order *o = &r->order;
    const double *up = o->up;
    const size_t *path = o->path;
    for (int place = 1; place <= r->tree->bodies; ++place) {
        const int i = r->along[place], above = o->above[i];
        const mbsri_rigid_body *b = r->body + i;
        double *own = rows + (size_t)o->first[i] * down;
        if (b->n > 0) divide(r, b, own, down);
        for (int k = 0; k < b->n; ++k, own += down) {
            row16 x = load_row(own), y = none;
            const double *end = up + above;
            for (; up + 1 < end; up += 2, path += 2) {
                x = take_row(x, up[0], rows + path[0]);
                y = take_row(y, up[1], rows + path[1]);
            }
            if (up < end) x = take_row(x, *up++, rows + *path++);
            store_row(own, sum_of(x, y));
        }
    }
}

/* A <- M^-1 A for `count` columns, one behind the other at the places of `list`. */
MBSRI_INLINE void solve_some(const mbsri_rigid *r, double *const list[MBSRI_RIGID_SIDE], int count)
{
    double *column[MBSRI_RIGID_SIDE];
    for (int l = 0; l < MBSRI_RIGID_SIDE; ++l) column[l] = l < count ? list[l] : r->spare;
    const int width = (count + 3) / 4 * 4;
    for (int at = 0; at < width; at += 4) exchange_four(r, column + at, at, false);
    solve_side(r, width);
    for (int at = 0; at < width; at += 4) exchange_four(r, column + at, at, true);
}

/* Where columns of joints that are marked are not zero, on the way to the root: there, before, and
 * of all but unit vectors behind. */
static void find_reach(const mbsri_rigid *r, bool units)
{
    unsigned char *reach = r->reach;
    const int bodies = r->tree->bodies;
    for (int i = 1; i <= bodies && !units; ++i) {
        const int parent = r->body[i].parent;
        if (parent > 0) reach[i] |= reach[parent];
    }
    for (int i = bodies; i >= 1; --i) reach[r->body[i].parent] |= reach[i];
}

/* All columns of up to three matrices, branch by branch: those side by side have most zeros in
 * common. */
static void solve_columns(const mbsri_rigid *r, double *const matrix[3])
{
    const size_t nu = (size_t)r->model->nu, bodies = (size_t)r->tree->bodies;
    double *list[MBSRI_RIGID_SIDE];
    for (int first = 0; first < 3; first += 2) {
        const bool units = first == 2;
        int count = 0;
        memset(r->reach, 0, bodies + 1);
        for (size_t place = 1; place <= bodies; ++place) {
            const int i = r->along[place];
            const mbsri_rigid_body *b = r->body + i;
            for (int k = 0; k < (units ? 1 : 2) * b->n; ++k) {
                const int which = units ? 2 : k / b->n, u = r->column[b->first + k % b->n].u;
                if (!matrix[which]) continue;
                list[count++] = matrix[which] + (size_t)u * nu;
                r->reach[i] = 1;
                if (count < MBSRI_RIGID_SIDE) continue;
                find_reach(r, units);
                solve_some(r, list, count);
                memset(r->reach, 0, bodies + 1);
                count = 0;
            }
        }
        if (count == 0) continue;
        find_reach(r, units);
        solve_some(r, list, count);
    }
}

/* From rows and columns in the order of places to a matrix. */
static void hand_matrix_out(const mbsri_rigid *r, const double *from, double *matrix)
{
    const mbsri_rigid_order *o = &r->order;
    const int nu = r->model->nu;
    for (int k = 0; k < nu; k += 4) {
        double *column[4];
        for (int l = 0; l < 4; ++l)
            column[l] = k + l < nu ? matrix + (size_t)o->u[k + l] * (size_t)nu : r->spare;
        int j = 0;
        for (; j + 4 <= nu; j += 4) {
            v4 x[4];
            for (int l = 0; l < 4; ++l) x[l] = load(from + (size_t)o->row[j + l] + k);
            turn_four(x);
            for (int l = 0; l < 4; ++l) store3(column[l] + j, x[l]);
        }
        for (; j < nu; ++j)
            for (int l = 0; l < 4; ++l) column[l][j] = from[(size_t)o->row[j] + (size_t)(k + l)];
    }
}

/* The places that columns at .. at + 15 of the rows reach: of matrices of `width` columns, the last
 * of unit vectors. */
static void find_reached_places(const mbsri_rigid *r, int at, int columns, int width, bool units,
                                int *first, int *last)
{
    const int nu = r->model->nu;
    *first = nu;
    *last = 0;
    for (int k = at; k < at + MBSRI_RIGID_SIDE && k < columns; ++k) {
        const int place = k % width, end = units && k >= columns - width
                                               ? place + 1
                                               : (place < nu ? r->order.reach[place] : 0);
        if (place >= nu) continue;
        if (place < *first) *first = place;
        if (end > *last) *last = end;
    }
}

/* All three by L and D, on rows side by side. */
static void matrices_by_factor(const mbsri_rigid *r, double *const matrix[3])
{
    const mbsri_rigid_order *o = &r->order;
    const int nu = r->model->nu, width = (nu + 3) / 4 * 4;
    const size_t down = o->down_rows;
    double *part[3];
    int columns = 0, first, last;
    for (int which = 0; which < 3; ++which) {
        part[which] = matrix[which] ? o->rows + columns : NULL;
        columns += matrix[which] ? width : 0;
    }
    for (size_t k = 0; k < (size_t)nu * down; k += 4) store(o->rows + k, splat(0.0));
    const results to = {down, 1, o->place, o->place, part[0], part[1], NULL, -1.0};
    inverse_matrices(r, &to);
    for (int k = 0; k < nu && part[2]; ++k) part[2][(size_t)k * (down + 1)] = 1.0;
    for (size_t k = 0; k < o->entries; ++k) o->up[k] = o->down[o->turn[k]];
    for (int at = 0; at < columns; at += MBSRI_RIGID_SIDE) {
        find_reached_places(r, at, columns, width, part[2] != NULL, &first, &last);
        factor_to_root(r, o->rows + at, down, first, last);
        factor_to_leaves(r, o->rows + at, down);
    }
    for (int which = 0; which < 3; ++which) {
        if (matrix[which]) hand_matrix_out(r, part[which], matrix[which]);
    }
}

static void rigid_matrices(mbsri_rigid *r, double *by_q, double *by_u, double *by_load,
                           bool forward)
{
    const size_t nu = (size_t)r->model->nu;
    const mbsri_rigid_order *o = &r->order;
    double *const all[3] = {by_q, by_u, by_load};
    for (int i = 1; i <= r->tree->bodies; ++i) {
        const mbsri_rigid_body *b = r->body + i;
        for (int k = 0; k < b->n; ++k) {
            const int place = o->first[i] + k, u = r->column[b->first + k].u;
            o->u[place] = u;
            o->place[place] = place;
            o->row[u] = place * (int)o->down_rows;
            o->reach[place] = o->end[i];
        }
    }
    if (forward && o->base) {
        matrices_by_factor(r, all);
        return;
    }
    const results to = {
        1, nu, o->u, o->u, by_q, by_u, forward ? NULL : by_load, forward ? -1.0 : 1.0};
    for (int k = 0; k < 3; ++k) {
        if (all[k]) memset(all[k], 0, nu * nu * sizeof *all[k]);
    }
    inverse_matrices(r, &to);
    for (size_t k = 0; k < nu && by_load && forward; ++k) by_load[k * (nu + 1)] = 1.0;
    if (forward) solve_columns(r, all);
}

#endif
