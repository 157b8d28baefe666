/* Pools of bodies in vector code: see swept.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/swept.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "sweeps/embed.h"

void mbsri_swept_clear(mbsr_newton *w)
{
    for (int k = 0; k < w->carried.fronts; ++k) w->carried.swept[k].count = 0;
}

/* x += (arm x force, 0) of a wrench in groups of four. */
static void shift(const double *arm, double *x)
{
    mbsri_add_cross3(arm, x + 4, x);
}

/* A wrench or twist of a body as groups of four. */
static void spread(int d, const double *from, double to[8])
{
    double lifted[6];
    mbsri_lift(d, from, lifted);
    for (int k = 0; k < 3; ++k) to[k] = lifted[k], to[4 + k] = lifted[3 + k];
    to[3] = to[7] = 0.0;
}

/* Column `from` of the pool of the body's own coordinates: forces and kappa. */
static void take_column(mbsr_newton *w, const mbsri_pool *own, int from, const double *arm,
                        mbsri_pool *pool, int to)
{
    double *store = w->carried.store, force[8], kappa[8];
    const int d = w->model->body[own->body].d, actions = mbsri_carried_actions(w, pool);
    const double *y = store + own->Q + (size_t)(from * own->stride);
    double *Q = store + pool->Q + (size_t)(to * pool->stride),
           *sum = store + pool->kappa + (size_t)(to * MBSRI_SWEPT_FORCES);
    spread(d, y + d, force); /* sigma = -f */
    spread(d, store + own->kappa + (size_t)(from * d), kappa);
    shift(arm, force);
    shift(arm, kappa);
    for (int k = 0; k < 8; ++k) {
        Q[8 + k] -= force[k];
        if (actions == MBSRI_SWEPT_ACTIONS) Q[16 + k] += force[k];
        sum[k] += kappa[k];
    }
}

/* Row `from`, which reads pose and V: d(pose) = (dtheta, xi + dtheta x arm), d(omega) = nu_w + dtheta x
 * omega, dv = nu_v + nu_w x arm + dtheta x v. */
static void take_row(mbsr_newton *w, const mbsri_pool *own, int from, const mbsri_swept_place *at,
                     mbsri_pool *pool, int to)
{
    double *store = w->carried.store, pose[8], V[8];
    const int d = w->model->body[own->body].d;
    const double *x = store + own->R + (size_t)(from * own->motions);
    double *R = store + pool->R + (size_t)(to * pool->motions);
    spread(d, x, pose);
    spread(d, x + d, V);
    mbsri_add_cross3(at->omega, V, R);
    mbsri_add_cross3(at->v, V + 4, R);
    shift(at->arm, pose);
    shift(at->arm, V);
    for (int k = 0; k < 4; ++k) {
        R[k] += pose[k];
        R[4 + k] += V[k];
        R[8 + k] += V[4 + k];
        R[12 + k] += pose[4 + k];
    }
}

void mbsri_swept_take_ends(mbsr_newton *w, int k, const mbsri_swept_place *at)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_pool *own = v->pool + k;
    mbsri_pool *pool = v->swept + k;
    const int *name = v->numbers + own->column;
    int *place = v->numbers + own->place;
    for (int l = 0; l < own->count; ++l) { /* rows and columns have equal names and places */
        place[l] = mbsri_carried_join(w, pool, name[l]);
        take_column(w, own, l, at->arm, pool, place[l]);
    }
    const int *rows = v->numbers + pool->row;
    for (int l = 0; l < own->count; ++l) {
        const int row = mbsri_carried_find(rows, pool->count, name[l]);
        take_row(w, own, l, at, pool, row);
        for (int j = 0; j < own->count; ++j)
            v->store[pool->T + (size_t)(place[j] * pool->most + row)] +=
                v->store[own->T + (size_t)(j * own->most + l)];
    }
}
