/* Joints of several axes, of prescribed ones, or with a quaternion, in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Axes l before axis k move it: with h the motion before the whole joint and dq, w for those of the
 * columns,
 *
 *   motion before k = h + sum over l before k of (S_l w_l, S_l du_l + T_l w_l)
 *   forces before k = those at h - sum over l before k of w_l J_l
 *   T_l = V_after x S_l,   J_l = (S_l x* (L, p), S_v x F)
 *
 * A quaternion is three columns with one motion before and one after all of them. With
 *
 *   q' = (0, u) q / 2,   dq = (0, w) q / 2 + lambda q,   r = r_q conj(q) / |q|^2
 *
 * its perturbed equation is
 *
 *   c w - u x w / 2 - lambda u = du + 2 r_v,   c lambda + u . w / 4 = r_s
 *
 * so that w = A (du + g), A^-1 = c 1 - [u]x / 2 + u u^T / (4 c), g = 2 r_v + u r_s / c. */
#ifndef MBSRI_NEWTON_MULTI_AXIS_H
#define MBSRI_NEWTON_MULTI_AXIS_H

#include "algebra/space3.h"
#include "joints/chain.h"
#include "newton/sweeps/axis.h"
#include "newton/sweeps/element_slopes.h"

#include <math.h>
#include <string.h>

/* X = A^-1, both by rows, or false where a pivot is small (`least`) relative to size, the sizes of
 * what was summed in its row; A is overwritten. */
static bool invert(int n, double A[6][6], const double size[6], double least, double X[6][6])
{
    int row[6];
    for (int k = 0; k < n; ++k) {
        row[k] = k;
        for (int l = 0; l < n; ++l) X[k][l] = k == l ? 1.0 : 0.0;
    }
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int l = k + 1; l < n; ++l) {
            if (fabs(A[l][k]) * size[row[best]] > fabs(A[best][k]) * size[row[l]]) best = l;
        }
        for (int l = 0; l < n; ++l) {
            const double a = A[k][l], x = X[k][l];
            A[k][l] = A[best][l], A[best][l] = a;
            X[k][l] = X[best][l], X[best][l] = x;
        }
        const int from = row[k];
        row[k] = row[best], row[best] = from;
        if (!(fabs(A[k][k]) > least * size[row[k]])) return false;
        const double pivot = 1.0 / A[k][k];
        for (int l = 0; l < n; ++l) A[k][l] *= pivot, X[k][l] *= pivot;
        for (int j = 0; j < n; ++j) {
            const double factor = A[j][k];
            for (int l = 0; l < n && j != k; ++l) {
                A[j][l] -= factor * A[k][l];
                X[j][l] -= factor * X[k][l];
            }
        }
    }
    return true;
}

/* The columns' places in the sequence of axes, and the state of a quaternion. */
static void find_steps(const mbsri_sweep_run *run, int i, mbsri_newton_block *B)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const int *option = run->tree->joint[b->multi].chain.option;
    B->quaternion = 0;
    for (int step = 0; step < option[0]; ++step) {
        const int code = option[1 + step];
        if ((code & MBSRI_STEP_KIND) == MBSRI_QUATERNION) {
            B->quaternion = 1;
            for (int k = 0; k < 3; ++k) B->step[k] = step;
            for (int k = 0; k < 3; ++k) B->u[k] = run->u[b->u + k];
            for (int k = 0; k < 4; ++k) B->q[k] = run->q[b->q + k];
        } else if (!(code & MBSRI_DRIVEN)) {
            B->step[code >> MBSRI_PLACE_SHIFT] = step;
        }
    }
}

/* S, S', J and, in the block, T. */
static void find_axes(const mbsri_sweep_run *run, int i, const slab *y, double by_c,
                      mbsri_newton_block *B, axis *a)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    const v4 v = load(run->state[i].v);
    v4 turn_w = splat(0.0), turn_v = splat(0.0);
    for (int k = 0; k < b->n; ++k) {
        a[k].S_w = load(multi->S[k]);
        a[k].S_v = load(multi->S[k] + 4);
        a[k].rate_w = load(multi->Sdot[k]);
        /* the rate at a fixed point; Sdot is that at the body's point */
        a[k].rate_v = load(multi->Sdot[k] + 4) - cross(a[k].S_w, v);
        finish_axis(y, by_c, a + k);
        if (B->quaternion && k < 3) {
            turn_w += a[k].S_w * splat(B->u[k]);
            turn_v += a[k].S_v * splat(B->u[k]);
        }
    }
    for (int k = 0; k < b->n; ++k) {
        v4 T_w = a[k].rate_w, T_v = a[k].rate_v;
        if (B->quaternion && k < 3) {
            T_w += cross(turn_w, a[k].S_w);
            T_v += cross(turn_w, a[k].S_v) + cross(turn_v, a[k].S_w);
        }
        store(B->T[k], T_w);
        store(B->T[k] + 4, T_v);
    }
}

/* A of w = A (du + g). */
static bool find_ratio(int n, double c, double by_c, mbsri_newton_block *B)
{
    memset(B->A, 0, sizeof B->A);
    for (int k = 0; k < n; ++k) B->A[k][k] = by_c;
    if (!B->quaternion) return true;
    const double *u = B->u;
    double M[6][6] = {{c, 0.5 * u[2], -0.5 * u[1]},
                      {-0.5 * u[2], c, 0.5 * u[0]},
                      {0.5 * u[1], -0.5 * u[0], c}},
           X[6][6], size[6];
    for (int k = 0; k < 3; ++k) {
        size[k] = 0.0;
        for (int l = 0; l < 3; ++l) {
            M[k][l] += 0.25 * by_c * u[k] * u[l];
            size[k] += fabs(M[k][l]);
        }
    }
    if (!invert(3, M, size, MBSRI_LEAST_PIVOT, X)) return false;
    for (int k = 0; k < 3; ++k) memcpy(B->A[k], X[k], 3 * sizeof(double));
    return true;
}

/* dtau = slope w + tau_u du + ...: tau_q over the columns; and over the length of a quaternion. */
static void find_slopes(int n, double by_c, mbsri_newton_block *B, double slope[6][6])
{
    const double *q = B->q, *u = B->u;
    /* rows of (0, e_l) q / 2 */
    const double H[3][4] = {{-0.5 * q[1], 0.5 * q[0], -0.5 * q[3], 0.5 * q[2]},
                            {-0.5 * q[2], 0.5 * q[3], 0.5 * q[0], -0.5 * q[1]},
                            {-0.5 * q[3], -0.5 * q[2], 0.5 * q[1], 0.5 * q[0]}};
    for (int k = 0; k < n; ++k) {
        double along = 0.0;
        for (int l = 0; l < n; ++l) slope[k][l] = B->tau_q[k][l + B->quaternion];
        for (int j = 0; j < 4 && B->quaternion; ++j) along += B->tau_q[k][j] * q[j];
        for (int l = 0; l < 3 && B->quaternion; ++l) {
            slope[k][l] = -0.25 * by_c * u[l] * along;
            for (int j = 0; j < 4; ++j) slope[k][l] += B->tau_q[k][j] * H[l][j];
        }
        B->length[k] = by_c * by_c * along;
    }
}

/* What w_l adds to the row of k beyond what it does at h; `du`: du_l instead. */
static double corrected(const axis *k, const axis *l, const double T[8], v4 by_c, bool du)
{
    const v4 r_w = by_c * k->J[CHI_L], r_v = by_c * k->J[CHI_P];
    if (du) return -sum3(r_w * l->S_w + r_v * l->S_v);
    return -sum3(along_row(k, by_c, l->J, false)) -
           sum3(r_w * load(T) + r_v * load(T + 4) + by_c * k->turned * l->S_w);
}

/* E and the gain: what du and g add to the rows; size: of what was summed in each row of E. */
static void find_rows(int n, v4 by_c, const axis *a, mbsri_newton_block *B, double slope[6][6],
                      v4 (*C)[4], v4 (*U)[4], double E[6][6], double size[6], bool full)
{
    for (int k = 0; k < n; ++k) {
        double more[6]; /* over w */
        size[k] = 0.0;
        for (int l = 0; l < n; ++l) {
            const bool before = B->step[l] < B->step[k];
            B->couple[k][l] =
                before ? sum3(a[k].S_w * a[l].J[CHI_L] + a[k].S_v * a[l].J[CHI_P]) : 0.0;
            more[l] = (before ? corrected(a + k, a + l, B->T[l], by_c, false) : 0.0) -
                      by_c[0] * slope[k][l];
        }
        for (int j = 0; j < n; ++j) {
            double by_w = 0.0;
            for (int l = 0; l < n; ++l) by_w += more[l] * B->A[l][j];
            const double by_u =
                (B->step[j] < B->step[k] ? corrected(a + k, a + j, NULL, by_c, true) : 0.0) -
                by_c[0] * B->tau_u[k][j];
            E[k][j] = sum3(along_row(a + k, by_c, C[j], full)) + by_w + by_u;
            B->gain[k][j] = sum3(along_row(a + k, by_c, U[j], full)) + by_w;
            size[k] = fmax(size[k], size_of_row(a + k, by_c, C[j], full) + fabs(by_w) + fabs(by_u));
        }
    }
}

/* The motion of the body by g_j, and by w the forces at h. */
static void motion_by(int n, const axis *a, const mbsri_newton_block *B, int j, v4 x[4], v4 J[4])
{
    for (int g = 0; g < 4; ++g) x[g] = J[g] = splat(0.0);
    for (int l = 0; l < n; ++l) {
        const v4 w = splat(B->A[l][j]);
        x[ROTATION] += a[l].S_w * w;
        x[SPIN] += load(B->T[l]) * w;
        x[DRIFT] += load(B->T[l] + 4) * w;
        x[DISPLACEMENT] += a[l].S_v * w;
        for (int r = 0; r < 3; ++r) J[r] += a[l].J[r] * w;
    }
}

/* C and U, with what all columns add to the forces at h. */
static void find_columns(int n, const slab *y, const axis *a, const mbsri_newton_block *B,
                         v4 (*C)[4], v4 (*U)[4], bool full)
{
    for (int j = 0; j < n; ++j) {
        v4 x[4], J[4];
        motion_by(n, a, B, j, x, J);
        apply_slab(y, x, U[j], full);
        x[SPIN] += a[j].S_w;
        x[DRIFT] += a[j].S_v;
        apply_slab(y, x, C[j], full);
        for (int r = 0; r < groups(full); ++r) {
            C[j][r] += J[r];
            U[j][r] += J[r];
        }
    }
}

/* The records of the joint's columns; P behind it. */
static void keep_columns(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                         const axis *a, v4 (*K)[4], v4 (*C)[4], v4 (*U)[4], slab *y, bool full)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const v4 rho = load(run->state[i].rho), none = splat(0.0);
    for (int k = 0; k < b->n; ++k) subtract_column(y, C[k], K[k], full);
    for (int k = 0; k < b->n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, b->u + k);
        const double *G = run->multi[b->multi].G[k];
        const bool on_root = b->parent == 0; /* nothing is handed on there, and G not known */
        v4 Q[4];
        momentum_row(y, a[k].S_w, a[k].S_v, Q, full);
        translate_row(rho, K[k], full);
        translate_row(rho, Q, full);
        const v4 kept[2] = {on_root ? none : load(G), on_root ? none : load(G + 4)};
        keep_column(col, a + k, K[k], Q, C[k], U[k], kept, full);
    }
}

/* What the joint's columns and the motion before it do to the forces on the predecessor. */
static void add_on_predecessor(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                               const axis *a, v4 (*C)[4], v4 (*U)[4], slab *y)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    for (int j = 0; j < b->n; ++j) {
        v4 x[4], J[4];
        motion_by(b->n, a, newton->block + b->multi, j, x, J);
        apply_slopes(&on, x, U[j]);
        x[SPIN] += a[j].S_w;
        x[DRIFT] += a[j].S_v;
        apply_slopes(&on, x, C[j]);
    }
    add_slopes(&on, y);
}

static bool eliminate_multi(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                            mbsri_newton_carry *m, bool full)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_newton_block *B = newton->block + b->multi;
    const v4 by_c = splat(newton->by_c);
    const int n = b->n;
    axis a[6];
    slab y;
    v4 C[6][4], U[6][4], R[6][4], K[6][4];
    double slope[6][6], E[6][6], size[6];
    clear_slab(&y, full);
    add_slab(m, &y, full);
    find_steps(run, i, B);
    if (!find_ratio(n, newton->c, newton->by_c, B)) return false;
    find_axes(run, i, &y, newton->by_c, B, a);
    find_slopes(n, newton->by_c, B, slope);
    find_columns(n, &y, a, B, C, U, full);
    find_rows(n, by_c, a, B, slope, C, U, E, size, full);
    if (!invert(n, E, size, newton->least_pivot, B->inverse)) return false;
    const bool pair = is_pair(newton, i, full);
    if (pair) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        add_slopes(&by, &y);
    }
    for (int k = 0; k < n; ++k) joint_row(&y, a + k, by_c, R[k], full);
    for (int k = 0; k < n; ++k) {
        for (int g = 0; g < groups(full); ++g) {
            K[k][g] = splat(0.0);
            for (int l = 0; l < n; ++l) K[k][g] += splat(B->inverse[k][l]) * R[l][g];
        }
    }
    if (pair) add_on_predecessor(run, i, newton, a, C, U, &y);
    keep_columns(run, i, newton, a, K, C, U, &y, full);
    slab_to_memory(&y, m, full);
    return true;
}

/* ---- the solution ---- */

/* g (n) from r_q in the caller's order; returns r_s, of a quaternion. */
static double rates_of(const mbsri_newton_sweeps *newton, const mbsri_newton_step *s,
                       const double *r, double g[6])
{
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->q_of + s->q;
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

static void multi_loads(mbsri_newton_sweeps *newton, int i, const double *r,
                        const double *load_of_body, mbsri_newton_flow *m, bool full)
{
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = newton->model->u_of + s->u, n = s->n;
    const double *r_p = r ? r + newton->model->nq : NULL, *r_u = r ? r_p + newton->model->nu : NULL;
    const v4 by_c = splat(newton->by_c);
    double g[6], known[6], w[6];
    const double r_s = rates_of(newton, s, r, g);
    for (int k = 0; k < n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
        w[k] = (r ? r_u[place[k]] : 0.0) + sum3(S_w * load(m->L_bar) + S_v * load(m->p_bar));
        v4 row = load3(col->row) * load(m->b) + load3(col->row + 3) * load(m->b + 4) -
                 by_c * S_w * load(m->b + 8);
        if (full) row -= by_c * S_v * load(m->b + 12);
        const double tau =
            load_of_body ? load_of_body[newton->model->size_v + (size_t)(s->u + k)] : 0.0;
        known[k] = newton->by_c * tau + (r ? newton->by_c * r_p[place[k]] : 0.0) + w[k] -
                   sum3(row) + B->length[k] * r_s;
        for (int l = 0; l < n; ++l) known[k] -= B->gain[k][l] * g[l];
    }
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        double own = 0.0;
        for (int l = 0; l < n; ++l) own += B->inverse[k][l] * known[l];
        newton->k[s->u + k] = own;
        for (int f = 0; f < groups(full); ++f)
            store(m->b + 4 * f, load(m->b + 4 * f) +
                                    load3(group_of(col, col->C, LAST_C, f)) * splat(own) +
                                    load3(group_of(col, col->U, LAST_U, f)) * splat(g[k]));
    }
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        newton->p[s->u + k] =
            sum3(load3(col->S) * load(m->b) + load3(col->S + 3) * load(m->b + 4)) - w[k];
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
    const int *place = newton->model->q_of + s->q;
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
static void multi_motion(mbsri_newton_sweeps *newton, int i, const double *r, double *delta,
                         double at[16], bool full)
{
    const mbsr_model *m = newton->model;
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    const int *place = m->u_of + s->u, n = s->n;
    double g[6], du[6], w[6] = {0.0}, p[6];
    v4 x[4];
    const double r_s = rates_of(newton, s, r, g);
    for (int f = 0; f < groups(full); ++f) x[f] = load(at + 4 * f);
    for (int k = 0; k < n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        v4 K = splat(0.0), Q = splat(0.0);
        for (int f = 0; f < groups(full); ++f) {
            K += load3(group_of(col, col->K, LAST_K, f)) * x[f];
            Q += load3(group_of(col, col->Q, LAST_Q, f)) * x[f];
        }
        du[k] = newton->k[s->u + k] - sum3(K);
        p[k] = newton->p[s->u + k] + sum3(Q);
    }
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

#endif
