/* Matrices of derivatives of trees of rigid bodies, O(N depth).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Behind a joint all move as its column says, so that the sums of inertia and of forces by omega
 * over a body and all behind it, Ic and B, give what column k makes of the force there,
 *
 *   f_q = B T + Ic Q + C,   f_u = B S_w + Ic U,   g = (B^T S, Ic S) by omega, alpha and a,
 *
 * and these go to the root: dtau_j / dq_k = S_j^T f_q of k, dtau_k / dq_j = g . (T, Q) of j, for
 * each joint j before k. Of forward dynamics M^-1 times the columns, some side by side. */
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

/* Where results go, nu x nu each; NULL: nowhere. */
typedef struct results {
    size_t nu;
    double *by_q, *by_u, *by_load;
} results;

/* Row k, column j. */
MBSRI_INLINE void put_row(const traveller *t, const mbsri_rigid_column *j, const results *to)
{
    const size_t at = (size_t)j->u * to->nu + (size_t)t->column->u;
    const pair S = load_pair(j->S);
    if (to->by_q)
        to->by_q[at] =
            sum3(t->of_w * load(j->T) + t->of_A.w * load(j->Q) + t->of_A.v * load(j->Q + 4));
    if (to->by_u)
        to->by_u[at] = sum3(t->of_w * S.w + t->of_A.w * load(j->U) + t->of_A.v * load(j->U + 4));
    if (to->by_load)
        to->by_load[at] = to->by_load[(size_t)t->column->u * to->nu + (size_t)j->u] =
            dot(t->of_A, S);
}

/* Row j, column k. */
MBSRI_INLINE void put_column(const traveller *t, const mbsri_rigid_column *j, const results *to)
{
    const size_t at = (size_t)t->column->u * to->nu + (size_t)j->u;
    const pair S = load_pair(j->S);
    if (to->by_q) to->by_q[at] = dot(S, t->f_q);
    if (to->by_u) to->by_u[at] = dot(S, t->f_u);
}

/* Column k, and the rows of its own joint. */
MBSRI_INLINE void start_traveller(const mbsri_rigid *r, int i, int k, const results *to,
                                  traveller *t)
{
    const mbsri_rigid_body *b = r->body + i;
    const mbsri_rigid_composite *s = r->composite + i;
    const mbsri_rigid_column *first = r->column + b->first, *c = first + k;
    const pair S = load_pair(c->S);
    t->column = c;
    t->f_q = plus(times_inertia(s, load_pair(c->Q)), 1.0, times_rates(s, load(c->T)));
    t->f_u = plus(times_inertia(s, load_pair(c->U)), 1.0, times_rates(s, S.w));
    t->of_A = times_inertia(s, S);
    t->of_w = rates_transposed(s, S);
    int link = k; /* the first of its link */
    while (c->link > 1 && link > 0 && first[link - 1].link > 1) --link;
    const int past = link + c->link;
    for (int j = past; j < b->n; ++j) put_column(t, first + j, to);
    t->f_q = plus(t->f_q, 1.0, load_pair(c->C));
    for (int j = 0; j < past && j < b->n; ++j) put_column(t, first + j, to);
    for (int j = 0; j <= k && to->by_load; ++j) {
        const double entry = dot(t->of_A, load_pair(first[j].S)) + (j == k ? c->armature : 0.0);
        to->by_load[(size_t)first[j].u * to->nu + (size_t)c->u] = entry;
        to->by_load[(size_t)c->u * to->nu + (size_t)first[j].u] = entry;
    }
    const size_t diagonal = (size_t)c->u * (to->nu + 1);
    if (to->by_q) to->by_q[diagonal] -= c->tau_q;
    if (to->by_u) to->by_u[diagonal] -= c->tau_u;
}

/* Past the joint of body b. */
MBSRI_INLINE void travel_on(const mbsri_rigid *r, const mbsri_rigid_body *b, traveller *t)
{
    const v4 rho = load(b->r), a = t->of_A.v;
    t->f_q = about_predecessor(b, t->f_q);
    t->f_u = about_predecessor(b, t->f_u);
    t->of_w += cross(load(b->w), t->of_A.w) + cross(load(b->s), a) +
               cross(rho, cross(a, load(r->body[b->parent].omega)));
    t->of_A.w += cross(rho, a);
}

static void inverse_matrices(const mbsri_rigid *r, const results *to)
{
    const int bodies = r->tree->bodies;
    double *const all[] = {to->by_q, to->by_u, to->by_load};
    for (int k = 0; k < 3; ++k) {
        if (all[k]) memset(all[k], 0, to->nu * to->nu * sizeof *all[k]);
    }
    for (int i = 0; i <= bodies; ++i) open_composite(r->body + i, r->composite + i);
    for (int i = bodies; i >= 1; --i) {
        const mbsri_rigid_body *b = r->body + i;
        for (int k = 0; k < b->n; ++k) {
            traveller t;
            start_traveller(r, i, k, to, &t);
            for (const mbsri_rigid_body *at = b; at->parent > 0;) {
                travel_on(r, at, &t);
                at = r->body + at->parent;
                for (int j = 0; j < at->n; ++j) {
                    put_row(&t, r->column + at->first + j, to);
                    put_column(&t, r->column + at->first + j, to);
                }
            }
        }
        if (b->parent > 0) hand_composite_on(r, i);
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
    double(*e)[MBSRI_RIGID_SIDE] = r->side + b->first, (*to)[MBSRI_RIGID_SIDE];
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
    double(*x)[MBSRI_RIGID_SIDE] = r->side + b->first;
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
    const int nu = r->model->nu;
    const mbsri_rigid_column *c = r->column;
    int k = 0;
    while (k < nu) {
        const int u = c[k].u;
        if (k + 4 > nu || c[k + 1].u != u + 1 || c[k + 2].u != u + 2 || c[k + 3].u != u + 3) {
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

/* r->along: bodies so that those behind one stand together. */
static void order_bodies(const mbsri_rigid *r)
{
    int *along = r->along, *size = along + r->tree->bodies + 1, *next = size + r->tree->bodies + 1;
    const int bodies = r->tree->bodies;
    for (int i = 0; i <= bodies; ++i) size[i] = 1;
    for (int i = bodies; i >= 1; --i) size[r->body[i].parent] += size[i];
    next[0] = 1;
    for (int i = 1; i <= bodies; ++i) {
        const int parent = r->body[i].parent, place = next[parent];
        along[place] = i;
        next[parent] += size[i];
        next[i] = place + 1;
    }
}

/* The same of all columns of up to three matrices, branch by branch: those side by side have most
 * zeros in common. */
static void solve_columns(const mbsri_rigid *r, double *const matrix[3])
{
    const size_t nu = (size_t)r->model->nu, bodies = (size_t)r->tree->bodies;
    double *list[MBSRI_RIGID_SIDE];
    order_bodies(r);
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

static void rigid_matrices(mbsri_rigid *r, double *by_q, double *by_u, double *by_load,
                           bool forward)
{
    const size_t nu = (size_t)r->model->nu, size = nu * nu;
    const results to = {nu, by_q, by_u, forward ? NULL : by_load};
    double *const all[3] = {by_q, by_u, by_load};
    inverse_matrices(r, &to);
    if (!forward) return;
    for (size_t k = 0; k < size && by_q; ++k) by_q[k] = -by_q[k];
    for (size_t k = 0; k < size && by_u; ++k) by_u[k] = -by_u[k];
    if (by_load) memset(by_load, 0, size * sizeof *by_load);
    for (size_t k = 0; k < nu && by_load; ++k) by_load[k * (nu + 1)] = 1.0;
    solve_columns(r, all);
}

#endif
