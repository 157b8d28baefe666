/* Closures at bodies in the Newton sweeps: what their rows and multipliers are there.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A row e reads the velocity of its body, (dtheta, xi) + ... of newton/carried/carried.c in the
 * sweeps' perturbations: with the arm from the body's point to the origin of its own frame,
 *
 *   d(omega) = nu_w + dtheta x omega,   dv = nu_v + nu_w x arm + dtheta x v,
 *       d(origin) = xi + dtheta x arm */
#ifndef MBSRI_NEWTON_ENDS_H
#define MBSRI_NEWTON_ENDS_H

#include "newton/carried/follower.h"
#include "newton/sweeps/fronts.h"
#include "recursion/closures.h"
#include "sweeps/embed.h"

/* A wrench, or what reads a motion: angular and linear part. */
typedef struct pair6 {
    v4 w, v;
} pair6;

/* An end of a closure at body i. */
typedef struct loop_end {
    const mbsri_closure *c;
    const mbsri_loop *loop;
    open_pool to;
    v4 arm, omega, v;
    int d, column;
    bool below_massless;
} loop_end;

/* d numbers over the body, `stride` apart. */
MBSRI_INLINE pair6 read6(const loop_end *e, const double *from, int stride)
{
    const double *x = from + e->column * stride;
    if (e->d == 6)
        return (pair6){{x[0], x[stride], x[2 * stride], 0.0},
                       {x[3 * stride], x[4 * stride], x[5 * stride], 0.0}};
    return (pair6){{0.0, 0.0, e->d == 3 ? x[2 * stride] : 0.0, 0.0}, {x[0], x[stride], 0.0, 0.0}};
}

/* From the origin of the body's frame to its point. */
MBSRI_INLINE pair6 shift6(const loop_end *e, pair6 x)
{
    return (pair6){x.w + cross(e->arm, x.v), x.v};
}

MBSRI_INLINE void add_to(double *to, v4 x)
{
    store3(to, load3(to) + x);
}

/* A force on the body in column `at`. */
MBSRI_INLINE void add_force(const loop_end *e, int at, pair6 force)
{
    double *Q = e->to.Q + at * MBSRI_LANE_ACTIONS;
    add_to(Q + 4 * MOMENT, force.w);
    add_to(Q + 4 * FORCE, force.v);
    if (!e->below_massless) return;
    add_to(Q + 16, -force.w);
    add_to(Q + 20, -force.v);
}

/* Row `at` reads the pose by x. */
MBSRI_INLINE void add_pose(const loop_end *e, int at, pair6 x)
{
    double *R = e->to.R + at * MBSRI_LANE_MOTIONS;
    add_to(R + 4 * ROTATION, x.w);
    add_to(R + 4 * DISPLACEMENT, x.v);
}

/* What loop forces on the body change with its own place; slopes over displacement and rotation. */
MBSRI_INLINE void add_own_slopes(const mbsri_carried *v, const loop_end *e, slab *y)
{
    const int columns = e->c->columns, first = e->column * columns;
    const double *S = v->store + e->loop->S + first;
    slopes own;
    memset(&own, 0, sizeof own);
    for (int k = 0; k < e->d; ++k) {
        const bool six = e->d == 6, turns = six ? k < 3 : k == 2;
        v4 *to = own.by[turns ? ROTATION : DISPLACEMENT][turns && !six ? 2 : k % 3];
        const pair6 x = shift6(e, read6(e, S + k * columns, 1));
        to[0] = x.w;
        to[1] = x.v;
    }
    add_turned(own.by[DISPLACEMENT], e->arm, own.by[ROTATION]);
    for (int g = ROTATION; g <= DISPLACEMENT; g += DISPLACEMENT) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) {
                y->P[g][j][MOMENT + r] += own.by[g][j][r];
                if (e->below_massless) y->Y[g][j][r] -= own.by[g][j][r];
            }
        }
    }
}

/* The rows of the end and their multipliers; `dropped`: of the model's rows. */
MBSRI_OUTLINE void add_rows(const mbsri_newton_sweeps *newton, const mbsr_data *data, loop_end *e)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const mbsri_closure *c = e->c;
    const double *C = data->closure_C + c->at, *acts = C, *holds = C;
    if (e->loop->follower) {
        const mbsri_closure_turn turn = mbsri_turn_of(v, c, e->loop);
        acts = turn.acts, holds = turn.holds;
    }
    for (int k = 0; k < c->rows; ++k) {
        const bool dropped = data->dropped[c->row + k];
        if (dropped && !mbsri_is_stiff(c, k)) continue;
        const int lambda = place_of_name(&e->to, mbsri_name_lambda(c, k));
        const pair6 own = read6(e, C + k, c->rows), row = shift6(e, own);
        add_force(e, lambda, shift6(e, read6(e, acts + k, c->rows)));
        add_pose(e, lambda, shift6(e, read6(e, v->store + e->loop->slope + k, c->rows)));
        double *R = e->to.R + lambda * MBSRI_LANE_MOTIONS;
        add_to(R + 4 * ROTATION, cross(e->omega, own.w) + cross(e->v, own.v));
        add_to(R + 4 * SPIN, row.w);
        add_to(R + 4 * DRIFT, row.v);
        if (k >= c->position_rows || dropped) continue;
        const int eta = place_of_name(&e->to, mbsri_name_eta(w->model, c, k));
        double *kappa = e->to.kappa + eta * MBSRI_LANE_FORCES;
        add_to(kappa, row.w);
        add_to(kappa + 4, row.v);
        add_pose(e, eta, shift6(e, read6(e, holds + k, c->rows)));
    }
    for (int k = 0; k < e->loop->rank; ++k) {
        const int at = place_of_name(&e->to, e->loop->across + k);
        const double *left = v->store + e->loop->left + k * c->columns;
        const pair6 x = shift6(e, read6(e, v->store + e->loop->read + k, e->loop->most));
        add_force(e, at, shift6(e, read6(e, left, 1)));
        add_pose(e, at, (pair6){-x.w, -x.v});
    }
}

/* The ends of closures at body i. */
MBSRI_OUTLINE void take_ends(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    const mbsri_newton_own *own = newton->acting.own + i;
    loop_end e;
    if (v->first_end[i] < 0) return;
    e.below_massless =
        newton->last.below_massless && newton->step[i].below_massless & MBSRI_BELOW_MASSLESS;
    e.arm = load(own->arm);
    e.omega = load(own->omega);
    e.v = load(own->v);
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const int number = v->end[k].closure;
        e.d = v->end[k].d;
        e.c = (const mbsri_closure *)w->model->closures.data + number;
        if (mbsri_is_coupling(e.c)) continue; /* see fronts.h */
        e.loop = v->loop + number;
        e.column = e.c->column[v->end[k].slot];
        e.to = view_pool(v, v->lane_pool + (i == v->pool[e.loop->pool].body ? e.loop->pool : i));
        add_own_slopes(v, &e, y);
        add_rows(newton, run->data, &e);
    }
}

#endif
