/* Joints past which open loops are carried (newton/blocks/carried.h), in the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i, y = P x + Q v + b with the unknowns v that are carried, and rows R x + T v = s wait for
 * elimination; perturbations as in perturbation.h, numbers as in newton/blocks/swept.h. eta moves the joint as
 * r_q would, by e = w S^T kappa each, where kappa is what open loops exert with eta for lambda. So the
 * columns of v pass a joint of one axis beside those of x_h:
 *
 *   du = k - K x_h - z v          z E = (row of the joint along Q) + gain e
 *   Q_h = Q + U e - C z           R_h = R - m K     T_h = T + n e - m z     s_h = s - n r_q - m k
 *
 * where m and n are what the rows read of the body's motion by du and by r_q. Where the joint's block is
 * zero, loops may have to hold it: du is carried on, and with it the balance of forces (reaction.h). */
#ifndef MBSRI_NEWTON_FRONTS_H
#define MBSRI_NEWTON_FRONTS_H

#include "newton/blocks/front.h"
#include "newton/blocks/front_solve.h"
#include "newton/blocks/swept.h"
#include "newton/sweeps/one_axis.h"

/* What the solution needs of an unknown: du -= z v, the joint is moved by e v, d(M u) += p v; and of a
 * row. */
typedef struct open_column {
    double z, e, p;
} open_column;
typedef struct open_row {
    double m, n;
} open_row;

/* A pool's arrays; a joint's record. */
typedef struct open_pool {
    mbsri_pool *pool;
    double *Q, *kappa, *R, *T, *right;
    int *column, *row;
} open_pool;

MBSRI_INLINE open_pool view_pool(const mbsri_carried *v, mbsri_pool *pool)
{
    double *store = v->store;
    return (open_pool){pool,
                       store + pool->Q,
                       store + pool->kappa,
                       store + pool->R,
                       store + pool->T,
                       store + pool->right,
                       v->numbers + pool->column,
                       v->numbers + pool->row};
}

MBSRI_INLINE open_column *columns_of(const mbsri_carried *v, int i)
{
    return (open_column *)(void *)(v->store + v->front[i].record);
}

MBSRI_INLINE open_row *rows_of(const mbsri_carried *v, int i)
{
    return (open_row *)(void *)(columns_of(v, i) + v->pool[i].most + 1);
}

/* Nothing in the fourth number, which counts where fronts are dense matrices. */
MBSRI_INLINE v4 first_three(v4 x)
{
    const i4 mask = {-1, -1, -1, 0};
    return (v4)((i4)x & mask);
}

MBSRI_INLINE void add_to(double *to, v4 x)
{
    *(near4 *)to += first_three(x);
}

/* A joint on the way: its passage, and where what it hands on goes. */
typedef struct joint_front {
    const passage *p;
    const v4 *G;
    v4 rho, by_c;
    double weight;
    bool deep, held; /* held: du is carried on */
    bool on_root;
    open_pool from, to;
    int *to_column, *to_row; /* places of unknowns and rows in `to`, the joint's own the last */
    open_column *column;
    open_row *row;
    double *balance; /* of a held joint: its row over the unknowns */
} joint_front;

/* Whether a name is that of a loop that is open. */
static bool waits(const mbsr_newton *w, int i, int name)
{
    return name < w->carried.multipliers &&
           mbsri_carried_level(w, name) < w->carried.front[i].level;
}

/* Places in the next pool: of multipliers by name, and behind them of what a front before has left,
 * which comes from here alone. Returns how many of the latter there are. */
static int find_places(mbsr_newton *w, int i, joint_front *j)
{
    const int count = j->from.pool->count;
    int held = 0;
    for (int l = 0; l < count; ++l) {
        const int name = j->from.column[l];
        if (waits(w, i, name)) j->to_column[l] = mbsri_carried_join(w, j->to.pool, name);
    }
    int next = j->to.pool->count;
    for (int l = 0; l < count; ++l) {
        const int name = j->from.column[l];
        if (waits(w, i, name)) continue;
        j->to_column[l] = mbsri_carried_join(w, j->to.pool, name);
        ++held;
    }
    if (j->held) {
        j->to_column[count] = mbsri_carried_join(w, j->to.pool, mbsri_name_own(w, i, 0));
        ++held;
    }
    for (int l = 0; l < count; ++l) {
        const int name = j->from.row[l];
        if (waits(w, i, name)) {
            j->to_row[l] = mbsri_carried_find(j->to.column, j->to.pool->count, name);
        } else {
            j->to_row[l] = next;
            j->to.row[next++] = name;
        }
    }
    if (j->held) {
        j->to_row[count] = next;
        j->to.row[next] = mbsri_name_own(w, i, 0);
    }
    return held;
}

/* Unknown l through the joint. */
MBSRI_INLINE void carry_column(const joint_front *j, int l)
{
    const passage *p = j->p;
    const axis *a = &p->a;
    const double *from = j->from.Q + l * MBSRI_SWEPT_ACTIONS,
                 *sum = j->from.kappa + l * MBSRI_SWEPT_FORCES;
    v4 Q[4], kappa[2] = {load3(sum), load3(sum + 4)}, psi[2];
    for (int r = 0; r < 4; ++r) Q[r] = load3(from + 4 * r);
    for (int r = 0; r < 2; ++r) psi[r] = j->deep ? load3(from + 16 + 4 * r) : splat(0.0);
    const double e = j->weight * sum3(a->S_w * kappa[0] + a->S_v * kappa[1]),
                 g = sum3(along_row(a, j->by_c, Q, true)) + p->gain * e,
                 z = j->held ? 0.0 : g / p->E,
                 seen = sum3(a->S_w * psi[PSI_L] + a->S_v * psi[PSI_P]);
    for (int r = 0; r < 4; ++r) Q[r] += p->U[r] * splat(e) - p->C[r] * splat(z);
    for (int r = 0; r < 2 && j->deep; ++r)
        psi[r] +=
            p->t.U[r] * splat(e) - p->t.C[r] * splat(z) - j->G[r] * splat(j->held ? 0.0 : seen);
    j->column[l] =
        (open_column){z, e, sum3(a->S_w * Q[CHI_L] + a->S_v * Q[CHI_P]) - (j->held ? g : 0.0)};
    j->balance[l] = seen + p->t.along_U * e;
    if (j->on_root) return;
    double *to = j->to.Q + j->to_column[l] * MBSRI_SWEPT_ACTIONS,
           *to_kappa = j->to.kappa + j->to_column[l] * MBSRI_SWEPT_FORCES;
    Q[CHI_L] += cross(j->rho, Q[CHI_P]);
    Q[MOMENT] += cross(j->rho, Q[FORCE]);
    for (int r = 0; r < 4; ++r) add_to(to + 4 * r, Q[r]);
    add_to(to_kappa, kappa[0] + cross(j->rho, kappa[1]));
    add_to(to_kappa + 4, kappa[1]);
    if (!j->deep) return;
    add_to(to + 16, psi[PSI_L] + cross(j->rho, psi[PSI_P]));
    add_to(to + 20, psi[PSI_P]);
}

MBSRI_INLINE double read_motion(const v4 R[4], const v4 motion[4])
{
    return sum3(R[0] * motion[0] + R[1] * motion[1] + R[2] * motion[2] + R[3] * motion[3]);
}

MBSRI_INLINE void hand_row(const joint_front *j, int place, v4 R[4])
{
    double *to = j->to.R + place * MBSRI_SWEPT_MOTIONS;
    if (j->on_root) return;
    translate_row(j->rho, R, true);
    for (int g = 0; g < 4; ++g) add_to(to + 4 * g, R[g]);
}

/* Row l that waits through the joint. */
MBSRI_INLINE void carry_row(const joint_front *j, int l)
{
    const passage *p = j->p;
    const double *from = j->from.R + l * MBSRI_SWEPT_MOTIONS;
    const int count = j->from.pool->count, place = j->to_row[l], most = j->to.pool->most;
    v4 R[4];
    for (int g = 0; g < 4; ++g) R[g] = load3(from + 4 * g);
    const double m = read_motion(R, p->motion), n = read_motion(R, p->by_r);
    j->row[l] = (open_row){m, n};
    for (int g = 0; g < 4; ++g) R[g] -= splat(m) * p->K[g];
    hand_row(j, place, R);
    for (int k = 0; k < count; ++k)
        j->to.T[j->to_column[k] * most + place] +=
            j->from.T[k * j->from.pool->most + l] + n * j->column[k].e - m * j->column[k].z;
    if (j->held) j->to.T[j->to_column[count] * most + place] += m;
}

/* The rate of a held joint as an unknown, and the balance of its forces as a row. */
static void carry_rate(const joint_front *j)
{
    const passage *p = j->p;
    const int count = j->from.pool->count, place = j->to_row[count], most = j->to.pool->most;
    const double SC = sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]);
    v4 row[4] = {p->t.row[0], p->t.row[1], p->t.row[2], p->t.row[3]};
    j->column[count] = (open_column){-1.0, 0.0, SC - p->E};
    hand_row(j, place, row);
    for (int k = 0; k < count; ++k) j->to.T[j->to_column[k] * most + place] += j->balance[k];
    j->to.T[j->to_column[count] * most + place] += p->t.along_C;
    if (j->on_root) return;
    double *to = j->to.Q + j->to_column[count] * MBSRI_SWEPT_ACTIONS;
    add_to(to, p->C[CHI_L] + cross(j->rho, p->C[CHI_P]));
    add_to(to + 4, p->C[CHI_P]);
    add_to(to + 8, p->C[MOMENT] + cross(j->rho, p->C[FORCE]));
    add_to(to + 12, p->C[FORCE]);
    add_to(to + 16, p->t.C[PSI_L] + cross(j->rho, p->t.C[PSI_P]));
    add_to(to + 20, p->t.C[PSI_P]);
}

/* All that is carried past joint i; false: more directions than the loops could hold. */
MBSRI_OUTLINE bool carry_past(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                              const passage *p, const v4 G[2], bool deep, bool held)
{
    mbsr_newton *w = newton->blocks;
    mbsri_carried *v = &w->carried;
    const mbsri_front *front = v->front + i;
    const mbsri_sweep_body *b = run->tree->body + i;
    joint_front j = {.p = p, .G = G, .deep = deep, .held = held, .on_root = b->parent == 0};
    j.rho = load(run->state[i].rho);
    j.by_c = splat(newton->by_c);
    j.weight = b->n > 0 ? run->model->weight[b->u] : 0.0;
    j.from = view_pool(v, v->swept + i);
    j.to = view_pool(v, mbsri_carried_up(w, i));
    j.to_column = v->list;
    j.to_row = v->numbers + front->place;
    j.column = columns_of(v, i);
    j.row = rows_of(v, i);
    j.balance = v->work;
    if (find_places(w, i, &j) > front->delayed) return false;
    const int count = j.from.pool->count;
    for (int l = 0; l < count; ++l) carry_column(&j, l);
    for (int l = 0; l < count; ++l) carry_row(&j, l);
    if (held) carry_rate(&j);
    return true;
}

/* ---- elimination ---- */

/* As eliminate, with what is carried past the joint; false: the general elimination has to. */
static bool eliminate_open(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, slab *y,
                           bool deep)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const v4 by_c = splat(newton->by_c);
    const v4 G[2] = {load(s->U_L) * splat(s->Dinv), load(s->U_p) * splat(s->Dinv)};
    const bool held = deep && newton->step[i].deep & MBSRI_NO_INERTIA;
    passage p;
    meet_joint(run, i, newton, y, G, &p, true, deep, true);
    joint_row(y, &p.a, by_c, p.row, true);
    momentum_row(y, p.a.S_w, p.a.S_v, p.Q, true);
    for (int g = 0; g < 4 && held; ++g) {
        p.K[g] = splat(0.0);
        p.Q[g] -= p.row[g];
    }
    if (!held && !by_momentum(&p, true)) return false;
    if (is_pair(newton, i, true)) close_pair(run, i, newton, &p, y, deep);
    if (!carry_past(run, i, newton, &p, G, deep, held)) return false;
    if (!held) subtract_column(y, p.C, p.K, true);
    if (!held && deep) subtract_reaction(y, p.t.C, p.K, true);
    keep_joint(run, i, newton, G, &p, true, deep);
    if (held) mbsri_newton_column_at(newton, b->u)->inverse = 0.0;
    return true;
}

/* Loops that close on body i. */
static int close_loops_on(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton, slab *y)
{
    mbsr_newton *w = newton->blocks;
    double P[MBSRI_SWEPT_MOTIONS * MBSRI_SWEPT_ACTIONS] = {0.0};
    const int status = mbsri_front_close(w, run->data, i, P),
              actions = mbsri_carried_actions(w, w->carried.swept + i);
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            const double *x = P + (4 * g + j) * actions;
            for (int r = 0; r < 4; ++r) y->P[g][j][r] += load3(x + 4 * r);
            for (int r = 0; r < 2 && actions == MBSRI_SWEPT_ACTIONS; ++r)
                y->Y[g][j][r] += load3(x + 16 + 4 * r);
        }
    }
    return status;
}

/* The loops at body i, before its joint; a status. */
MBSRI_OUTLINE int meet_loops(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y)
{
    const int flags = run->tree->body[i].flags;
    const mbsri_newton_own *own = newton->own + i;
    const mbsri_swept_place at = {own->arm, own->omega, own->v};
    mbsri_swept_take_ends(newton->blocks, run->data, i, &at);
    return flags & MBSRI_CLOSES ? close_loops_on(run, i, newton, y) : MBSR_OK;
}

/* The joint of a body on a loop: of one axis, or a weld. */
MBSRI_OUTLINE bool pass_open(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y, bool deep)
{
    if (run->tree->body[i].n > 0) return eliminate_open(run, i, newton, y, deep);
    const v4 none[2] = {splat(0.0), splat(0.0)};
    passage p;
    memset(&p, 0, sizeof p);
    p.E = 1.0;
    if (is_pair(newton, i, true)) pass_weld(run, i, newton, y, deep);
    return carry_past(run, i, newton, &p, none, deep, false);
}

/* ---- solution ---- */

/* Loops that close on body i: what their right-hand sides add to its forces. */
MBSRI_OUTLINE void close_loads(mbsri_newton_sweeps *newton, int i, v4 b[4], v4 psi[2])
{
    double own[MBSRI_SWEPT_ACTIONS] = {0.0};
    mbsri_front_reduce_closing(newton->blocks, i, own);
    for (int r = 0; r < 4; ++r) b[r] += load3(own + 4 * r);
    for (int r = 0; r < 2; ++r) psi[r] += load3(own + 16 + 4 * r);
}

/* The rows that wait pass joint i, which k and r_q move; `rest`: the right-hand side of its balance of
 * forces, where du is carried on. */
MBSRI_OUTLINE void pass_rights(mbsri_newton_sweeps *newton, int i, double k, double r_q,
                               double rest)
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const mbsri_front *front = v->front + i;
    const open_row *row = rows_of(v, i);
    const int *place = v->numbers + front->place, count = v->swept[i].count;
    const double *from = v->store + v->swept[i].right;
    double *to = v->store + mbsri_carried_up(w, i)->right;
    for (int l = 0; l < count; ++l) to[place[l]] += from[l] - row[l].n * r_q - row[l].m * k;
    if (newton->step[i].deep & MBSRI_NO_INERTIA) to[place[count]] += rest;
}

/* What is carried past joint i does to du, to what moves it besides, and to d(M u). */
MBSRI_OUTLINE void move_open(const mbsri_newton_sweeps *newton, int i, double *du, double *rest,
                             double *dp)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const int *name = v->numbers + v->swept[i].column, count = v->swept[i].count;
    const open_column *column = columns_of(v, i);
    for (int l = 0; l < count; ++l) {
        const double value = v->value[name[l]];
        *du -= column[l].z * value;
        *rest += column[l].e * value;
        *dp += column[l].p * value;
    }
    if (!(newton->step[i].deep & MBSRI_NO_INERTIA)) return;
    const double own = v->value[mbsri_name_own(w, i, 0)];
    *du += own;
    *dp += column[count].p * own;
}

/* Loops that close on body i, from its motion. */
MBSRI_OUTLINE void close_motion(mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    double at[16];
    for (int g = 0; g < 4; ++g) *(near4 *)(at + 4 * g) = first_three(x[g]);
    mbsri_front_substitute_closing(newton->blocks, i, at);
}

#endif
