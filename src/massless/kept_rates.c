/* Impulses by which joint rates keep the values that they are given: see kept_rates.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A start takes velocities u_0 to u = S(u_0): impulses of loops make them such as the closures
 * allow, and along directions without mass forces come to their balance. Rates E u = e are kept by
 * impulses pi of motors at these joints,
 *
 *   u = S(u_0 + X pi),    X = K^-1 R E^T,    (E S' X) pi = e - E S(u_0)
 *
 * with the inertia K of the mechanism with its loops (fronts/fronts.h). Where all motions have mass
 * R and S' are the identity. Bodies without mass take up no impulse: dampers and springs pass it on
 * to bodies that do. What arrives there is what a force c e_k for a time 1 / c leaves of momentum
 * as c grows; with the matrix A of Newton systems of the momentum form (c stands for d/dt), F_u the
 * balance of forces and p the momenta,
 *
 *   A (dq, dp, du) = (0, c e_k, -c dF_u/dtau_k)      R e_k = dp
 *   A (dq, dp, du) = (0, c R e_k, 0)                 S' X e_k = du
 *
 * two times with c and 10 c, so that what decays within 1 / c can be taken off. Where springs pass
 * impulses on, rounding grows with c^2: c goes down until two in a row agree. Of all velocities
 * that closures, balances and kept rates allow, u is then the one nearest to u_0 in the metric of
 * the masses (where dampers are symmetric). */
#include "massless/kept_rates.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "assembly/survey.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "loops/ranks.h"
#include "recursion/rounding.h"
#include "fronts/fronts.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"
#include "recursion/momentum.h"

#include <mbsrank/closure.h>
#include <mbsrank/newton.h>

#include <math.h>

static const char function[] = "mbsr_dae_consistent";
static const double fastest = 1e8;    /* c over the speed of the model, at first */
static const double slowest = 1e2;    /* and at last */
static const double agree = 1e-3;     /* R e_k by c and by c / 100, relative */
static const double unmoved = 1e-11;  /* of the mobility that a rate has without loops */
static const double dependent = 1e-9; /* of singular values of the equations for the impulses */
static const double fits = 1e-8;      /* of what is missing */

typedef struct push {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_kept_rates *k;
    mbsri_fronts system;
    bool massless;   /* some motions move no mass */
    double wrong;    /* share by which X, and so B, may be wrong */
    double *X;       /* nu x count: impulses, momenta, velocities */
    double *last;    /* nu x count: X of the c before */
    double *B;       /* count x count: E S' X */
    double *A, *pi;  /* count x count, count: scaled */
    double *scale;   /* count: inverse square roots of inertias; 0: the rate cannot be moved */
    double *g;       /* nu */
    double *rows;    /* rows */
    double *r, *x;   /* size of y */
    double *balance; /* nu x count: dF_u/dtau_k */
    double *weight;  /* nu: of momenta in R e_k, inverse square roots of inertias */
    double *work;
    int lwork, *pivots;
    void *memory;
} push;

static int open_push(push *p)
{
    const mbsr_model *m = p->m;
    const size_t nu = (size_t)m->nu, count = (size_t)p->k->count, rows = (size_t)m->rows,
                 size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    p->lwork = mbsri_lapack_gelsy_work(p->k->count, p->k->count);
    double **const array[] = {&p->last, &p->X, &p->B, &p->A,       &p->pi,     &p->scale, &p->g,
                              &p->rows, &p->r, &p->x, &p->balance, &p->weight, &p->work};
    const size_t length[] = {
        nu * count, nu * count, count * count, count * count, count, count,           nu,
        rows,       size,       size,          nu * count,    nu,    (size_t)p->lwork};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    p->memory = mbsri_allocate(&m->allocator, total * sizeof(double) + count * sizeof(int));
    if (!p->memory)
        return mbsri_fail(&p->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d joint rates that are kept", function, p->k->count);
    double *next = p->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    p->pivots = (int *)(void *)next;
    return mbsri_fronts_open(&p->system, m, p->d, true, function);
}

static void close_push(push *p)
{
    mbsri_fronts_close(&p->system);
    mbsri_release(&p->m->allocator, p->memory);
}

static double *column(const push *p, double *matrix, int l)
{
    return matrix + (size_t)l * (size_t)p->m->nu;
}

/* ---- the inertia of the mechanism ---- */

/* K at the positions of the state, factored. */
static int factor_push(push *p)
{
    const mbsr_model *m = p->m;
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k)
            p->system.left_out[c->row + k] = mbsri_is_loose(c, k) || p->d->dropped[c->row + k];
    }
    int status = mbsri_positions(m, p->d, p->k->t, p->k->y);
    if (!status) status = mbsri_closure_jacobians(m, p->d);
    if (!status) status = mbsri_fronts_factor(&p->system, NULL, function);
    p->massless = !status && p->system.frees > 0;
    return status;
}

/* x (nu) = K^-1 x, with the loops' impulses in p->rows. */
static void divide(push *p, double *x)
{
    mbsri_zero((size_t)p->m->rows, p->rows);
    mbsri_fronts_solve(&p->system, x, p->rows, p->g, p->rows);
    mbsri_copy((size_t)p->m->nu, p->g, x);
}

static void take_rates(push *p, const double *u, double *to)
{
    for (int l = 0; l < p->k->count; ++l) to[l] = u[p->k->rate[l]];
}

/* ---- past bodies without mass ---- */

/* dF_u/dtau of every rate that is kept: the balances of forces, momentum and motion left out. */
static int find_balances(push *p)
{
    const mbsr_model *m = p->m;
    mbsr_data *d = p->d;
    int status = mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, p->k->t, p->k->y, p->k->yp, p->r);
    if (!status) status = mbsri_enter(m, d, true, MBSRI_STAGE_BACKWARD, function);
    if (status) return status;
    mbsri_zero(m->size.v, d->f);
    mbsri_zero(m->size.v, d->kII);
    mbsri_zero(m->size.v, d->V);
    mbsri_zero((size_t)m->nu, d->u);
    mbsri_zero((size_t)m->nu, d->ep);
    for (int l = 0; l < p->k->count; ++l) {
        mbsri_zero((size_t)m->nu, p->g);
        p->g[p->k->rate[l]] = 1.0;
        mbsri_gather(m, p->g, d->tau);
        mbsri_backward_loads(m, d);
        for (int i = 1; i <= m->bodies; ++i) {
            if (!mbsri_heads(m, d, i)) continue;
            const mbsri_group g = mbsri_group_of(m, d, i);
            mbsri_balance_of(m, d, &g, d->vec);
            mbsri_group_scatter(m, &g, d->vec, column(p, p->balance, l));
        }
    }
    d->stage = MBSRI_STAGE_NONE;
    return MBSR_OK;
}

/* R e_k of all into X, by a matrix for c; `last`: the X found with a tenth of that, whose error is
 * taken off. Then E S' X. */
static int pass_on(push *p, mbsr_newton *newton, double c, bool last)
{
    const mbsr_model *m = p->m;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    const int nu = m->nu, momenta = m->nq, rates = m->nq + nu;
    int status = mbsr_newton_factor(newton, p->d, p->k->t, p->k->y, p->k->yp, c);
    for (int l = 0; l < p->k->count && !status; ++l) {
        double *X = column(p, p->X, l), *force = column(p, p->balance, l);
        mbsri_zero(size, p->r);
        p->r[momenta + p->k->rate[l]] = c;
        mbsri_ax(nu, 1, -c, force, &(double){1.0}, p->r + rates);
        status = mbsr_newton_solve(newton, p->r, p->x);
        for (int j = 0; j < nu; ++j) {
            const double now = p->x[momenta + j];
            X[j] = last ? now + (now - X[j]) / 9.0 : now;
        }
        if (status || !last) continue;
        mbsri_zero(size, p->r);
        mbsri_ax(nu, 1, c, X, &(double){1.0}, p->r + momenta);
        status = mbsr_newton_solve(newton, p->r, p->x);
        take_rates(p, p->x + rates, p->B + (size_t)l * (size_t)p->k->count);
    }
    return status;
}

static int pass_twice(push *p, mbsr_newton *newton, double c)
{
    const int status = pass_on(p, newton, c, false);
    return status ? status : pass_on(p, newton, 10.0 * c, true);
}

/* By how much X and the last one differ, beside the largest of each column. */
static double apart(const push *p)
{
    double largest = 0.0;
    for (int l = 0; l < p->k->count; ++l) {
        const double *X = column(p, p->X, l), *last = column(p, p->last, l);
        double off = 0.0, most = 0.0;
        for (int j = 0; j < p->m->nu; ++j) {
            off = fmax(off, fabs(X[j] - last[j]) * p->weight[j]);
            most = fmax(most, fabs(X[j]) * p->weight[j]);
        }
        if (off > 0.0) largest = fmax(largest, off / most);
    }
    return largest;
}

/* With the first c at which it is as at the one before, or the one at which it is most so. */
static int pass_by_best(push *p, mbsr_newton *newton)
{
    const size_t numbers = (size_t)p->m->nu * (size_t)p->k->count;
    double c = fastest * p->k->speed, best = c, least = INFINITY;
    int status = pass_twice(p, newton, c);
    while (!status && c > slowest * p->k->speed) {
        mbsri_copy(numbers, p->X, p->last);
        c *= 0.01;
        status = pass_twice(p, newton, c);
        const double off = status ? INFINITY : apart(p);
        if (off < least) least = off, best = c;
        p->wrong = least;
        if (least <= agree) return status;
    }
    return pass_twice(p, newton, best);
}

static void find_weights(push *p)
{
    mbsri_inverse_inertias(p->m, p->d, p->x);
    mbsri_scatter(p->m, p->x, p->weight);
    for (int j = 0; j < p->m->nu; ++j) p->weight[j] = sqrt(p->weight[j]);
}

static int pass_massless(push *p)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton_info info = {.exact = 1};
    mbsr_newton *newton = NULL;
    mbsr_error error;
    opt.max_rank = 600; /* a few solutions are worth a large correction */
    int status = mbsr_newton_create(p->m, MBSR_DAE_MOMENTUM, &opt, &newton, &error);
    if (status) {
        p->d->error = error;
        return status;
    }
    find_weights(p);
    status = find_balances(p);
    if (!status) status = pass_by_best(p, newton);
    if (status) p->d->error = *mbsr_newton_error(newton);
    mbsr_newton_get_info(newton, &info);
    mbsr_newton_destroy(newton);
    if (!status && !info.exact)
        status = mbsri_fail(&p->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                            "%s: rates are not kept where bodies without mass are moved and so "
                            "many force elements act across the tree",
                            function);
    return status;
}

/* ---- impulses ---- */

/* X, and E S' X into B. */
static int find_changes(push *p)
{
    const mbsr_model *m = p->m;
    int status = factor_push(p);
    for (int l = 0; l < p->k->count; ++l) {
        mbsri_zero((size_t)m->nu, column(p, p->X, l));
        column(p, p->X, l)[p->k->rate[l]] = 1.0;
    }
    if (!status && p->massless) {
        status = pass_massless(p);
        if (!status) status = factor_push(p);
    }
    if (status) return status;
    for (int l = 0; l < p->k->count; ++l) {
        double *X = column(p, p->X, l);
        divide(p, X);
        if (!p->massless) take_rates(p, X, p->B + (size_t)l * (size_t)p->k->count);
    }
    return MBSR_OK;
}

/* Scales of the rates by the inertias that they move, and of those that loops or balances hold,
 * zero. */
static void find_scales(push *p)
{
    const int count = p->k->count;
    mbsri_inverse_inertias(p->m, p->d, p->x);
    mbsri_scatter(p->m, p->x, p->g);
    for (int l = 0; l < count; ++l) {
        const double mobility = p->B[l * count + l], free = p->g[p->k->rate[l]];
        p->scale[l] = fabs(mobility) > unmoved * free ? 1.0 / sqrt(fabs(mobility)) : 0.0;
    }
}

/* The rate that cannot keep its value, by what the equations for pi leave of it; -1: none. left
 * (count): of all, over their scales. */
static int worst_left(const push *p, double *left)
{
    const int count = p->k->count;
    double largest = 0.0;
    int worst = -1;
    for (int l = 0; l < count; ++l) {
        const double size = p->k->size[l];
        left[l] = p->k->missing[l];
        for (int j = 0; j < count; ++j) left[l] -= p->B[j * count + l] * p->pi[j];
        const double share = fabs(left[l]) / fmax(size, 1e-300);
        if (fabs(left[l]) <= fits * size || share <= largest) continue;
        largest = share;
        worst = l;
    }
    return worst;
}

/* The row with the largest impulse, of moments and forces times the longest lever, against those
 * that would undo what is left; -1: none bears any. */
static int holding_row(push *p, const double *left)
{
    const mbsr_model *m = p->m;
    const mbsri_closure *c = m->closures.data;
    const double lever = m->rows > 0 ? mbsri_longest_lever(m, p->d) : 0.0;
    double largest = 0.0, *impulse = p->x;
    int row = -1;
    mbsri_zero((size_t)m->nu, impulse);
    for (int l = 0; l < p->k->count; ++l) {
        const double scale = p->scale[l] > 0.0 ? p->scale[l] * p->scale[l] : 1.0;
        impulse[p->k->rate[l]] = left[l] * scale;
    }
    divide(p, impulse);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const bool moves = mbsri_row_kind(m, p->d, c, k) == MBSR_COORDINATE_TRANSLATION;
            const double now = fabs(p->rows[c->row + k]) * (moves ? lever : 1.0);
            if (now <= largest) continue;
            largest = now;
            row = c->row + k;
        }
    }
    return row;
}

static int refuse_rate(push *p, int worst, const double *left)
{
    const mbsr_model *m = p->m;
    char label[MBSRI_LABEL], loop[MBSRI_LABEL];
    const int rate = p->k->rate[worst], row = holding_row(p, left);
    int i = 1, closure = MBSR_NONE, own = 0;
    const char *name = "";
    while (rate < m->body[i].u || rate >= m->body[i].u + m->body[i].n) ++i;
    mbsri_body_label(m, i, label);
    const double wanted = p->k->wanted[worst], nearest = wanted - left[worst];
    if (row < 0)
        return mbsri_fail(&p->d->error, MBSR_NO_CONVERGENCE, m->body[i].id, MBSR_NONE,
                          "%s: u%d of %s cannot keep %.9g: no impulse reaches it, the balance of "
                          "forces on bodies without mass leaves %.9g",
                          function, rate - m->body[i].u, label, wanted, nearest);
    mbsr_closure_of_row(m, row, &closure, &own, &name);
    return mbsri_fail(
        &p->d->error, MBSR_LOOP_OPEN, m->body[i].id, MBSR_NONE,
        "%s: u%d of %s cannot keep %.9g: row %d%s%s of %s, with the other rates that are "
        "kept, leaves it %.9g",
        function, rate - m->body[i].u, label, wanted, own, *name ? " " : "", name,
        mbsri_closure_label(m, closure, loop), nearest);
}

/* pi of least norm in the scaled equations, of whose singular values those below `least` are none.
 */
static int find_impulses(push *p, double least)
{
    const int count = p->k->count;
    int rank;
    for (int l = 0; l < count; ++l) {
        for (int j = 0; j < count; ++j)
            p->A[l * count + j] = p->B[l * count + j] * p->scale[l] * p->scale[j];
        p->pi[l] = p->k->missing[l] * p->scale[l];
    }
    if (mbsri_lapack_gelsy(count, count, p->A, p->pi, least, p->pivots, &rank, p->work, p->lwork))
        return mbsri_fail(&p->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: a least-squares problem of the rates that are kept failed",
                          function);
    for (int l = 0; l < count; ++l) p->pi[l] *= p->scale[l];
    return MBSR_OK;
}

static void add_sizes(push *p)
{
    const int count = p->k->count;
    for (int l = 0; l < count; ++l) {
        for (int j = 0; j < count; ++j) p->k->size[j] += fabs(p->B[l * count + j] * p->pi[l]);
    }
}

/* Rates that depend on each other by loops have equations that do, but for what B is wrong by: the
 * impulses are without what that adds, where they meet what is missing. */
static int run(push *p, double *tried)
{
    int status = find_changes(p);
    if (!status) find_scales(p);
    if (!status) status = find_impulses(p, fmax(dependent, p->wrong));
    if (!status && p->wrong > dependent && worst_left(p, p->work) >= 0)
        status = find_impulses(p, dependent);
    if (status) return status;
    add_sizes(p);
    const int worst = worst_left(p, p->work);
    if (worst >= 0) return refuse_rate(p, worst, p->work);
    for (int l = 0; l < p->k->count; ++l)
        mbsri_ax(p->m->nu, 1, p->pi[l], column(p, p->X, l), &(double){1.0}, tried);
    return MBSR_OK;
}

int mbsri_kept_rates_push(const mbsr_model *m, mbsr_data *d, const mbsri_kept_rates *k,
                          double *tried)
{
    push p = {.m = m, .d = d, .k = k};
    int status = open_push(&p);
    if (!status) status = run(&p, tried);
    close_push(&p);
    return status;
}
