/* Joints of several axes in the solution of the Newton sweeps: see multi_axis.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_MULTI_AXIS_SOLVE_H
#define MBSRI_NEWTON_MULTI_AXIS_SOLVE_H

#include "newton/sweeps/multi_fronts.h"

/* g (n) from r_q in the caller's order; returns r_s, of a quaternion. */
static double rates_of(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                       const double *r, double g[6])
{
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.q_of + s->q;
    for (int k = 0; k < s->n; ++k) g[k] = r ? r[place[k + B->quaternion]] : 0.0;
    if (!B->quaternion || !r) return 0.0;
    double quotient[4];
    const double *q = B->q, size = q[0] * q[0] + mbsri_dot3(q + 1, q + 1);
    const double one[4] = {r[place[0]], r[place[1]], r[place[2]], r[place[3]]};
    /* r conj(q) / |q|^2 */
    mbsri_cross3(q + 1, one + 1, quotient + 1);
    mbsri_add3(q[0], one + 1, quotient + 1);
    mbsri_add3(-one[0], q + 1, quotient + 1);
    quotient[0] = (one[0] * q[0] + mbsri_dot3(one + 1, q + 1)) / size;
    for (int k = 0; k < 3; ++k)
        g[k] = 2.0 * quotient[1 + k] / size + B->u[k] * quotient[0] * newton->by_c;
    return quotient[0];
}

/* open: loops are carried past the joint. */
MBSRI_INLINE void load_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                            const double *load_of_body, mbsri_newton_flow *m, bool full, bool open)
{
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.u_of + s->u, n = s->n;
    const double *r_p = r ? r + newton->model->nq : NULL, *r_u = r ? r_p + newton->model->nu : NULL;
    const v4 by_c = splat(newton->by_c);
    const bool delayed = open && s->below_massless & MBSRI_NO_INERTIA;
    double g[6], known[6], w[6], rest[6];
    const double r_s = rates_of(newton, s, r, g);
    for (int k = 0; k < n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
        w[k] = (r ? r_u[place[k]] : 0.0) + sum3(S_w * load(m->L_bar) + S_v * load(m->p_bar));
        v4 row = load3(col->row) * load(m->b) + load3(col->row + 3) * load(m->b + 4) -
                 by_c * S_w * load(m->b + 8);
        if (full) row -= by_c * S_v * load(m->b + 12);
        const double tau =
            load_of_body ? load_of_body[newton->model->size.v + (size_t)(s->u + k)] : 0.0;
        known[k] = newton->by_c * tau + (r ? newton->by_c * r_p[place[k]] : 0.0) + w[k] -
                   sum3(row) + B->length[k] * r_s;
        for (int l = 0; l < n; ++l) known[k] -= B->gain[k][l] * g[l];
        rest[k] = (r ? r_u[place[k]] : 0.0) + tau;
    }
    if (delayed) balance_axes(newton, i, g, r_s, m, rest);
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        double own = 0.0;
        for (int l = 0; l < n && !delayed; ++l) own += B->inverse[k][l] * known[l];
        newton->k[s->u + k] = own;
        for (int f = 0; f < groups(full); ++f)
            store(m->b + 4 * f, load(m->b + 4 * f) +
                                    load3(group_of(col->C, col->C_last, f)) * splat(own) +
                                    load3(group_of(col->U, col->U_last, f)) * splat(g[k]));
    }
    if (open) pass_rights_of_axes(newton, i, g, rest);
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        newton->p[s->u + k] =
            sum3(load3(col->S) * load(m->b) + load3(col->S + 3) * load(m->b + 4)) - w[k] +
            (delayed ? known[k] : 0.0);
        if (!r) continue;
        store(m->L_bar, load(m->L_bar) + load3(col->G) * splat(r_u[place[k]]));
        store(m->p_bar, load(m->p_bar) + load3(col->G + 3) * splat(r_u[place[k]]));
    }
}

/* delta_q from w: (0, w) q / 2 + lambda q for a quaternion. */
static void place_rates(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                        const double w[6], double r_s, double *delta)
{
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->order.q_of + s->q;
    for (int k = 0; k < s->n; ++k) delta[place[k + B->quaternion]] = w[k];
    if (!B->quaternion) return;
    const double *q = B->q, lambda = newton->by_c * (r_s - 0.25 * mbsri_dot3(B->u, w));
    double turned[3];
    mbsri_cross3(w, q + 1, turned);
    delta[place[0]] = lambda * q[0] - 0.5 * mbsri_dot3(w, q + 1);
    for (int k = 0; k < 3; ++k)
        delta[place[1 + k]] = lambda * q[1 + k] + 0.5 * (turned[k] + q[0] * w[k]);
}

/* at: the predecessor's motion, overwritten by the body's. */
MBSRI_INLINE void move_axes(mbsri_newton_sweeps *newton, int i, const double *r, double *delta,
                            double at[16], bool full, bool open)
{
    const mbsr_model *m = newton->model;
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = m->order.u_of + s->u, n = s->n;
    double g[6], du[6], w[6] = {0.0}, p[6];
    v4 x[4];
    const double r_s = rates_of(newton, s, r, g);
    for (int f = 0; f < groups(full); ++f) x[f] = load(at + 4 * f);
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        v4 K = splat(0.0), Q = splat(0.0);
        for (int f = 0; f < groups(full); ++f) {
            K += load3(group_of(col->K, col->K_last, f)) * x[f];
            Q += load3(group_of(col->Q, col->Q_last, f)) * x[f];
        }
        du[k] = newton->k[s->u + k] - sum3(K);
        p[k] = newton->p[s->u + k] + sum3(Q);
    }
    if (open) move_open_axes(newton, i, du, g, p);
    const v4 rho = load(s->rho);
    x[DRIFT] += cross(x[SPIN], rho);
    if (full) x[DISPLACEMENT] += cross(x[ROTATION], rho);
    for (int k = 0; k < n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        w[k] = 0.0;
        for (int l = 0; l < n; ++l) w[k] += B->A[k][l] * (du[l] + g[l]);
        const v4 S_w = load3(col->S), S_v = load3(col->S + 3), by_u = splat(du[k]),
                 by_w = splat(w[k]);
        x[ROTATION] += S_w * by_w;
        x[SPIN] += S_w * by_u + load(B->T[k]) * by_w;
        x[DRIFT] += S_v * by_u + load(B->T[k] + 4) * by_w;
        if (full) x[DISPLACEMENT] += S_v * by_w;
    }
    for (int f = 0; f < groups(full); ++f) store(at + 4 * f, x[f]);
    place_rates(newton, s, w, r_s, delta);
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < n; ++l) p[k] -= B->couple[k][l] * w[l];
        delta[m->nq + place[k]] = p[k] + m->armature[s->u + k] * du[k];
        delta[m->nq + m->nu + place[k]] = du[k];
    }
}

/* ---- each case compiled by itself ---- */

MBSRI_OUTLINE void load_narrow_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                    const double *load_of_body, mbsri_newton_flow *m)
{
    load_axes(newton, i, r, load_of_body, m, false, false);
}

MBSRI_OUTLINE void load_full_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                  const double *load_of_body, mbsri_newton_flow *m)
{
    load_axes(newton, i, r, load_of_body, m, true, false);
}

MBSRI_OUTLINE void load_open_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                  const double *load_of_body, mbsri_newton_flow *m)
{
    load_axes(newton, i, r, load_of_body, m, true, true);
}

MBSRI_OUTLINE void move_narrow_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                    double *delta, double at[16])
{
    move_axes(newton, i, r, delta, at, false, false);
}

MBSRI_OUTLINE void move_full_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                  double *delta, double at[16])
{
    move_axes(newton, i, r, delta, at, true, false);
}

MBSRI_OUTLINE void move_opened_axes(mbsri_newton_sweeps *newton, int i, const double *r,
                                    double *delta, double at[16])
{
    move_axes(newton, i, r, delta, at, true, true);
}

MBSRI_INLINE void multi_loads(mbsri_newton_sweeps *newton, int i, const double *r,
                              const double *load_of_body, mbsri_newton_flow *m, bool full,
                              bool open)
{
    if (open)
        load_open_axes(newton, i, r, load_of_body, m);
    else if (full)
        load_full_axes(newton, i, r, load_of_body, m);
    else
        load_narrow_axes(newton, i, r, load_of_body, m);
}

MBSRI_INLINE void multi_motion(mbsri_newton_sweeps *newton, int i, const double *r, double *delta,
                               double at[16], bool full, bool open)
{
    if (open)
        move_opened_axes(newton, i, r, delta, at);
    else if (full)
        move_full_axes(newton, i, r, delta, at);
    else
        move_narrow_axes(newton, i, r, delta, at);
}

#endif
