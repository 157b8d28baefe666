/* Consistent states of the reduced model on the slow motion, and that motion.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/smooth.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "small/loads.h"
#include "small/twins.h"

#include <math.h>

static int consistent(mbsr_small_masses *s, double t, const double *q, const double *u, double *y,
                      double *yp)
{
    const mbsri_twin *twin = &s->reduced;
    int status = mbsr_dae_pack(twin->model, twin->data, MBSR_DAE_MOMENTUM, t, q, u, y);
    if (!status)
        status =
            mbsr_dae_consistent(twin->model, twin->data, MBSR_DAE_MOMENTUM, t, y, yp, NULL, NULL);
    return mbsri_small_failed(s, status, mbsr_data_error(twin->data));
}

/* The rate that a lightly damped direction should have at t, or its derivative. */
static double rate_at(const mbsr_small_masses *s, const mbsri_slow *x, double t, int derivative)
{
    const double h = t - s->start.t;
    const double *r = x->rate;
    if (derivative) return r[1] + h * (r[2] + h / 2.0 * r[3]);
    return r[0] + h * (r[1] + h / 2.0 * (r[2] + h / 3.0 * r[3]));
}

/* Adds what moves in lightly damped directions while all masses stay, until entries `at` of them
 * have the values wanted: n numbers from entry `from` of the patterns. */
static void impose(const mbsr_small_masses *s, bool rates, const double *wanted, double *x)
{
    const mbsr_model *m = s->given;
    const int from = rates ? m->nq + m->nu : 0, n = rates ? m->nu : m->nq;
    for (int l = 0; l < s->slow.count; ++l) {
        const mbsri_slow *y = s->slow.each + l;
        const double step = wanted[l] - x[rates ? y->u : y->q];
        for (int k = 0; k < n; ++k) x[k] += step * y->pattern[from + k];
    }
}

void mbsri_small_impose(mbsr_small_masses *s, double t, int derivative, double *u)
{
    for (int l = 0; l < s->slow.count; ++l)
        s->slow.wanted[l] = rate_at(s, s->slow.each + l, t, derivative);
    impose(s, true, s->slow.wanted, u);
}

/* One step of Newton's method to positions at which the lightly damped directions have their rates,
 * from the consistent y, yp: with these rates put in, the forces that remain are balanced by
 * changes of position. The matrix has k + c d where k is meant. *moved: the largest change beside
 * the size of q. */
static int approach(mbsr_small_masses *s, double t, const double *y, const double *yp, double *q,
                    double *moved)
{
    const mbsr_model *m = s->reduced.model;
    const int first = m->nq + m->nu;
    double *change = s->work.total, *state = s->work.trial, *rates = s->work.trial + s->size,
           size = 0.0;
    mbsri_copy((size_t)s->size, y, state);
    mbsri_copy((size_t)s->size, yp, rates);
    mbsri_small_impose(s, t, 0, state + first);
    int status = mbsri_small_unloaded(s, &s->reduced, t, state, rates);
    if (status) return status;
    mbsri_zero((size_t)first, s->work.F); /* q' is not that of the state, p' does not matter */
    status = mbsr_newton_solve(s->reduced.newton, s->work.F, change);
    if (status) return mbsri_small_failed(s, status, mbsr_newton_error(s->reduced.newton));
    for (int k = 0; k < m->nq; ++k) size = fmax(size, fabs(y[k]));
    *moved = 0.0;
    for (int l = 0; l < s->slow.count; ++l) {
        const mbsri_slow *x = s->slow.each + l;
        const double step = change[x->q] * (1.0 + x->relaxation * s->slow.c);
        s->slow.wanted[l] = y[x->q] - step;
        if (step != 0.0) *moved = fmax(*moved, fabs(step) / (size + fabs(step)));
    }
    mbsri_copy((size_t)m->nq, y, q);
    impose(s, false, s->slow.wanted, q);
    return MBSR_OK;
}

int mbsri_small_settle(mbsr_small_masses *s, double t, const double *q, const double *u, double *y,
                       double *yp)
{
    enum { MOST = 20, FIRST = 4 };
    static const double near_enough = 1e-6;
    int status = consistent(s, t, q, u, y, yp);
    double moved = 1.0;
    if (s->slow.count == 0) return status;
    double *near = s->work.trial + 2 * s->size;
    for (int k = 0; k < MOST && !status && moved > 1e-13; ++k) {
        const double before = moved;
        mbsri_copy((size_t)s->given->nq, q, near);
        status = approach(s, t, y, yp, near, &moved);
        /* at this rate of convergence it will not be reached */
        if (k >= FIRST && moved * pow(moved / before, MOST - 1 - k) > near_enough) break;
        if (!status) status = consistent(s, t, near, u, y, yp);
    }
    if (status || moved < near_enough) return status;
    return mbsri_fail(&s->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "no state found at t = %g at which lightly damped directions move slowly", t);
}

/* y = the start moved by h yp, and yp there, on the slow motion. */
static int move_slowly(mbsr_small_masses *s, double h, double *y, double *yp)
{
    const mbsr_model *m = s->reduced.model;
    const int u = m->nq + m->nu;
    for (int k = 0; k < m->nq; ++k) s->work.q[k] = s->y[k] + h * yp[k];
    for (int k = 0; k < m->nu; ++k) s->work.u[k] = s->y[u + k] + h * yp[u + k];
    int status = mbsr_normalise(m, s->reduced.data, s->work.q);
    if (!status) status = mbsri_small_settle(s, s->start.t + h, s->work.q, s->work.u, y, yp);
    if (!status) mbsri_small_impose(s, s->start.t + h, 1, yp + u);
    return status;
}

/* One step of the classical Runge-Kutta method. */
int mbsri_small_beside(mbsr_small_masses *s, double h, double *y, double *yp)
{
    static const double part[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    int status = MBSR_OK;
    mbsri_zero((size_t)s->size, s->work.slope);
    mbsri_copy((size_t)s->size, s->yp, yp);
    for (int k = 0; k < 4 && !status; ++k) {
        if (k > 0) status = move_slowly(s, part[k] * h, y, yp);
        for (int l = 0; l < s->size; ++l) s->work.slope[l] += weight[k] / 6.0 * yp[l];
    }
    mbsri_copy((size_t)s->size, s->work.slope, yp);
    return status ? status : move_slowly(s, h, y, yp);
}
