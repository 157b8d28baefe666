/* The solution: leaves to root b, root to leaves du.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_SOLVE_H
#define MBSRI_NEWTON_SOLVE_H

#include "newton/front/front.h"
#include "newton/sweeps/border.h"
#include "newton/sweeps/closing.h"
#include "newton/sweeps/multi_axis_solve.h"

/* b, that of psi, and the recursion for w. */
typedef struct loads {
    v4 b[4], psi[2], L_bar, p_bar;
} loads;

MBSRI_INLINE void clear_loads(loads *f)
{
    f->b[0] = f->b[1] = f->b[2] = f->b[3] = f->L_bar = f->p_bar = splat(0.0);
    f->psi[0] = f->psi[1] = splat(0.0);
}

MBSRI_INLINE void add_loads(const mbsri_newton_flow *m, loads *f, bool full, bool below_massless)
{
    for (int r = 0; r < groups(full); ++r) f->b[r] += load(m->b + 4 * r);
    for (int r = 0; r < 2 && below_massless; ++r) f->psi[r] += load(m->psi + 4 * r);
    f->L_bar += load(m->L_bar), f->p_bar += load(m->p_bar);
}

MBSRI_INLINE void loads_to_memory(const loads *f, mbsri_newton_flow *m, bool full,
                                  bool below_massless)
{
    for (int r = 0; r < groups(full); ++r) store(m->b + 4 * r, f->b[r]);
    for (int r = 0; r < 2 && below_massless; ++r) store(m->psi + 4 * r, f->psi[r]);
    store(m->L_bar, f->L_bar), store(m->p_bar, f->p_bar);
}

/* Of one coordinate: r, and the change of its joint force. */
typedef struct given {
    double q, p, u, tau;
} given;

/* What b adds to the row of the joint in F_p. */
MBSRI_INLINE double row_of_loads(const mbsri_newton_column *col, v4 by_c, const loads *f, bool full)
{
    v4 row = load3(col->row) * f->b[CHI_L] + load3(col->row + 3) * f->b[CHI_P] -
             by_c * load3(col->S) * f->b[MOMENT];
    if (full) row -= by_c * load3(col->S + 3) * f->b[FORCE];
    return sum3(row);
}

/* b behind the joint. */
MBSRI_INLINE void pass_loads(mbsri_newton_column *col, double k, double r_q, loads *f, bool full)
{
    for (int r = 0; r < groups(full); ++r)
        f->b[r] += load3(group_of(col->C, col->C_last, r)) * splat(k) +
                   load3(group_of(col->U, col->U_last, r)) * splat(r_q);
}

/* k and p of a joint of one axis, by the row of F_p. */
MBSRI_INLINE double condense_loads(const mbsri_newton_sweeps *newton, int u, given r, loads *f,
                                   bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3), by_c = splat(newton->by_c);
    const double w = r.u + sum3(S_w * f->L_bar + S_v * f->p_bar);
    const double row = row_of_loads(col, by_c, f, full);
    const double k = (newton->by_c * (r.p + r.tau) + w - row - col->gain * r.q) * col->inverse;
    pass_loads(col, k, r.q, f, full);
    newton->k[u] = k;
    newton->p[u] = sum3(S_w * f->b[CHI_L] + S_v * f->b[CHI_P]) - w;
    f->L_bar += load3(col->G) * splat(r.u);
    f->p_bar += load3(col->G + 3) * splat(r.u);
    return k;
}

/* The same by the balance of forces (reaction.h). */
MBSRI_INLINE double balance_loads(const mbsri_newton_sweeps *newton, int u, given r, loads *f,
                                  bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const mbsri_newton_below_massless *below = newton->below + u;
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
    const double row = row_of_loads(col, splat(newton->by_c), f, full);
    const double psi = sum3(S_w * f->psi[PSI_L] + S_v * f->psi[PSI_P]);
    const double k = (r.u + r.tau - psi - col->gain * r.q) * col->inverse;
    pass_loads(col, k, r.q, f, full);
    newton->k[u] = k;
    newton->p[u] = newton->by_c * (r.p + r.tau) + sum3(S_w * f->b[CHI_L] + S_v * f->b[CHI_P]) -
                   row - below->pivot * k - below->gain * r.q;
    return k;
}

/* A joint of one axis in a solution with bodies below massless joints. */
MBSRI_INLINE void condense_below_massless(const mbsri_newton_sweeps *newton,
                                          const mbsri_newton_step *s, given r, loads *f, bool full)
{
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    if (!(s->below_massless & MBSRI_BELOW_MASSLESS)) {
        condense_loads(newton, s->u, r, f, full);
        return;
    }
    const mbsri_newton_below_massless *below = newton->below + s->u;
    const bool balance_of_forces = (s->below_massless & MBSRI_NO_INERTIA) != 0;
    const double seen =
        sum3(load3(col->S) * f->psi[PSI_L] + load3(col->S + 3) * f->psi[PSI_P]) - r.tau;
    const v4 taken = splat(balance_of_forces ? 0.0 : seen),
             k = splat(balance_of_forces ? balance_loads(newton, s->u, r, f, full)
                                         : condense_loads(newton, s->u, r, f, full));
    for (int g = 0; g < 2; ++g)
        f->psi[g] += load3(below->C + 3 * g) * k + load3(below->U + 3 * g) * splat(r.q) -
                     load3(col->G + 3 * g) * taken;
}

/* A joint past which loops are carried, or a weld. */
MBSRI_OUTLINE void condense_open(mbsri_newton_sweeps *newton, int i, given r, loads *f,
                                 bool below_massless)
{
    const mbsri_newton_step *s = newton->step + i;
    if (s->n == 0) {
        pass_rights(newton, i, 0.0, 0.0, 0.0);
        return;
    }
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    const v4 psi = load3(col->S) * f->psi[PSI_L] + load3(col->S + 3) * f->psi[PSI_P];
    const double rest = r.u + r.tau - sum3(psi) - col->gain * r.q;
    if (below_massless)
        condense_below_massless(newton, s, r, f, true);
    else
        condense_loads(newton, s->u, r, f, true);
    pass_rights(newton, i, newton->k[s->u], r.q, rest);
}

/* wrench: at the origin of body i's own frame. */
MBSRI_INLINE void add_wrench(const mbsri_newton_sweeps *newton, int i, const double *wrench,
                             loads *f, bool below_massless)
{
    double x[6];
    mbsri_lift(newton->model->body[i].d, wrench, x);
    const v4 force = {x[3], x[4], x[5], 0.0},
             moment = (v4){x[0], x[1], x[2], 0.0} + cross(load(newton->acting.own[i].arm), force);
    f->b[MOMENT] += moment;
    f->b[FORCE] += force;
    if (!below_massless || !(newton->step[i].below_massless & MBSRI_BELOW_MASSLESS)) return;
    f->psi[PSI_L] -= moment;
    f->psi[PSI_P] -= force;
}

MBSRI_INLINE void add_load(const mbsri_newton_sweeps *newton, int i, const double *load_of_body,
                           loads *f, bool below_massless)
{
    add_wrench(newton, i, load_of_body + newton->model->body[i].v, f, below_massless);
}

/* To the predecessor, whose loads these are. */
MBSRI_INLINE void queue_loads(int flags, loads *f, mbsri_newton_flow **top, bool full,
                              bool below_massless)
{
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) add_loads(--*top, f, full, below_massless);
    loads_to_memory(f, (*top)++, full, below_massless);
}

/* From body i to its predecessor. */
MBSRI_INLINE void hand_loads_over(const mbsri_newton_step *s, loads *f, mbsri_newton_flow **top,
                                  bool full, bool below_massless)
{
    const v4 rho = load(s->rho);
    f->b[CHI_L] += cross(rho, f->b[CHI_P]);
    if (full) f->b[MOMENT] += cross(rho, f->b[FORCE]);
    f->L_bar += cross(rho, f->p_bar);
    if (below_massless) f->psi[PSI_L] += cross(rho, f->psi[PSI_P]);
    queue_loads(s->flags, f, top, full, below_massless);
}

/* Past block i. */
MBSRI_OUTLINE void block_loads(mbsri_newton_sweeps *newton, int i, const double *r,
                               const double *load_of_body, loads *f, mbsri_newton_flow **top,
                               bool below_massless)
{
    const mbsri_newton_step *s = newton->step + i;
    _Alignas(32) mbsri_newton_flow flow;
    mbsri_border_reduce(newton, i, r, load_of_body, &flow);
    if (s->parent == 0 || s->flags & MBSRI_TO_BLOCK) return;
    const v4 arm = load(newton->acting.own[s->parent].arm);
    clear_loads(f);
    add_loads(&flow, f, true, below_massless);
    f->b[CHI_L] += cross(arm, f->b[CHI_P]);
    f->b[MOMENT] += cross(arm, f->b[FORCE]);
    f->L_bar += cross(arm, f->p_bar);
    f->psi[PSI_L] += cross(arm, f->psi[PSI_P]);
    queue_loads(s->flags, f, top, true, below_massless);
}

MBSRI_OUTLINE void give_loads(mbsri_newton_sweeps *newton, int i, const loads *f,
                              bool below_massless)
{
    _Alignas(32) mbsri_newton_flow flow;
    loads_to_memory(f, &flow, true, below_massless);
    mbsri_border_give_flow(newton, i, &flow);
}

/* r, by its parts, and what acts besides; or NULL. */
typedef struct right_sides {
    const mbsr_model *model;
    const double *r, *p, *u, *load_of_body;
} right_sides;

MBSRI_INLINE right_sides parts_of(const mbsr_model *m, const double *r, const double *load_of_body)
{
    return r ? (right_sides){m, r, r + m->nq, r + m->nq + m->nu, load_of_body}
             : (right_sides){m, NULL, NULL, NULL, load_of_body};
}

/* The joint of body i, of whatever kind. */
MBSRI_INLINE void condense_joint(mbsri_newton_sweeps *newton, const mbsri_newton_step *s, int i,
                                 int flags, right_sides by, loads *f, bool full,
                                 bool below_massless, bool loops)
{
    const mbsr_model *m = by.model;
    if (flags & MBSRI_MULTI) {
        _Alignas(32) mbsri_newton_flow multi;
        loads_to_memory(f, &multi, full, below_massless);
        multi_loads(newton, i, by.r, by.load_of_body, &multi, full, loops && flags & MBSRI_FRONT);
        clear_loads(f);
        add_loads(&multi, f, full, below_massless);
    } else if (s->n) {
        const int u = m->order.u_of[s->u];
        given g = {0.0, 0.0, 0.0, 0.0};
        if (by.r) g = (given){by.r[m->order.q_of[s->q]], by.p[u], by.u[u], 0.0};
        if (by.load_of_body) g.tau = by.load_of_body[m->size.v + (size_t)s->u];
        if (loops && flags & MBSRI_FRONT)
            condense_open(newton, i, g, f, below_massless);
        else if (below_massless)
            condense_below_massless(newton, s, g, f, full);
        else
            condense_loads(newton, s->u, g, f, full);
    } else if (loops && flags & MBSRI_FRONT) {
        condense_open(newton, i, (given){0.0, 0.0, 0.0, 0.0}, f, below_massless);
    }
}

MBSRI_INLINE void solve_back(mbsri_newton_sweeps *newton, const double *r,
                             const double *load_of_body, bool full, bool below_massless, bool mixed)
{
    const mbsr_model *m = newton->model;
    const right_sides by = parts_of(m, r, load_of_body);
    mbsri_newton_flow *top = newton->flow;
    loads f;
    clear_loads(&f);
    for (int i = newton->tree->bodies; i >= 1; --i) {
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        if (mixed && flags & MBSRI_BLOCK) {
            block_loads(newton, i, r, load_of_body, &f, &top, below_massless);
            continue;
        }
        if (flags & MBSRI_LEAF) clear_loads(&f);
        if (flags & MBSRI_BRANCHES) add_loads(--top, &f, full, below_massless);
        if (full && load_of_body) add_load(newton, i, load_of_body, &f, below_massless);
        condense_joint(newton, s, i, flags, by, &f, full, below_massless, false);
        hand_loads_over(s, &f, &top, full, below_massless);
        if (mixed && flags & MBSRI_TO_BLOCK) give_loads(newton, i, &f, below_massless);
    }
}

/* The motion of the origin of the body's own frame, and dV = nu + xi x V there: as the body's pose
 * and V are, in space or in the plane. */
MBSRI_OUTLINE void report_motion(const mbsri_newton_sweeps *newton, int i, const v4 x[4],
                                 double *motion)
{
    const mbsri_newton_own *own = newton->acting.own + i;
    const int d = newton->model->body[i].d;
    const v4 arm = load(own->arm), theta = x[ROTATION];
    const v4 out[4] = {theta, x[DISPLACEMENT] + cross(theta, arm),
                       x[SPIN] + cross(theta, load(own->omega)),
                       x[DRIFT] + cross(x[SPIN], arm) + cross(theta, load(own->v))};
    double lifted[12];
    for (int g = 0; g < 4; ++g) {
        for (int k = 0; k < 3; ++k) lifted[3 * g + k] = out[g][k];
    }
    mbsri_lower(d, lifted, motion);
    mbsri_lower(d, lifted + 6, motion + d);
}

/* The motion of block i from its predecessor's, x where that is in the sweeps. */
MBSRI_OUTLINE void move_block(mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    const mbsri_newton_step *s = newton->step + i;
    if (s->parent > 0 && !(s->flags & MBSRI_TO_BLOCK))
        report_motion(newton, s->parent, x, mbsri_border_room(newton, s->parent));
    mbsri_border_substitute(newton, i);
}

/* That of body i's predecessor, a block. */
MBSRI_OUTLINE void take_motion(const mbsri_newton_sweeps *newton, int i, v4 x[4])
{
    _Alignas(32) double at[16];
    mbsri_border_motion(newton, newton->step[i].parent, at);
    for (int g = 0; g < 4; ++g) x[g] = load(at + 4 * g);
}

/* delta, by its parts. */
typedef struct solution {
    const mbsr_model *model;
    double *delta, *p, *u;
} solution;

MBSRI_INLINE solution solution_of(const mbsr_model *m, double *delta)
{
    return (solution){m, delta, delta + m->nq, delta + m->nq + m->nu};
}

/* The joint of body i: its coordinate, and the body's motion from its predecessor's. */
MBSRI_INLINE void move_joint(mbsri_newton_sweeps *newton, const mbsri_newton_step *s, int i,
                             int flags, const double *r, solution of, v4 x[4], bool full,
                             bool loops)
{
    const mbsr_model *m = of.model;
    double *const delta = of.delta, *const delta_p = of.p, *const delta_u = of.u;
    const v4 rho = load(s->rho);
    if (flags & MBSRI_MULTI) {
        _Alignas(32) double at[16];
        for (int g = 0; g < groups(full); ++g) store(at + 4 * g, x[g]);
        multi_motion(newton, i, r, delta, at, full, loops && flags & MBSRI_FRONT);
        for (int g = 0; g < groups(full); ++g) x[g] = load(at + 4 * g);
    } else if (s->n) {
        const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
        v4 K = load3(col->K) * x[0] + load3(col->K + 3) * x[1] + load3(col->K + 6) * x[2],
           Q = load3(col->Q) * x[0] + load3(col->Q + 3) * x[1] + load3(col->Q + 6) * x[2];
        if (full) K += load3(col->K_last) * x[3];
        if (full) Q += load3(col->Q_last) * x[3];
        const int u = m->order.u_of[s->u], q = m->order.q_of[s->q];
        double du = newton->k[s->u] - sum3(K), rest = r ? r[q] : 0.0,
               dp = newton->p[s->u] + sum3(Q);
        if (loops && flags & MBSRI_FRONT) move_open(newton, i, &du, &rest, &dp);
        const double both = du + rest, dq = both * newton->by_c;
        delta[q] = dq;
        delta_p[u] = dp + m->armature[s->u] * du;
        delta_u[u] = du;
        const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
        x[DRIFT] +=
            cross(x[SPIN], rho) + S_v * splat(du) + (S_v - load3(col->row + 3)) * splat(both);
        if (full) x[DISPLACEMENT] += cross(x[ROTATION], rho) + S_v * splat(dq);
        x[SPIN] += S_w * splat(du) + (S_w - load3(col->row)) * splat(both);
        x[ROTATION] += S_w * splat(dq);
    } else {
        x[DRIFT] += cross(x[SPIN], rho);
        if (full) x[DISPLACEMENT] += cross(x[ROTATION], rho);
    }
}

MBSRI_INLINE void solve_forward(mbsri_newton_sweeps *newton, const double *r, double *delta,
                                double *motion, bool full, bool mixed)
{
    const mbsr_model *m = newton->model;
    const solution of = solution_of(m, delta);
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    for (int i = 1; i <= newton->tree->bodies; ++i) {
        const mbsri_newton_step *s = newton->step + i;
        if (s->parent == 0) {
            for (int g = 0; g < groups(full); ++g) x[g] = splat(0.0);
        } else if (mixed && s->flags & MBSRI_TO_BLOCK) {
            if (!(s->flags & MBSRI_BLOCK)) take_motion(newton, i, x);
        } else if (s->parent != i - 1) {
            for (int g = 0; g < groups(full); ++g)
                x[g] = load(newton->x[newton->step[s->parent].branch] + 4 * g);
        }
        if (mixed && s->flags & MBSRI_BLOCK) {
            move_block(newton, i, x);
            continue;
        }
        move_joint(newton, s, i, s->flags, r, of, x, full, false);
        if (s->flags & MBSRI_BRANCHES) {
            for (int g = 0; g < groups(full); ++g) store(newton->x[s->branch] + 4 * g, x[g]);
        }
        if (full && motion) report_motion(newton, i, x, motion + 12 * i);
    }
}

MBSRI_INLINE void solve_system(mbsri_newton_sweeps *newton, const double *r,
                               const double *load_of_body, double *delta, double *motion, bool full)
{
    if (newton->last.below_massless)
        solve_back(newton, r, load_of_body, full, true, false);
    else if (r && !load_of_body) /* mostly so: without questions at every body */
        solve_back(newton, r, NULL, full, false, false);
    else
        solve_back(newton, r, load_of_body, full, false, false);
    if (r)
        solve_forward(newton, r, delta, motion, full, false);
    else
        solve_forward(newton, NULL, delta, motion, full, false);
}

/* The same of a tree with blocks. */
MBSRI_OUTLINE void solve_mixed(mbsri_newton_sweeps *newton, const double *r,
                               const double *load_of_body, double *delta)
{
    mbsri_front_start(newton->mixed);
    solve_back(newton, r, load_of_body, true, newton->last.below_massless, true);
    solve_forward(newton, r, delta, NULL, true, true);
    mbsri_front_finish(newton->mixed, delta);
}

#endif
