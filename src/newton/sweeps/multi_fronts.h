/* Joints of several axes past which open loops are carried: as fronts.h, with
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   du = k - K x_h - z v        z = E^-1 (rows of the joint along Q + gain e)
 *   Q_h = Q + U e - C z         R_h = R - m K     T_h = T + n e - m z     s_h = s - n g - m k
 *
 * summed over the axes; eta moves a joint as g would (multi_axis.h), also one with a quaternion. */
#ifndef MBSRI_NEWTON_MULTI_FRONTS_H
#define MBSRI_NEWTON_MULTI_FRONTS_H

#include "newton/sweeps/fronts.h"
#include "newton/sweeps/multi_axis.h"

/* Unknown l through the joint of body i. */
static void carry_column_of_axes(const mbsri_sweep_run *run, int i,
                                 const mbsri_newton_sweeps *newton, const axes *p,
                                 const joint_front *j, int l)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_newton_block *B = newton->block + b->multi;
    const double *from = j->from.Q + l * MBSRI_SWEPT_ACTIONS,
                 *sum = j->from.kappa + l * MBSRI_SWEPT_FORCES, *weight = run->model->weight + b->u;
    v4 Q[4], kappa[2] = {load3(sum), load3(sum + 4)};
    double e[6], g[6], z[6];
    for (int r = 0; r < 4; ++r) Q[r] = load3(from + 4 * r);
    for (int k = 0; k < p->n; ++k)
        e[k] = weight[k] * sum3(p->a[k].S_w * kappa[0] + p->a[k].S_v * kappa[1]);
    for (int k = 0; k < p->n; ++k) {
        g[k] = sum3(along_row(p->a + k, j->by_c, Q, true));
        for (int o = 0; o < p->n; ++o) g[k] += B->gain[k][o] * e[o];
    }
    for (int k = 0; k < p->n; ++k) {
        z[k] = 0.0;
        for (int o = 0; o < p->n; ++o) z[k] += B->inverse[k][o] * g[o];
        for (int r = 0; r < 4; ++r) Q[r] += p->U[k][r] * splat(e[k]) - p->C[k][r] * splat(z[k]);
    }
    for (int k = 0; k < p->n; ++k) {
        const open_record by = record_of(&newton->blocks->carried, i, k);
        by.z[l] = z[k];
        by.e[l] = e[k];
        by.p[l] = sum3(p->a[k].S_w * Q[CHI_L] + p->a[k].S_v * Q[CHI_P]);
    }
    if (!j->on_root) hand_column(j, l, Q, kappa, NULL, false);
}

/* The motions of the body by du and by g of each axis. */
typedef struct motions {
    v4 by_u[6][4], by_g[6][4];
} motions;

static void find_motions(const axes *p, const mbsri_newton_block *B, motions *x)
{
    for (int k = 0; k < p->n; ++k) {
        v4 J[4];
        motion_by(p->n, p->a, B, k, x->by_g[k], J);
        memcpy(x->by_u[k], x->by_g[k], sizeof x->by_u[k]);
        x->by_u[k][SPIN] += p->a[k].S_w;
        x->by_u[k][DRIFT] += p->a[k].S_v;
    }
}

/* Row l that waits through the joint. */
static void carry_row_of_axes(const mbsri_carried *v, int i, const axes *p, const motions *x,
                              const joint_front *j, int l)
{
    const double *from = j->from.R + l * MBSRI_SWEPT_MOTIONS;
    v4 R[4], out[4];
    for (int g = 0; g < 4; ++g) R[g] = out[g] = load3(from + 4 * g);
    for (int k = 0; k < p->n; ++k) {
        const open_record by = record_of(v, i, k);
        by.m[l] = read_motion(R, x->by_u[k]);
        by.n[l] = read_motion(R, x->by_g[k]);
        for (int g = 0; g < 4; ++g) out[g] -= splat(by.m[l]) * p->K[k][g];
    }
    hand_row(j, row_place(j, l), out);
}

/* T_h, when all columns and rows are done. */
static void carry_T_of_axes(const mbsri_carried *v, int i, int n, const joint_front *j)
{
    const int count = j->count;
    for (int k = 0; k < count; ++k) {
        const double *from = j->from.T + k * j->from.most;
        double *to = j->to.T + column_place(j, k) * j->to.most;
        for (int l = 0; l < count; l += 4) {
            v4 sum = load3(from + l);
            for (int o = 0; o < n; ++o) {
                const open_record by = record_of(v, i, o);
                sum += load3(by.n + l) * splat(by.e[k]) - load3(by.m + l) * splat(by.z[k]);
            }
            if (j->in_place) {
                store3(to + l, sum);
                continue;
            }
            for (int r = 0; r < 4 && l + r < count; ++r) to[j->to_row[l + r]] += sum[r];
        }
    }
}

/* Joint i on a loop; false: its rows are singular. */
static bool eliminate_open_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                slab *y)
{
    const mbsri_carried *v = &newton->blocks->carried;
    joint_front j = {0};
    axes p;
    motions x;
    if (!open_axes(run, i, newton, &p, y, true) || !start_front(run, i, newton, &j)) return false;
    find_motions(&p, newton->block + run->tree->body[i].multi, &x);
    for (int l = 0; l < j.count; ++l) carry_column_of_axes(run, i, newton, &p, &j, l);
    for (int l = 0; l < j.count; ++l) carry_row_of_axes(v, i, &p, &x, &j, l);
    carry_T_of_axes(v, i, p.n, &j);
    keep_columns(run, i, newton, &p, y, true);
    return true;
}

/* The joint of a body on a loop; false: its rows are singular. */
MBSRI_OUTLINE bool pass_open(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y, bool deep)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    if (b->flags & MBSRI_MULTI) return eliminate_open_axes(run, i, newton, y);
    return b->n > 0 ? eliminate_open(run, i, newton, y, deep)
                    : pass_open_weld(run, i, newton, y, deep);
}

/* ---- solution ---- */

/* As pass_rights, where g moves the joint beside k. */
static void pass_rights_of_axes(mbsri_newton_sweeps *newton, int i, const double g[6])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_front *front = v->front + i;
    const mbsri_newton_step *s = newton->step + i;
    const int count = v->swept[i].count, *place = v->numbers + front->place;
    const double *from = v->store + v->swept[i].right, *k = newton->k + s->u;
    double *to = v->store + v->swept[front->up].right;
    for (int l = 0; l < count; ++l) {
        double sum = from[l];
        for (int o = 0; o < s->n; ++o) {
            const open_record by = record_of(v, i, o);
            sum -= by.n[l] * g[o] + by.m[l] * k[o];
        }
        if (front->in_place)
            to[l] = sum;
        else
            to[place[l]] += sum;
    }
}

/* As move_open. */
static void move_open_axes(const mbsri_newton_sweeps *newton, int i, double du[6], double g[6],
                           double dp[6])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const int *name = v->numbers + v->swept[i].column, count = v->swept[i].count;
    for (int o = 0; o < newton->step[i].n; ++o) {
        const open_record by = record_of(v, i, o);
        for (int l = 0; l < count; ++l) {
            const double value = v->value[name[l]];
            du[o] -= by.z[l] * value;
            g[o] += by.e[l] * value;
            dp[o] += by.p[l] * value;
        }
    }
}

#endif
