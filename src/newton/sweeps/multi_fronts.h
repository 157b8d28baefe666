/* Joints of several axes past which open loops are carried: as fronts.h, with
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   du = k - K x_h - z v        z = E^-1 (rows of the joint along Q + gain e)
 *   Q_h = Q + U e - C z         R_h = R - m K     T_h = T + n e - m z     s_h = s - n g - m k
 *
 * summed over the axes; eta moves a joint as g would (multi_axis.h), also one with a quaternion.
 * Joints with no inertia behind them are delayed: all du are carried on, and with them the balances
 * of forces (reaction.h),
 *
 *   r_u = S_k^T psi_k - dtau_k,
 *       psi before axis k = psi_h - sum over l before k of w_l S_l x* W */
#ifndef MBSRI_NEWTON_MULTI_FRONTS_H
#define MBSRI_NEWTON_MULTI_FRONTS_H

#include "newton/sweeps/fronts.h"
#include "newton/sweeps/multi_axis.h"

/* ---- the balance of forces of a delayed joint ---- */

/* What du and g of each axis move: the body, psi_h; the balances over du, g and x_h. */
typedef struct balance_of_axes {
    v4 by_u[6][4], by_g[6][4];
    v4 C[6][2], U[6][2], row[6][4];
    double along[6][6], gain[6][6];
} balance_of_axes;

static void find_motions(const axes *p, const mbsri_newton_block *B, balance_of_axes *t)
{
    for (int k = 0; k < p->n; ++k) {
        v4 J[4];
        motion_by(p->n, p->a, B, k, t->by_g[k], J);
        memcpy(t->by_u[k], t->by_g[k], sizeof t->by_u[k]);
        t->by_u[k][SPIN] += p->a[k].S_w;
        t->by_u[k][DRIFT] += p->a[k].S_v;
    }
}

/* C and U of psi, and the balances over du and g. */
static void find_balances(int i, const mbsri_newton_sweeps *newton, const axes *p,
                          mbsri_newton_block *B, const slab *y, balance_of_axes *t)
{
    const int n = p->n;
    const v4 W_L = load(newton->reaction[i].W), W_p = load(newton->reaction[i].W + 4);
    double slope[6][6],
        met[6][6]; /* S_k of what w_l turns of W, where axis l is not before axis k */
    v4 turned[6][2];
    find_slopes(n, newton->by_c, B, slope);
    for (int l = 0; l < n; ++l) {
        turned[l][PSI_L] = cross(p->a[l].S_w, W_L) + cross(p->a[l].S_v, W_p);
        turned[l][PSI_P] = cross(p->a[l].S_w, W_p);
        for (int k = 0; k < n; ++k)
            met[k][l] = B->step[l] < B->step[k]
                            ? 0.0
                            : sum3(p->a[k].S_w * turned[l][PSI_L] + p->a[k].S_v * turned[l][PSI_P]);
    }
    for (int j = 0; j < n; ++j) {
        apply_reaction(y, t->by_u[j], t->C[j], true);
        apply_reaction(y, t->by_g[j], t->U[j], true);
        for (int k = 0; k < n; ++k) {
            const axis *a = p->a + k;
            double by_w = 0.0;
            for (int l = 0; l < n; ++l) by_w += (met[k][l] - slope[k][l]) * B->A[l][j];
            t->along[k][j] =
                sum3(a->S_w * t->C[j][PSI_L] + a->S_v * t->C[j][PSI_P]) + by_w - B->tau_u[k][j];
            t->gain[k][j] = sum3(a->S_w * t->U[j][PSI_L] + a->S_v * t->U[j][PSI_P]) + by_w;
        }
        for (int l = 0; l < n; ++l) {
            for (int r = 0; r < 2; ++r) {
                t->C[j][r] += turned[l][r] * splat(B->A[l][j]);
                t->U[j][r] += turned[l][r] * splat(B->A[l][j]);
            }
        }
    }
}

/* Elements between the body and its predecessor: what they owe to the latter's motion, then what
 * they exert on it; the balances over x_h between these. */
static void pass_pair_of_axes(const mbsri_sweep_run *run, int i, const mbsri_newton_sweeps *newton,
                              int n, balance_of_axes *t, slab *y)
{
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    for (int j = 0; j < n; ++j) {
        v4 by_u[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)}, by_g[4];
        memcpy(by_g, by_u, sizeof by_g);
        apply_slopes(&on, t->by_u[j], by_u);
        apply_slopes(&on, t->by_g[j], by_g);
        for (int r = 0; r < 2; ++r) {
            t->C[j][r] -= by_u[MOMENT + r];
            t->U[j][r] -= by_g[MOMENT + r];
        }
    }
    subtract_slopes(&on, y);
}

/* Of a joint that is delayed. */
static void open_balances(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                          const axes *p, slab *y, balance_of_axes *t)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const bool pair = is_pair(newton, i, true);
    mbsri_newton_block *B = newton->block + b->multi;
    find_balances(i, newton, p, B, y, t);
    if (pair) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        subtract_slopes(&by, y);
    }
    for (int k = 0; k < p->n; ++k) {
        memcpy(B->inverse[k], t->gain[k], sizeof B->inverse[k]);
        for (int g = 0; g < 4; ++g) {
            v4 product[3];
            for (int j = 0; j < 3; ++j)
                product[j] = p->a[k].S_w * y->Y[g][j][PSI_L] + p->a[k].S_v * y->Y[g][j][PSI_P];
            t->row[k][g] = sums(product[0], product[1], product[2]);
        }
    }
    if (pair) pass_pair_of_axes(run, i, newton, p->n, t, y);
}

/* ---- what is carried past a joint ---- */

/* Unknown l through the joint of body i. */
static void carry_column_of_axes(const mbsri_sweep_run *run, int i,
                                 const mbsri_newton_sweeps *newton, const axes *p,
                                 const balance_of_axes *t, const joint_front *j, int l)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_newton_block *B = newton->block + b->multi;
    const double *from = j->from.Q + l * MBSRI_LANE_ACTIONS,
                 *sum = j->from.kappa + l * MBSRI_LANE_FORCES,
                 *weight = run->model->typical.weight + b->u;
    v4 Q[4], kappa[2] = {load3(sum), load3(sum + 4)}, psi[2] = {splat(0.0), splat(0.0)};
    double e[6], g[6], z[6], tau[6];
    for (int r = 0; r < 4; ++r) Q[r] = load3(from + 4 * r);
    for (int r = 0; r < 2 && j->below_massless; ++r) psi[r] = load3(from + 16 + 4 * r);
    for (int k = 0; k < p->n; ++k) {
        const int at = k * j->own.stride + l;
        const double push = j->own.tau ? j->own.push[at] : 0.0;
        tau[k] = j->own.tau ? j->own.tau[at] : 0.0;
        e[k] = weight[k] * (sum3(p->a[k].S_w * kappa[0] + p->a[k].S_v * kappa[1]) + push);
    }
    for (int k = 0; k < p->n; ++k) {
        g[k] = sum3(along_row(p->a + k, j->by_c, Q, true)) - j->by_c[0] * tau[k];
        for (int o = 0; o < p->n; ++o) g[k] += B->gain[k][o] * e[o];
    }
    for (int k = 0; k < p->n && j->delayed; ++k) {
        double *balance = j->balance + k * j->count;
        balance[l] = sum3(p->a[k].S_w * psi[PSI_L] + p->a[k].S_v * psi[PSI_P]) - tau[k];
        for (int o = 0; o < p->n; ++o) balance[l] += t->gain[k][o] * e[o];
    }
    for (int k = 0; k < p->n; ++k) {
        z[k] = 0.0;
        for (int o = 0; o < p->n && !j->delayed; ++o) z[k] += B->inverse[k][o] * g[o];
        for (int r = 0; r < 4; ++r) Q[r] += p->U[k][r] * splat(e[k]) - p->C[k][r] * splat(z[k]);
        for (int r = 0; r < 2 && j->delayed; ++r) psi[r] += t->U[k][r] * splat(e[k]);
    }
    for (int k = 0; k < p->n; ++k) {
        const open_record by = record_of(newton, i, k);
        by.z[l] = z[k];
        by.e[l] = e[k];
        by.p[l] = sum3(p->a[k].S_w * Q[CHI_L] + p->a[k].S_v * Q[CHI_P]) - (j->delayed ? g[k] : 0.0);
    }
    if (!j->on_root) hand_column(j, column_place(j, l), Q, kappa, psi, j->below_massless);
}

/* Row l that waits through the joint. */
static void carry_row_of_axes(const mbsri_newton_sweeps *newton, int i, const axes *p,
                              const balance_of_axes *t, const joint_front *j, int l)
{
    const double *from = j->from.R + l * MBSRI_LANE_MOTIONS;
    v4 R[4], out[4];
    for (int g = 0; g < 4; ++g) R[g] = out[g] = load3(from + 4 * g);
    for (int k = 0; k < p->n; ++k) {
        const open_record by = record_of(newton, i, k);
        by.m[l] = read_motion(R, t->by_u[k]);
        by.n[l] = read_motion(R, t->by_g[k]);
        if (j->own.tau) {
            const int at = k * j->own.stride + l; /* q' = u here */
            const double by_q = j->by_c[0] * j->own.by_q[at];
            by.m[l] += by_q + j->own.by_u[at];
            by.n[l] += by_q;
        }
        for (int g = 0; g < 4; ++g) out[g] -= splat(by.m[l]) * p->K[k][g];
    }
    hand_row(j, row_place(j, l), out);
}

/* T_h, when all columns and rows are done. */
static void carry_T_of_axes(const mbsri_newton_sweeps *newton, int i, int n, const joint_front *j)
{
    const int count = j->count;
    for (int k = 0; k < count; ++k) {
        const double *from = j->from.T + k * j->from.most;
        double *to = j->to.T + column_place(j, k) * j->to.most;
        for (int l = 0; l < count; l += 4) {
            v4 sum = load3(from + l);
            for (int o = 0; o < n; ++o) {
                const open_record by = record_of(newton, i, o);
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

/* The rates of a delayed joint as unknowns, and its balances as rows. */
static void carry_rates(const mbsri_newton_sweeps *newton, int i, const axes *p,
                        const balance_of_axes *t, const joint_front *j)
{
    const int count = j->count, most = j->to.most;
    const v4 none[2] = {splat(0.0), splat(0.0)};
    for (int k = 0; k < j->delayed; ++k) {
        const int at = j->to_column[count + k], place = j->to_row[count + k];
        const open_record by = record_of(newton, i, k);
        double *T = j->to.T;
        v4 row[4];
        memcpy(row, t->row[k], sizeof row);
        hand_row(j, place, row);
        for (int l = 0; l < count; ++l) {
            T[column_place(j, l) * most + place] += j->balance[k * count + l];
            T[at * most + row_place(j, l)] += by.m[l];
        }
        for (int o = 0; o < j->delayed; ++o) {
            T[j->to_column[count + o] * most + place] += t->along[k][o];
            by.p[count + o] =
                sum3(p->a[k].S_w * p->C[o][CHI_L] + p->a[k].S_v * p->C[o][CHI_P]) - p->E[k][o];
        }
        if (!j->on_root) hand_column(j, at, p->C[k], none, t->C[k], true);
    }
}

static void keep_held(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, axes *p,
                      const balance_of_axes *t, const slab *y)
{
    const int u = run->tree->body[i].u;
    v4 Q[6][4];
    for (int k = 0; k < p->n; ++k) {
        mbsri_newton_below_massless *below = newton->below + u + k;
        store3(below->C, t->C[k][0]), store3(below->C + 3, t->C[k][1]);
        store3(below->U, t->U[k][0]), store3(below->U + 3, t->U[k][1]);
        momentum_row(y, p->a[k].S_w, p->a[k].S_v, Q[k], true);
        for (int g = 0; g < 4; ++g) Q[k][g] -= p->R[k][g];
    }
    keep_axes(run, i, newton, p, Q, true);
}

/* Joint i on a loop; false: its rows are singular, or see open_next. */
static bool eliminate_open_axes(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                slab *y, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    joint_front j = {.below_massless = below_massless, .delayed = delayed_at(newton, i)};
    axes p;
    balance_of_axes t;
    j.balance = newton->blocks->carried.work;
    if (!open_axes(run, i, newton, &p, y, true)) return false;
    find_motions(&p, newton->block + b->multi, &t);
    if (below_massless) open_balances(run, i, newton, &p, y, &t);
    if (!close_axes(run, i, newton, &p, y, true, below_massless)) return false;
    if (!start_front(run, i, newton, &j)) return false;
    for (int l = 0; l < j.count; ++l) carry_column_of_axes(run, i, newton, &p, &t, &j, l);
    for (int l = 0; l < j.count; ++l) carry_row_of_axes(newton, i, &p, &t, &j, l);
    carry_T_of_axes(newton, i, p.n, &j);
    carry_rates(newton, i, &p, &t, &j);
    if (below_massless)
        keep_held(run, i, newton, &p, &t, y);
    else
        keep_columns(run, i, newton, &p, y, true);
    return true;
}

/* The joint of a body on a loop; false: its rows are singular. */
MBSRI_OUTLINE bool pass_open(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    if (b->flags & MBSRI_MULTI) return eliminate_open_axes(run, i, newton, y, below_massless);
    return b->n > 0 ? eliminate_open(run, i, newton, y, below_massless)
                    : pass_open_weld(run, i, newton, y, below_massless);
}

/* ---- solution ---- */

/* As pass_rights, where g moves the joint beside k; rest: of the balances of a joint that is
 * delayed.
 */
static void pass_rights_of_axes(mbsri_newton_sweeps *newton, int i, const double g[6],
                                const double rest[6])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const mbsri_newton_step *s = newton->step + i;
    const int count = pool->count, delayed = delayed_at(newton, i),
              *place = v->numbers + pool->place;
    const double *from = v->store + pool->right, *k = newton->k + s->u;
    double *to = v->store + v->lane_pool[pool->up].right;
    for (int l = 0; l < count; ++l) {
        double sum = from[l];
        for (int o = 0; o < s->n; ++o) {
            const open_record by = record_of(newton, i, o);
            sum -= by.n[l] * g[o] + by.m[l] * k[o];
        }
        if (pool->in_place)
            to[l] = sum;
        else
            to[place[l]] += sum;
    }
    for (int o = 0; o < delayed; ++o) to[pool->in_place ? count + o : place[count + o]] += rest[o];
}

/* Of a joint that is delayed, at the loads behind it: d(M u), less the row of F_p, without w, which
 * `known` holds; and of the balances r_u + dtau, less what they see. psi passes the joint. */
static void balance_axes(mbsri_newton_sweeps *newton, int i, const double g[6], double r_s,
                         mbsri_newton_flow *m, double rest[6])
{
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_block *B = newton->block + s->multi;
    for (int k = 0; k < s->n; ++k) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u + k);
        rest[k] += newton->c * B->length[k] * r_s -
                   sum3(load3(col->S) * load(m->psi) + load3(col->S + 3) * load(m->psi + 4));
        for (int l = 0; l < s->n; ++l) rest[k] -= B->inverse[k][l] * g[l];
    }
    for (int k = 0; k < s->n; ++k) {
        const mbsri_newton_below_massless *below = newton->below + s->u + k;
        store(m->psi, load(m->psi) + load3(below->U) * splat(g[k]));
        store(m->psi + 4, load(m->psi + 4) + load3(below->U + 3) * splat(g[k]));
    }
}

/* As move_open. */
static void move_open_axes(const mbsri_newton_sweeps *newton, int i, double du[6], double g[6],
                           double dp[6])
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const int *name = v->numbers + pool->column, count = pool->count,
              delayed = delayed_at(newton, i);
    for (int o = 0; o < newton->step[i].n; ++o) {
        const open_record by = record_of(newton, i, o);
        for (int l = 0; l < count; ++l) {
            const double value = v->value[name[l]];
            du[o] -= by.z[l] * value;
            g[o] += by.e[l] * value;
            dp[o] += by.p[l] * value;
        }
        for (int l = 0; l < delayed; ++l)
            dp[o] += by.p[count + l] * v->value[mbsri_name_own(newton->blocks, i, l)];
        if (delayed > 0) du[o] += v->value[mbsri_name_own(newton->blocks, i, o)];
    }
}

#endif
