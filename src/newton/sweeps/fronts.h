/* Joints past which open loops are carried (newton/carried/carried.h), in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i, y = P x + Q v + b with the unknowns v that are carried, and rows R x + T v = s wait
 * for elimination; perturbations as in perturbation.h, numbers as in newton/carried/lane_pools.h.
 * eta moves the joint as r_q would, by e = w S^T kappa each, where kappa is what open loops exert
 * with eta for lambda. So the columns of v pass a joint of one axis beside those of x_h:
 *
 *   du = k - K x_h - z v          z E = (row of the joint along Q) + gain e
 *   Q_h = Q + U e - C z           R_h = R - m K     T_h = T + n e - m z     s_h = s - n r_q - m k
 *
 * where m and n are what the rows read of the body's motion by du and by r_q. Couplings of joint
 * coordinates act on the joint itself: they have part in the row of the joint, in e, m and n, and
 * in no Q or R before it. Where the joint's block is zero, loops may have to hold it: du is carried
 * on, and with it the balance of forces (reaction.h).
 *
 * Along a strand (newton/carried/lane_pools.h) all stays in its place; where strands meet, one is
 * added to the other by the names of its unknowns. */
#ifndef MBSRI_NEWTON_FRONTS_H
#define MBSRI_NEWTON_FRONTS_H

#include "newton/carried/front_solve.h"
#include "newton/sweeps/one_axis.h"
#include "newton/sweeps/pools.h"
#include "recursion/closures.h"

/* What couplings of joint coordinates are at a joint, `stride` numbers an axis: of each unknown the
 * joint force and what eta moves, of each row what it reads of du and dq. NULL: nothing. */
typedef struct joint_couplings {
    double *tau, *push, *by_u, *by_q;
    int stride;
} joint_couplings;

/* A joint on the way: its passage, and where what it hands on goes. */
typedef struct joint_front {
    const passage *p;
    v4 rho, by_c;
    double weight;
    bool below_massless;
    int delayed; /* see delayed_at */
    bool on_root, in_place;
    int count; /* unknowns from behind */
    open_pool from, to;
    int *to_column, *to_row; /* places of unknowns and rows in `to`, the joint's own the last */
    open_record record;
    double *balance; /* of a delayed joint: its row over the unknowns */
    joint_couplings own;
} joint_front;

/* In the place of what is there, or added to it. */
MBSRI_INLINE void put(double *to, v4 x, bool in_place)
{
    const v4 old = in_place ? splat(0.0) : load3(to);
    store3(to, first_three(x) + old);
}

/* Whether a name is that of a loop that is open. */
MBSRI_INLINE bool waits(const mbsr_newton *w, int i, int name)
{
    return name < w->carried.multipliers &&
           mbsri_carried_level(w, name) < w->carried.front[i].level;
}

/* Places in the next pool: of multipliers by name, and behind them of what a front before has left,
 * which comes from here alone. */
MBSRI_OUTLINE void find_places(mbsr_newton *w, int i, joint_front *j)
{
    for (int l = 0; l < j->count; ++l) {
        const int name = j->from.column[l];
        if (waits(w, i, name)) j->to_column[l] = place_of_name(&j->to, name);
    }
    int next = j->to.pool->count;
    for (int l = 0; l < j->count; ++l) {
        const int name = j->from.column[l];
        if (!waits(w, i, name)) j->to_column[l] = append(&j->to, name, name);
    }
    for (int l = 0; l < j->count; ++l) {
        const int name = j->from.row[l];
        if (waits(w, i, name)) {
            j->to_row[l] = mbsri_carried_find(j->to.column, j->to.pool->count, name);
        } else {
            j->to_row[l] = next;
            j->to.row[next++] = name;
        }
    }
}

/* The pool above; false: more directions are carried on than the loops could hold. */
MBSRI_INLINE bool open_next(mbsri_newton_sweeps *newton, int i, joint_front *j)
{
    mbsr_newton *w = newton->blocks;
    const int count = j->count;
    if (j->delayed || j->from.pool->loose) {
        int delayed = j->delayed;
        for (int l = 0; l < count; ++l) delayed += !waits(w, i, j->from.column[l]);
        if (delayed > w->carried.front[i].delayed) return false;
    }
    if (j->in_place)
        j->to.pool->count = count;
    else
        find_places(w, i, j);
    for (int o = 0; o < j->delayed; ++o) {
        const int own = mbsri_name_own(w, i, o);
        j->to_column[count + o] = j->to_row[count + o] = append(&j->to, own, own);
        for (int k = 0; k < j->delayed; ++k) { /* carry_T takes four rows at a time */
            const open_record by = record_of(newton, i, k);
            by.m[count + o] = by.n[count + o] = 0.0;
        }
    }
    return true;
}

/* A row of a coupling at an o of the joint. */
MBSRI_INLINE void add_coupling_row(const mbsr_newton *w, const mbsr_data *data, int number, int k,
                                   int column, int o, joint_front *j)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *c = (const mbsri_closure *)w->model->closures.data + number;
    const joint_couplings *own = &j->own;
    const int at = column * c->rows + k, first = o * own->stride;
    const double C = data->closure_C[c->at + (size_t)at];
    const int lambda = first + place_of_name(&j->from, mbsri_name_lambda(c, k));
    own->tau[lambda] += C;
    own->by_u[lambda] += C;
    own->by_q[lambda] += v->store[v->loop[number].slope + (size_t)at];
    if (k >= c->position_rows || data->dropped[c->row + k]) return;
    const int name = mbsri_name_eta(w->model, c, k), next = lambda - first + 1;
    const bool follows = next < j->from.pool->count && j->from.column[next] == name; /* mostly */
    const int eta = first + (follows ? next : place_of_name(&j->from, name));
    own->push[eta] += C;
    own->by_q[eta] += C;
}

/* What of it crosses to other joints. */
MBSRI_INLINE void add_coupling_across(const mbsr_newton *w, int number, int k, int column, int o,
                                      joint_front *j)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *c = (const mbsri_closure *)w->model->closures.data + number;
    const mbsri_loop *loop = v->loop + number;
    const int at = o * j->own.stride + place_of_name(&j->from, loop->across + k);
    j->own.tau[at] += v->store[loop->left + (size_t)(k * c->columns + column)];
    j->own.by_q[at] -= v->store[loop->read + (size_t)(column * loop->most + k)];
}

/* Couplings at joint i, of n axes. */
MBSRI_OUTLINE void take_couplings(const mbsr_newton *w, const mbsr_data *data, int i, int n,
                                  joint_front *j)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *all = w->model->closures.data;
    const int most = j->from.most, size = n * most;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const int number = v->end[k].closure;
        const mbsri_closure *c = all + number;
        if (!mbsri_is_coupling(c)) continue;
        if (!j->own.tau) {
            double *at = v->work + size; /* behind the balances */
            memset(at, 0, 4 * (size_t)size * sizeof *at);
            j->own = (joint_couplings){at, at + size, at + 2 * size, at + 3 * size, most};
        }
        const int column = c->column[v->end[k].slot] + w->model->body[i].d;
        for (int o = 0; o < n; ++o) {
            for (int r = 0; r < c->rows; ++r) {
                if (data->dropped[c->row + r] && !mbsri_is_stiff(c, r)) continue;
                add_coupling_row(w, data, number, r, column + o, o, j);
            }
            for (int r = 0; r < v->loop[number].rank; ++r)
                add_coupling_across(w, number, r, column + o, o, j);
        }
    }
}

MBSRI_INLINE int column_place(const joint_front *j, int l)
{
    return j->in_place ? l : j->to_column[l];
}

MBSRI_INLINE int row_place(const joint_front *j, int l)
{
    return j->in_place ? l : j->to_row[l];
}

/* What is behind joint i, and the pool above; false: see open_next. */
MBSRI_INLINE bool start_front(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                              joint_front *j)
{
    const mbsri_carried *v = &newton->blocks->carried;
    mbsri_pool *pool = v->lane_pool + i;
    j->on_root = run->tree->body[i].parent == 0;
    j->rho = load(run->state[i].rho);
    j->by_c = splat(newton->by_c);
    j->in_place = pool->in_place;
    j->from = view_pool(v, pool);
    j->to = view_pool(v, v->lane_pool + pool->up);
    if (v->first_end[i] >= 0) take_couplings(newton->blocks, run->data, i, run->tree->body[i].n, j);
    j->count = pool->count;
    j->to_column = v->list;
    j->to_row = pool->in_place ? v->list + v->most : v->numbers + pool->place;
    return open_next(newton, i, j);
}

MBSRI_INLINE void put_column(const joint_front *j, int place, const v4 Q[4], const v4 kappa[2],
                             const v4 psi[2], bool below_massless, bool in_place)
{
    double *to = j->to.Q + place * MBSRI_LANE_ACTIONS,
           *to_kappa = j->to.kappa + place * MBSRI_LANE_FORCES;
    put(to + 4 * CHI_L, Q[CHI_L] + cross(j->rho, Q[CHI_P]), in_place);
    put(to + 4 * CHI_P, Q[CHI_P], in_place);
    put(to + 4 * MOMENT, Q[MOMENT] + cross(j->rho, Q[FORCE]), in_place);
    put(to + 4 * FORCE, Q[FORCE], in_place);
    put(to_kappa, kappa[0] + cross(j->rho, kappa[1]), in_place);
    put(to_kappa + 4, kappa[1], in_place);
    if (!below_massless) return;
    put(to + 16, psi[PSI_L] + cross(j->rho, psi[PSI_P]), in_place);
    put(to + 20, psi[PSI_P], in_place);
}

/* An unknown to the predecessor. */
MBSRI_INLINE void hand_column(const joint_front *j, int place, const v4 Q[4], const v4 kappa[2],
                              const v4 psi[2], bool below_massless)
{
    if (j->in_place)
        put_column(j, place, Q, kappa, psi, below_massless, true);
    else
        put_column(j, place, Q, kappa, psi, below_massless, false);
}

/* Unknown l through the joint. */
MBSRI_INLINE void carry_column(const joint_front *j, int l, bool below_massless, bool coupled)
{
    const passage *p = j->p;
    const double tau = coupled ? j->own.tau[l] : 0.0, push = coupled ? j->own.push[l] : 0.0;
    const axis *a = &p->a;
    const double *from = j->from.Q + l * MBSRI_LANE_ACTIONS,
                 *sum = j->from.kappa + l * MBSRI_LANE_FORCES;
    v4 Q[4], kappa[2] = {load3(sum), load3(sum + 4)}, psi[2];
    for (int r = 0; r < 4; ++r) Q[r] = load3(from + 4 * r);
    for (int r = 0; r < 2; ++r) psi[r] = below_massless ? load3(from + 16 + 4 * r) : splat(0.0);
    const double e = j->weight * (sum3(a->S_w * kappa[0] + a->S_v * kappa[1]) + push),
                 g = sum3(along_row(a, j->by_c, Q, true)) + p->gain * e - j->by_c[0] * tau,
                 z = j->delayed ? 0.0 : g / p->E,
                 seen =
                     below_massless ? sum3(a->S_w * psi[PSI_L] + a->S_v * psi[PSI_P]) - tau : 0.0;
    const v4 by_e = splat(e), by_z = splat(z);
    for (int r = 0; r < 4; ++r) Q[r] += p->U[r] * by_e - p->C[r] * by_z;
    for (int r = 0; r < 2 && below_massless; ++r) psi[r] += p->t.U[r] * by_e;
    j->record.z[l] = z;
    j->record.e[l] = e;
    j->record.p[l] = sum3(a->S_w * Q[CHI_L] + a->S_v * Q[CHI_P]) - (j->delayed ? g : 0.0);
    if (below_massless) j->balance[l] = seen + p->t.along_U * e;
    if (!j->on_root) hand_column(j, column_place(j, l), Q, kappa, psi, below_massless);
}

MBSRI_INLINE double read_motion(const v4 R[4], const v4 motion[4])
{
    return sum3(R[0] * motion[0] + R[1] * motion[1] + R[2] * motion[2] + R[3] * motion[3]);
}

MBSRI_INLINE void hand_row(const joint_front *j, int place, v4 R[4])
{
    double *to = j->to.R + place * MBSRI_LANE_MOTIONS;
    if (j->on_root) return;
    translate_row(j->rho, R, true);
    if (j->in_place)
        for (int g = 0; g < 4; ++g) put(to + 4 * g, R[g], true);
    else
        for (int g = 0; g < 4; ++g) put(to + 4 * g, R[g], false);
}

/* Row l that waits through the joint. */
MBSRI_INLINE void carry_row(const joint_front *j, int l, bool coupled)
{
    const passage *p = j->p;
    const double *from = j->from.R + l * MBSRI_LANE_MOTIONS;
    v4 R[4];
    for (int g = 0; g < 4; ++g) R[g] = load3(from + 4 * g);
    const double by_q = coupled ? j->by_c[0] * j->own.by_q[l] : 0.0,
                 m = read_motion(R, p->motion) + by_q + (coupled ? j->own.by_u[l] : 0.0),
                 n = read_motion(R, p->by_r) + by_q;
    j->record.m[l] = m;
    j->record.n[l] = n;
    for (int g = 0; g < 4; ++g) R[g] -= splat(m) * p->K[g];
    hand_row(j, row_place(j, l), R);
}

/* T_h, when all columns and rows are done. */
MBSRI_INLINE void carry_T(const joint_front *j)
{
    const open_record *by = &j->record;
    const int count = j->count, from_most = j->from.most, to_most = j->to.most;
    for (int k = 0; k < count; ++k) {
        const v4 e = splat(by->e[k]), z = splat(by->z[k]);
        double *from = j->from.T + k * from_most, *to = j->to.T + column_place(j, k) * to_most;
        for (int l = 0; l < count; l += 4) {
            const v4 sum = load3(from + l) + load3(by->n + l) * e - load3(by->m + l) * z;
            if (j->in_place) {
                store3(to + l, sum);
                continue;
            }
            for (int r = 0; r < 4 && l + r < count; ++r) to[j->to_row[l + r]] += sum[r];
        }
    }
}

/* The rate of a delayed joint as an unknown, and the balance of its forces as a row. */
MBSRI_OUTLINE void carry_rate(const joint_front *j)
{
    const passage *p = j->p;
    const int count = j->count, at = j->to_column[count], place = j->to_row[count];
    double *T = j->to.T;
    const double SC = sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]);
    const v4 none[2] = {splat(0.0), splat(0.0)};
    v4 row[4] = {p->t.row[0], p->t.row[1], p->t.row[2], p->t.row[3]};
    j->record.z[count] = -1.0;
    j->record.e[count] = 0.0;
    j->record.p[count] = SC - p->E;
    hand_row(j, place, row);
    for (int k = 0; k < count; ++k) {
        T[column_place(j, k) * j->to.most + place] += j->balance[k];
        T[at * j->to.most + row_place(j, k)] += j->record.m[k];
    }
    T[at * j->to.most + place] += p->t.along_C;
    if (!j->on_root) hand_column(j, at, p->C, none, p->t.C, true);
}

/* Unknowns and rows past a joint without couplings, and with some. */
MBSRI_INLINE void carry_uncoupled(const joint_front *j, bool below_massless)
{
    for (int l = 0; l < j->count && below_massless; ++l) carry_column(j, l, true, false);
    for (int l = 0; l < j->count && !below_massless; ++l) carry_column(j, l, false, false);
    for (int l = 0; l < j->count; ++l) carry_row(j, l, false);
}

MBSRI_OUTLINE void carry_coupled(const joint_front *j, bool below_massless)
{
    for (int l = 0; l < j->count && below_massless; ++l) carry_column(j, l, true, true);
    for (int l = 0; l < j->count && !below_massless; ++l) carry_column(j, l, false, true);
    for (int l = 0; l < j->count; ++l) carry_row(j, l, true);
}

/* All that is carried past joint i; false: more directions than the loops could hold. */
MBSRI_OUTLINE bool carry_past(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                              const passage *p, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    joint_front j = {.p = p, .below_massless = below_massless, .delayed = delayed_at(newton, i)};
    j.weight = b->n > 0 ? run->model->typical.weight[b->u] : 0.0;
    j.balance = newton->blocks->carried.work;
    if (!start_front(run, i, newton, &j)) return false;
    j.record = record_of(newton, i, 0);
    if (j.own.tau)
        carry_coupled(&j, below_massless);
    else
        carry_uncoupled(&j, below_massless);
    carry_T(&j);
    if (j.delayed) carry_rate(&j);
    return true;
}

/* ---- elimination ---- */

/* As eliminate, with what is carried past the joint, which is delayed below a massless one; false:
 * the general elimination has to. */
MBSRI_INLINE bool eliminate_open(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 slab *y, bool below_massless)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 by_c = splat(newton->by_c);
    const v4 G[2] = {load(s->U_L) * splat(s->Dinv), load(s->U_p) * splat(s->Dinv)};
    passage p;
    meet_joint(run, i, newton, y, G, &p, true, below_massless, true);
    joint_row(y, &p.a, by_c, p.row, true);
    momentum_row(y, p.a.S_w, p.a.S_v, p.Q, true);
    for (int g = 0; g < 4 && below_massless; ++g) {
        p.K[g] = splat(0.0);
        p.Q[g] -= p.row[g];
    }
    if (!below_massless && !by_momentum(&p, true)) return false;
    if (is_pair(newton, i, true)) close_pair(run, i, newton, &p, y, below_massless);
    if (!carry_past(run, i, newton, &p, below_massless)) return false;
    if (!below_massless) subtract_column(y, p.C, p.K, true);
    keep_joint(run, i, newton, G, &p, true, below_massless);
    if (below_massless) mbsri_newton_column_at(newton, b->u)->inverse = 0.0;
    return true;
}

/* A weld on a loop. */
MBSRI_OUTLINE bool pass_open_weld(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                  slab *y, bool below_massless)
{
    passage p;
    memset(&p, 0, sizeof p);
    p.E = 1.0;
    if (is_pair(newton, i, true)) pass_weld(run, i, newton, y, below_massless);
    return carry_past(run, i, newton, &p, below_massless);
}

/* ---- solution ---- */

/* The rows that wait pass joint i, which k and r_q move; `rest`: the right-hand side of its balance
 * of forces, where du is carried on. */
MBSRI_OUTLINE void pass_rights(mbsri_newton_sweeps *newton, int i, double k, double r_q,
                               double rest)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const open_record by = record_of(newton, i, 0);
    const int count = pool->count, *place = v->numbers + pool->place;
    double *from = v->store + pool->right, *to = v->store + v->lane_pool[pool->up].right;
    for (int l = 0; l < count; ++l) {
        const double s = from[l] - by.n[l] * r_q - by.m[l] * k;
        if (pool->in_place)
            to[l] = s;
        else
            to[place[l]] += s;
    }
    if (delayed_at(newton, i)) to[pool->in_place ? count : place[count]] += rest;
}

/* What is carried past joint i does to du, to what moves it besides, and to d(M u). */
MBSRI_OUTLINE void move_open(const mbsri_newton_sweeps *newton, int i, double *du, double *rest,
                             double *dp)
{
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_pool *pool = v->lane_pool + i;
    const int *name = v->numbers + pool->column, count = pool->count;
    const open_record by = record_of(newton, i, 0);
    for (int l = 0; l < count; ++l) {
        const double value = v->value[name[l]];
        *du -= by.z[l] * value;
        *rest += by.e[l] * value;
        *dp += by.p[l] * value;
    }
    if (!delayed_at(newton, i)) return;
    const double own = v->value[mbsri_name_own(newton->blocks, i, 0)];
    *du += own;
    *dp += by.p[count] * own;
}

#endif
