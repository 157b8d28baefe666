/* The solution with the transposed matrix, from the same factors: solve.h is a linear map of r to
 * delta, step by step; here every step transposed, the last first.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * So the sweep from leaves to root transposes that of solve_forward, with what later steps say of
 * the bodies' motions; that from root to leaves transposes that of solve_back, with what they say
 * of the loads. What stands in k and p in between is said of these. Trees without blocks and
 * corrections; with loops: looped_transposed.h. */
#ifndef MBSRI_NEWTON_SOLVE_TRANSPOSED_H
#define MBSRI_NEWTON_SOLVE_TRANSPOSED_H

#include "newton/sweeps/open_transposed.h"
#include "newton/sweeps/solve.h"

/* What is said of r, x by its parts; and of changes of joint forces (nu), NULL: not asked. */
typedef struct transposed {
    double *x, *tau;
} transposed;

/* What is said of both parts of a vector along an axis. */
MBSRI_INLINE double said_along(const double S[6], v4 rotation, v4 shift)
{
    return sum3(load3(S) * rotation + load3(S + 3) * shift);
}

/* ---- joints of several axes ---- */

/* The transpose of rates_of: to += . */
static void rates_back(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                       const double g[6], double r_s, double *to)
{
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.q_of + s->q;
    for (int k = B->quaternion ? 3 : 0; k < s->n; ++k) to[place[k + B->quaternion]] += g[k];
    if (!B->quaternion) return;
    const double *q = B->q, size = q[0] * q[0] + mbsri_dot3(q + 1, q + 1),
                 part = (r_s + newton->by_c * mbsri_dot3(B->u, g)) / size;
    double turned[3];
    mbsri_cross3(g, q + 1, turned);
    to[place[0]] += q[0] * part - 2.0 / size * mbsri_dot3(q + 1, g);
    for (int k = 0; k < 3; ++k)
        to[place[1 + k]] += q[1 + k] * part + 2.0 / size * (turned[k] + q[0] * g[k]);
}

/* The transpose of place_rates: w, and what is said of r_s. */
static double take_rates_back(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                              const double *v, double w[6])
{
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.q_of + s->q;
    for (int k = 0; k < s->n; ++k) w[k] = v[place[k + B->quaternion]];
    if (!B->quaternion) return 0.0;
    const double *q = B->q, one[3] = {v[place[1]], v[place[2]], v[place[3]]},
                 lambda = newton->by_c * (v[place[0]] * q[0] + mbsri_dot3(one, q + 1));
    double turned[3];
    mbsri_cross3(q + 1, one, turned);
    for (int k = 0; k < 3; ++k)
        w[k] = 0.5 * (turned[k] + q[0] * one[k] - v[place[0]] * q[1 + k]) - 0.25 * B->u[k] * lambda;
    return lambda;
}

/* Of move_axes; at: what is said of the body's motion, overwritten by that of its predecessor's. */
MBSRI_INLINE void axes_motion_back(mbsri_newton_sweeps *newton, int i, const double *v, double *to,
                                   double at[16], bool full, bool open)
{
    const mbsr_model *m = newton->model;
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = m->order.u_of + s->u, n = s->n;
    double w[6], g[6], du[6], p[6];
    v4 x[4];
    const double r_s = take_rates_back(newton, s, v, w);
    for (int f = 0; f < groups(full); ++f) x[f] = load(at + 4 * f);
    for (int k = 0; k < n; ++k) p[k] = v[m->nq + place[k]];
    for (int k = 0; k < n; ++k) {
        const double *S = mbsri_newton_column_at(newton, s->u + k)->S;
        du[k] = v[m->nq + m->nu + place[k]] + m->armature[s->u + k] * p[k] +
                said_along(S, x[SPIN], x[DRIFT]);
        w[k] +=
            sum3(load3(S) * x[ROTATION] + load(B->T[k]) * x[SPIN] + load(B->T[k] + 4) * x[DRIFT]);
        if (full) w[k] += sum3(load3(S + 3) * x[DISPLACEMENT]);
        for (int l = 0; l < n; ++l) w[k] -= B->couple[l][k] * p[l];
    }
    const v4 rho = load(s->rho);
    x[SPIN] += cross(rho, x[DRIFT]);
    if (full) x[ROTATION] += cross(rho, x[DISPLACEMENT]);
    for (int l = 0; l < n; ++l) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + l);
        g[l] = 0.0;
        for (int k = 0; k < n; ++k) g[l] += B->A[k][l] * w[k];
        du[l] += g[l];
        if (open) open_motion_back(newton, i, l, du[l], g[l], p[l]);
        for (int f = 0; f < groups(full); ++f)
            x[f] += load3(group_of(col->Q, col->Q_last, f)) * splat(p[l]) -
                    load3(group_of(col->K, col->K_last, f)) * splat(du[l]);
        newton->k[s->u + l] = du[l];
        newton->p[s->u + l] = p[l];
    }
    for (int f = 0; f < groups(full); ++f) store(at + 4 * f, x[f]);
    for (int k = 0; k < n + B->quaternion; ++k) to[m->order.q_of[s->q + k]] = 0.0;
    rates_back(newton, s, g, r_s, to);
}

/* What is said of b, b behind the joint, and the rows; known: what is said of them. */
MBSRI_INLINE void axes_rows_back(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                                 const double known[6], mbsri_newton_flow *m, bool full)
{
    const v4 by_c = splat(newton->by_c);
    for (int k = 0; k < s->n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        const v4 S_w = load3(col->S), S_v = load3(col->S + 3), by = splat(known[k]),
                 w = splat(known[k] - newton->p[s->u + k]);
        store(m->b, load(m->b) - load3(col->row) * by);
        store(m->b + 4, load(m->b + 4) - load3(col->row + 3) * by);
        store(m->b + 8, load(m->b + 8) + by_c * S_w * by);
        if (full) store(m->b + 12, load(m->b + 12) + by_c * S_v * by);
        store(m->L_bar, load(m->L_bar) + S_w * w);
        store(m->p_bar, load(m->p_bar) + S_v * w);
    }
}

/* Of balance_axes: r_s, and to g and psi. */
static double balance_axes_back(const mbsri_newton_sweeps *newton, int i, const double rest[6],
                                double g[6], mbsri_newton_flow *m)
{
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    double r_s = 0.0;
    for (int k = 0; k < s->n; ++k) {
        const mbsri_newton_below_massless *below = newton->below + s->u + k;
        g[k] += said_along(below->U, load(m->psi), load(m->psi + 4));
    }
    for (int k = 0; k < s->n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        store(m->psi, load(m->psi) - load3(col->S) * splat(rest[k]));
        store(m->psi + 4, load(m->psi + 4) - load3(col->S + 3) * splat(rest[k]));
        for (int l = 0; l < s->n; ++l) g[l] -= B->inverse[k][l] * rest[k];
        r_s += newton->c * B->length[k] * rest[k];
    }
    return r_s;
}

/* Of load_axes; m: what is said of the loads handed on, overwritten by that of the body's. */
MBSRI_INLINE void axes_loads_back(mbsri_newton_sweeps *newton, int i, transposed to,
                                  mbsri_newton_flow *m, bool full, bool open)
{
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.u_of + s->u, n = s->n;
    double *to_p = to.x + newton->model->nq, *to_u = to_p + newton->model->nu;
    const bool delayed = open && s->below_massless & MBSRI_NO_INERTIA;
    double own[6], g[6] = {0.0}, known[6], rest[6] = {0.0}, r_s = 0.0;
    for (int k = 0; k < n; ++k) own[k] = newton->k[s->u + k];
    if (open) open_rights_back(newton, i, own, g, rest);
    for (int k = 0; k < n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        to_u[place[k]] = said_along(col->G, load(m->L_bar), load(m->p_bar)) - newton->p[s->u + k];
        store(m->b, load(m->b) + load3(col->S) * splat(newton->p[s->u + k]));
        store(m->b + 4, load(m->b + 4) + load3(col->S + 3) * splat(newton->p[s->u + k]));
    }
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        v4 C = splat(0.0), U = splat(0.0);
        for (int f = 0; f < groups(full); ++f) {
            C += load3(group_of(col->C, col->C_last, f)) * load(m->b + 4 * f);
            U += load3(group_of(col->U, col->U_last, f)) * load(m->b + 4 * f);
        }
        own[k] += sum3(C);
        g[k] += sum3(U);
    }
    if (delayed) r_s = balance_axes_back(newton, i, rest, g, m);
    for (int l = 0; l < n; ++l) {
        known[l] = delayed ? newton->p[s->u + l] : 0.0;
        for (int k = 0; k < n && !delayed; ++k) known[l] += B->inverse[k][l] * own[k];
        if (!delayed) rest[l] = 0.0;
        to_p[place[l]] = newton->by_c * known[l];
        to_u[place[l]] += known[l] + rest[l];
        if (to.tau) to.tau[place[l]] = newton->by_c * known[l] + rest[l];
        r_s += B->length[l] * known[l];
    }
    for (int l = 0; l < n; ++l)
        for (int k = 0; k < n; ++k) g[l] -= B->gain[k][l] * known[k];
    axes_rows_back(newton, s, known, m, full);
    rates_back(newton, s, g, r_s, to.x);
}

MBSRI_OUTLINE void narrow_motion_back(mbsri_newton_sweeps *newton, int i, const double *v,
                                      double *to, double at[16])
{
    axes_motion_back(newton, i, v, to, at, false, false);
}

MBSRI_OUTLINE void full_motion_back(mbsri_newton_sweeps *newton, int i, const double *v, double *to,
                                    double at[16])
{
    axes_motion_back(newton, i, v, to, at, true, false);
}

MBSRI_OUTLINE void opened_motion_back(mbsri_newton_sweeps *newton, int i, const double *v,
                                      double *to, double at[16])
{
    axes_motion_back(newton, i, v, to, at, true, true);
}

MBSRI_OUTLINE void narrow_loads_back(mbsri_newton_sweeps *newton, int i, transposed to,
                                     mbsri_newton_flow *m)
{
    axes_loads_back(newton, i, to, m, false, false);
}

MBSRI_OUTLINE void full_loads_back(mbsri_newton_sweeps *newton, int i, transposed to,
                                   mbsri_newton_flow *m)
{
    axes_loads_back(newton, i, to, m, true, false);
}

MBSRI_OUTLINE void opened_loads_back(mbsri_newton_sweeps *newton, int i, transposed to,
                                     mbsri_newton_flow *m)
{
    axes_loads_back(newton, i, to, m, true, true);
}

/* ---- leaves to root ---- */

/* Of move_joint; x: what is said of the body's motion, then of its predecessor's. */
MBSRI_INLINE void move_back(mbsri_newton_sweeps *newton, int i, const double *v, double *to,
                            v4 x[4], bool full, bool loops)
{
    const mbsr_model *m = newton->model;
    const mbsri_newton_step *s = newton->step + i;
    const v4 rho = load(s->rho);
    const bool open = loops && s->flags & MBSRI_FRONT;
    if (__builtin_expect((s->flags & MBSRI_MULTI) != 0, 0)) {
        _Alignas(32) double at[16];
        for (int g = 0; g < groups(full); ++g) store(at + 4 * g, x[g]);
        if (open)
            opened_motion_back(newton, i, v, to, at);
        else
            (full ? full_motion_back : narrow_motion_back)(newton, i, v, to, at);
        for (int g = 0; g < groups(full); ++g) x[g] = load(at + 4 * g);
        return;
    }
    if (s->n == 0) {
        x[SPIN] += cross(rho, x[DRIFT]);
        if (full) x[ROTATION] += cross(rho, x[DISPLACEMENT]);
        return;
    }
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    const int u = m->order.u_of[s->u], q = m->order.q_of[s->q];
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
    v4 along = S_w * x[ROTATION];
    if (full) along += S_v * x[DISPLACEMENT];
    const double dq = v[q] + sum3(along), dp = v[m->nq + u],
                 both = newton->by_c * dq + sum3((S_w - load3(col->row)) * x[SPIN] +
                                                 (S_v - load3(col->row + 3)) * x[DRIFT]),
                 du = v[m->nq + m->nu + u] + m->armature[s->u] * dp + both +
                      sum3(S_w * x[SPIN] + S_v * x[DRIFT]);
    if (open) open_motion_back(newton, i, 0, du, both, dp);
    to[q] = both;
    newton->k[s->u] = du;
    newton->p[s->u] = dp;
    x[SPIN] += cross(rho, x[DRIFT]);
    if (full) x[ROTATION] += cross(rho, x[DISPLACEMENT]);
    for (int g = 0; g < 3; ++g)
        x[g] += load3(col->Q + 3 * g) * splat(dp) - load3(col->K + 3 * g) * splat(du);
    if (full) x[3] += load3(col->Q_last) * splat(dp) - load3(col->K_last) * splat(du);
}

MBSRI_INLINE void clear_branches(const mbsri_newton_sweeps *newton)
{
    for (int i = 1; i <= newton->tree->bodies; ++i) {
        const mbsri_newton_step *s = newton->step + i;
        if (!(s->flags & MBSRI_BRANCHES)) continue;
        for (int g = 0; g < 4; ++g) store(newton->x[s->branch] + 4 * g, splat(0.0));
    }
}

/* What its successors say of a body's motion. */
MBSRI_INLINE void gather_motions(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                                 v4 x[4], bool full)
{
    if (s->flags & MBSRI_LEAF)
        for (int g = 0; g < groups(full); ++g) x[g] = splat(0.0);
    if (s->flags & MBSRI_BRANCHES)
        for (int g = 0; g < groups(full); ++g) x[g] += load(newton->x[s->branch] + 4 * g);
}

/* To its predecessor, where that is not next. */
MBSRI_INLINE void hand_motions_over(const mbsri_newton_sweeps *newton, int i, const v4 x[4],
                                    bool full)
{
    const int parent = newton->step[i].parent;
    if (parent == 0 || parent == i - 1) return;
    double *branch = newton->x[newton->step[parent].branch];
    for (int g = 0; g < groups(full); ++g) store(branch + 4 * g, load(branch + 4 * g) + x[g]);
}

MBSRI_INLINE void motions_back(mbsri_newton_sweeps *newton, const double *v, double *to, bool full)
{
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    clear_branches(newton);
    for (int i = newton->tree->bodies; i >= 1; --i) {
        gather_motions(newton, newton->step + i, x, full);
        move_back(newton, i, v, to, x, full, false);
        hand_motions_over(newton, i, x, full);
    }
}

/* ---- root to leaves ---- */

/* What is said of a joint of one axis, and what it says of r. */
typedef struct said {
    double k, p;
    given r;
} said;

/* Of row_of_loads. */
MBSRI_INLINE void row_back(const mbsri_newton_column *col, v4 by_c, double row, loads *f, bool full)
{
    const v4 by = splat(row);
    f->b[CHI_L] += load3(col->row) * by;
    f->b[CHI_P] += load3(col->row + 3) * by;
    f->b[MOMENT] -= by_c * load3(col->S) * by;
    if (full) f->b[FORCE] -= by_c * load3(col->S + 3) * by;
}

/* Of pass_loads. */
MBSRI_INLINE void passed_back(mbsri_newton_column *col, const loads *f, said *a, bool full)
{
    v4 k = splat(0.0), q = splat(0.0);
    for (int r = 0; r < groups(full); ++r) {
        k += load3(group_of(col->C, col->C_last, r)) * f->b[r];
        q += load3(group_of(col->U, col->U_last, r)) * f->b[r];
    }
    a->k += sum3(k);
    a->r.q += sum3(q);
}

/* Of condense_loads. */
MBSRI_INLINE void condense_back(const mbsri_newton_sweeps *newton, int u, loads *f, said *a,
                                bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
    a->r.u += said_along(col->G, f->L_bar, f->p_bar);
    f->b[CHI_L] += S_w * splat(a->p);
    f->b[CHI_P] += S_v * splat(a->p);
    passed_back(col, f, a, full);
    const double row = a->k * col->inverse, w = row - a->p;
    a->r.p += newton->by_c * row;
    a->r.tau += newton->by_c * row;
    a->r.q -= col->gain * row;
    a->r.u += w;
    row_back(col, splat(newton->by_c), -row, f, full);
    f->L_bar += S_w * splat(w);
    f->p_bar += S_v * splat(w);
}

/* Of balance_loads. */
MBSRI_INLINE void balance_back(const mbsri_newton_sweeps *newton, int u, loads *f, said *a,
                               bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const mbsri_newton_below_massless *below = newton->below + u;
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
    a->r.p += newton->by_c * a->p;
    f->b[CHI_L] += S_w * splat(a->p);
    f->b[CHI_P] += S_v * splat(a->p);
    passed_back(col, f, a, full);
    row_back(col, splat(newton->by_c), -a->p, f, full);
    const double rest = (a->k - below->pivot * a->p) * col->inverse;
    a->r.q -= below->gain * a->p + col->gain * rest;
    a->r.u += rest;
    a->r.tau += newton->by_c * a->p + rest;
    f->psi[PSI_L] -= S_w * splat(rest);
    f->psi[PSI_P] -= S_v * splat(rest);
}

/* Of condense_below_massless. */
MBSRI_INLINE void below_massless_back(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                                      loads *f, said *a, bool full)
{
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    if (!(s->below_massless & MBSRI_BELOW_MASSLESS)) {
        condense_back(newton, s->u, f, a, full);
        return;
    }
    const mbsri_newton_below_massless *below = newton->below + s->u;
    const double taken = said_along(col->G, f->psi[PSI_L], f->psi[PSI_P]);
    a->k += said_along(below->C, f->psi[PSI_L], f->psi[PSI_P]);
    a->r.q += said_along(below->U, f->psi[PSI_L], f->psi[PSI_P]);
    if (s->below_massless & MBSRI_NO_INERTIA) {
        balance_back(newton, s->u, f, a, full);
        return;
    }
    a->r.tau += taken;
    f->psi[PSI_L] -= load3(col->S) * splat(taken);
    f->psi[PSI_P] -= load3(col->S + 3) * splat(taken);
    condense_back(newton, s->u, f, a, full);
}

/* Of condense_open. */
MBSRI_OUTLINE void open_back(mbsri_newton_sweeps *newton, int i, loads *f, said *a,
                             bool below_massless)
{
    const mbsri_newton_step *s = newton->step + i;
    double rest = 0.0;
    open_rights_back(newton, i, &a->k, &a->r.q, &rest);
    if (s->n == 0) return;
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    if (below_massless)
        below_massless_back(newton, s, f, a, true);
    else
        condense_back(newton, s->u, f, a, true);
    a->r.u += rest;
    a->r.tau += rest;
    a->r.q -= col->gain * rest;
    f->psi[PSI_L] -= load3(col->S) * splat(rest);
    f->psi[PSI_P] -= load3(col->S + 3) * splat(rest);
}

/* Of condense_joint. */
MBSRI_INLINE void joint_back(mbsri_newton_sweeps *newton, int i, transposed to, loads *f, bool full,
                             bool below_massless, bool loops)
{
    const mbsr_model *m = newton->model;
    const mbsri_newton_step *s = newton->step + i;
    const bool open = loops && s->flags & MBSRI_FRONT;
    if (__builtin_expect((s->flags & MBSRI_MULTI) != 0, 0)) {
        _Alignas(32) mbsri_newton_flow multi;
        loads_to_memory(f, &multi, full, below_massless);
        if (open)
            opened_loads_back(newton, i, to, &multi);
        else
            (full ? full_loads_back : narrow_loads_back)(newton, i, to, &multi);
        clear_loads(f);
        add_loads(&multi, f, full, below_massless);
    } else if (s->n) {
        const int u = m->order.u_of[s->u];
        said a = {newton->k[s->u], newton->p[s->u], {0.0, 0.0, 0.0, 0.0}};
        if (open)
            open_back(newton, i, f, &a, below_massless);
        else if (below_massless)
            below_massless_back(newton, s, f, &a, full);
        else
            condense_back(newton, s->u, f, &a, full);
        to.x[m->order.q_of[s->q]] += a.r.q;
        to.x[m->nq + u] = a.r.p;
        to.x[m->nq + m->nu + u] = a.r.u;
        if (to.tau) to.tau[u] = a.r.tau;
    } else if (open) {
        said none = {0.0, 0.0, {0.0, 0.0, 0.0, 0.0}};
        open_back(newton, i, f, &none, false);
    }
}

/* What is said of the loads that body i hands on, as its predecessor's are. */
MBSRI_INLINE void gather_said(const mbsri_newton_sweeps *newton, int i, loads *f, bool full,
                              bool below_massless)
{
    const mbsri_newton_step *s = newton->step + i;
    const v4 rho = load(s->rho);
    if (s->parent != i - 1 || i == 1) clear_loads(f);
    if (s->parent > 0 && s->parent != i - 1)
        add_loads(newton->said + newton->step[s->parent].branch, f, full, below_massless);
    f->b[CHI_P] += cross(f->b[CHI_L], rho);
    if (full) f->b[FORCE] += cross(f->b[MOMENT], rho);
    f->p_bar += cross(f->L_bar, rho);
    if (below_massless) f->psi[PSI_P] += cross(f->psi[PSI_L], rho);
}

MBSRI_INLINE void loads_back(mbsri_newton_sweeps *newton, transposed to, bool full,
                             bool below_massless)
{
    loads f;
    clear_loads(&f);
    for (int i = 1; i <= newton->tree->bodies; ++i) {
        const mbsri_newton_step *s = newton->step + i;
        gather_said(newton, i, &f, full, below_massless);
        joint_back(newton, i, to, &f, full, below_massless, false);
        if (s->flags & MBSRI_BRANCHES)
            loads_to_memory(&f, newton->said + s->branch, full, below_massless);
    }
}

MBSRI_INLINE void solve_system_transposed(mbsri_newton_sweeps *newton, const double *v,
                                          transposed to)
{
    if (newton->acting.own) {
        motions_back(newton, v, to.x, true);
        loads_back(newton, to, true, newton->last.below_massless);
    } else if (newton->last.below_massless) {
        motions_back(newton, v, to.x, false);
        loads_back(newton, to, false, true);
    } else {
        motions_back(newton, v, to.x, false);
        loads_back(newton, to, false, false);
    }
}

#endif
