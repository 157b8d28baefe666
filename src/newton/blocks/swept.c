/* Pools of bodies in vector code: see swept.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/swept.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/closures.h"
#include "sweeps/embed.h"

/* x += (arm x force, 0) of a wrench in groups of four. */
static void shift(const double *arm, double *x)
{
    mbsri_add_cross3(arm, x + 4, x);
}

static void add(double factor, const double *x, double *y)
{
    for (int k = 0; k < 4; ++k) y[k] += factor * x[k];
}

/* An end of a closure: what its rows are at the body, in groups of four. */
typedef struct end {
    mbsr_newton *w;
    mbsri_pool *pool;
    const mbsri_swept_place *at;
    int d, column;
    bool deep;
} end;

/* d numbers over the body, `stride` apart; about its origin, and, shifted, about its point. */
static void read(const end *e, const double *from, int stride, double x[8], double shifted[8])
{
    double own[MBSR_MAX_D], lifted[6];
    for (int l = 0; l < e->d; ++l) own[l] = from[(e->column + l) * stride];
    mbsri_lift(e->d, own, lifted);
    for (int k = 0; k < 3; ++k) x[k] = lifted[k], x[4 + k] = lifted[3 + k];
    x[3] = x[7] = 0.0;
    mbsri_copy(8, x, shifted);
    shift(e->at->arm, shifted);
}

/* A force on the body in column `at` of the pool. */
static void add_force(const end *e, int at, const double force[8])
{
    double *Q = e->w->carried.store + e->pool->Q + (size_t)(at * e->pool->stride);
    for (int k = 0; k < 8; ++k) {
        Q[8 + k] += force[k];
        if (e->deep) Q[16 + k] -= force[k];
    }
}

static double *row_of(const end *e, int at)
{
    return e->w->carried.store + e->pool->R + (size_t)(at * e->pool->motions);
}

/* Row `at` reads the pose, x as shifted. */
static void add_pose(const end *e, int at, double factor, const double x[8])
{
    double *R = row_of(e, at);
    add(factor, x, R);
    add(factor, x + 4, R + 12);
}

/* Or V: d(omega) = nu_w + dtheta x omega, dv = nu_v + nu_w x arm + dtheta x v. */
static void add_twist(const end *e, int at, const double x[8], const double shifted[8])
{
    double *R = row_of(e, at);
    mbsri_add_cross3(e->at->omega, x, R);
    mbsri_add_cross3(e->at->v, x + 4, R);
    add(1.0, shifted, R + 4);
    add(1.0, shifted + 4, R + 8);
}

static void add_rows(const end *e, const mbsr_data *d, const mbsri_closure *c,
                     const mbsri_loop *loop)
{
    const mbsri_carried *v = &e->w->carried;
    double x[8], row[8], slope[8];
    for (int k = 0; k < c->rows; ++k) {
        const bool dropped = d->dropped[c->row + k];
        if (dropped && !mbsri_is_stiff(c, k)) continue;
        const int lambda = mbsri_carried_join(e->w, e->pool, mbsri_name_lambda(c, k));
        read(e, v->store + loop->slope + k, c->rows, x, slope);
        read(e, d->closure_C + c->at + k, c->rows, x, row);
        add_force(e, lambda, row);
        add_twist(e, lambda, x, row);
        add_pose(e, lambda, 1.0, slope);
        if (k >= c->held || dropped) continue;
        const int eta = mbsri_carried_join(e->w, e->pool, mbsri_name_eta(e->w->model, c, k));
        double *kappa = v->store + e->pool->kappa + (size_t)(eta * MBSRI_SWEPT_FORCES);
        add(1.0, row, kappa);
        add(1.0, row + 4, kappa + 4);
        add_pose(e, eta, 1.0, row);
    }
    for (int k = 0; k < loop->rank; ++k) {
        const int at = mbsri_carried_join(e->w, e->pool, loop->across + k);
        read(e, v->store + loop->left + k * c->columns, 1, x, row);
        add_force(e, at, row);
        read(e, v->store + loop->read + k, loop->most, x, row);
        add_pose(e, at, -1.0, row);
    }
}

void mbsri_swept_take_ends(mbsr_newton *w, const mbsr_data *d, int i, const mbsri_swept_place *at)
{
    const mbsri_carried *v = &w->carried;
    for (int k = v->first_end[i]; k >= 0; k = v->end[k].next) {
        const int number = v->end[k].closure;
        const mbsri_closure *c = (const mbsri_closure *)w->model->closures.data + number;
        const mbsri_loop *loop = v->loop + number;
        const end e = {.w = w,
                       .pool = v->swept + (i == loop->level / 2 ? loop->pool : i),
                       .at = at,
                       .d = w->model->body[i].d,
                       .column = c->column[v->end[k].slot],
                       .deep = w->node[i].deep};
        add_rows(&e, d, c, loop);
    }
}
