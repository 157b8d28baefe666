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
           sum3(r_w * load(T) + r_v * load(T + 4) + by_c * k->rotated * l->S_w);
}

/* E and the gain: what du and g add to the rows; size: of what was summed in each row of E. */
MBSRI_INLINE void find_rows(int n, v4 by_c, const axis *a, mbsri_newton_block *B,
                            double slope[6][6], v4 (*C)[4], v4 (*U)[4], double E[6][6],
                            double size[6], bool full)
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

/* A joint of several axes on the way: C, U, E and the sizes of what was summed in it; the rows over
 * x_h, and what they become. */
typedef struct axes {
    int n;
    axis a[6];
    v4 C[6][4], U[6][4], R[6][4], K[6][4];
    double E[6][6], size[6];
} axes;

/* C and U, with what all columns add to the forces at h. */
MBSRI_INLINE void find_columns(int n, const slab *y, const axis *a, const mbsri_newton_block *B,
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

/* The records of the joint's columns, from the rows of d(M u) over x_h and K. */
MBSRI_INLINE void keep_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, axes *p,
                            v4 (*Q)[4], bool full)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const v4 rho = load(run->state[i].rho), none = splat(0.0);
    for (int k = 0; k < b->n; ++k) {
        mbsri_newton_column *col = mbsri_newton_column_at(newton, b->u + k);
        const double *G = run->multi[b->multi].G[k];
        const bool on_root = b->parent == 0; /* nothing is handed on there, and G not known */
        const v4 kept[2] = {on_root ? none : load(G), on_root ? none : load(G + 4)};
        translate_row(rho, p->K[k], full);
        translate_row(rho, Q[k], full);
        keep_column(col, p->a + k, p->K[k], Q[k], p->C[k], p->U[k], kept, full);
    }
}

/* The same of a joint that is eliminated; P behind it. */
MBSRI_INLINE void keep_columns(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                               axes *p, slab *y, bool full)
{
    v4 Q[6][4];
    for (int k = 0; k < p->n; ++k) subtract_column(y, p->C[k], p->K[k], full);
    for (int k = 0; k < p->n; ++k) momentum_row(y, p->a[k].S_w, p->a[k].S_v, Q[k], full);
    keep_axes(run, i, newton, p, Q, full);
}

/* What the joint's columns and the motion before it do to the forces on the predecessor. */
static void add_on_predecessor(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                               axes *p, slab *y)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    for (int j = 0; j < b->n; ++j) {
        v4 x[4], J[4];
        motion_by(b->n, p->a, newton->block + b->multi, j, x, J);
        apply_slopes(&on, x, p->U[j]);
        x[SPIN] += p->a[j].S_w;
        x[DRIFT] += p->a[j].S_v;
        apply_slopes(&on, x, p->C[j]);
    }
    add_slopes(&on, y);
}

/* C, U and E; false: the equation of a quaternion is singular. */
MBSRI_INLINE bool open_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, axes *p,
                            slab *y, bool full)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_newton_block *B = newton->block + b->multi;
    const int n = p->n = b->n;
    double slope[6][6];
    find_steps(run, i, B);
    if (!find_ratio(n, newton->c, newton->by_c, B)) return false;
    find_axes(run, i, y, newton->by_c, B, p->a);
    find_slopes(n, newton->by_c, B, slope);
    find_columns(n, y, p->a, B, p->C, p->U, full);
    find_rows(n, splat(newton->by_c), p->a, B, slope, p->C, p->U, p->E, p->size, full);
    return true;
}

/* R, K and what elements owe to the predecessor's motion; delayed: the joint's unknowns are not
 * eliminated here (multi_fronts.h). False: the rows are singular. */
MBSRI_INLINE bool close_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             axes *p, slab *y, bool full, bool delayed)
{
    mbsri_newton_block *B = newton->block + run->tree->body[i].multi;
    const bool pair = is_pair(newton, i, full);
    const int n = p->n;
    if (!delayed && !invert(n, p->E, p->size, newton->least_pivot, B->inverse)) return false;
    if (pair) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        add_slopes(&by, y);
    }
    for (int k = 0; k < n; ++k) joint_row(y, p->a + k, splat(newton->by_c), p->R[k], full);
    for (int k = 0; k < n; ++k) {
        for (int g = 0; g < groups(full); ++g) {
            p->K[k][g] = splat(0.0);
            for (int l = 0; l < n && !delayed; ++l)
                p->K[k][g] += splat(B->inverse[k][l]) * p->R[l][g];
        }
    }
    if (pair) add_on_predecessor(run, i, newton, p, y);
    return true;
}

MBSRI_INLINE bool eliminate_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 mbsri_newton_carry *m, bool full)
{
    axes p;
    slab y;
    clear_slab(&y, full);
    add_slab(m, &y, full);
    if (!open_axes(run, i, newton, &p, &y, full)) return false;
    if (!close_axes(run, i, newton, &p, &y, full, false)) return false;
    keep_columns(run, i, newton, &p, &y, full);
    slab_to_memory(&y, m, full);
    return true;
}

/* Through such a joint, each case compiled by itself; false: its rows are singular. */
MBSRI_OUTLINE bool eliminate_full_axes(const mbsri_sweep_run *run, int i,
                                       mbsri_newton_sweeps *newton, mbsri_newton_carry *m)
{
    return eliminate_axes(run, i, newton, m, true);
}

MBSRI_OUTLINE bool eliminate_narrow_axes(const mbsri_sweep_run *run, int i,
                                         mbsri_newton_sweeps *newton, mbsri_newton_carry *m)
{
    return eliminate_axes(run, i, newton, m, false);
}

MBSRI_INLINE bool eliminate_multi(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                  mbsri_newton_carry *m, bool full)
{
    return full ? eliminate_full_axes(run, i, newton, m) : eliminate_narrow_axes(run, i, newton, m);
}

#endif
