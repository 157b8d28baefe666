/* A consistent start of a model with closures, on the tree: see loops_tree_start.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Positions are those of loops/close_tree.c. Then Newton systems of the momentum form with a large c stand for the dense
 * ones of loops/start.c:
 *
 *   velocities    r = (0, 0, 0, C u + g_t, 0)       u <- u - du      (p changes by impulses of the loops)
 *   balance       r = (0, 0, F_u, C u + g_t, 0)     u, lambda <- u - du, lambda - c dLambda
 *   rates         r = (c q', c p', -dF/dt)          u' = du,  lambda <- lambda + dLambda
 *
 * The last is the system of the derivatives of F along the solution, as in damped_start.c; p' has the
 * loop forces found so far, and what is missing comes out as dLambda.
 *
 * Where that fails, rows may depend on each other. Which ones do is found cluster by cluster (loops/clusters.h),
 * in the closed position and in one nearby; they are left out, and what is left of them is looked at in
 * the end. */
#include "massless/loops_tree_start.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "loops/assemble.h"
#include "loops/close_tree.h"
#include "loops/clusters.h"
#include "massless/damped_start.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <mbsrank/newton.h>

#include <math.h>

typedef struct work {
    const mbsr_model *m;
    mbsr_data *d;
    double t;
    int size, rates, loops, places; /* of y; where u, Lambda, Eta begin */
    mbsr_newton *newton;
    double *q, *u, *lambda;
    double *y, *yp, *F, *r, *x, *other, *further; /* size each */
    const double *offset;                         /* held: what the gaps are to be; NULL: zero */
    double *q_try, *q_given, *u_given;            /* nq, nq, nu */
    bool *there;                                  /* rows: left out nearby */
    bool good;
    void *memory;
} work;

static const double large = 1e8; /* 1/s */
/* where lambda = c Lambda is to be found, in which rounding counts c times */
static const double moderate = 1e5;

static int open_work(work *w)
{
    mbsr_error error;
    const size_t size = (size_t)w->size;
    const size_t nq = (size_t)w->m->nq, nu = (size_t)w->m->nu, rows = (size_t)w->m->rows;
    w->memory = mbsri_allocate(&w->m->allocator,
                               (7 * size + 2 * nq + nu) * sizeof(double) + rows * sizeof(bool));
    if (!w->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d numbers", w->size);
    double **const vector[] = {&w->y, &w->yp,    &w->F,       &w->r,
                               &w->x, &w->other, &w->further, &w->q_try};
    for (size_t k = 0; k < 8; ++k) *vector[k] = (double *)w->memory + k * size;
    w->q_given = w->q_try + nq;
    w->u_given = w->q_given + nq;
    w->there = (bool *)(void *)(w->u_given + nu);
    mbsri_copy(nq, w->q, w->q_given);
    mbsri_copy(nu, w->u, w->u_given);
    const int status = mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, NULL, &w->newton, &error);
    if (status) w->d->error = error;
    return status;
}

static void close_work(work *w)
{
    mbsr_newton_destroy(w->newton);
    mbsri_release(&w->m->allocator, w->memory);
}

/* y of positions q and velocities u, y' with the loop forces, F there; its time derivatives are those
 * of y' = 0. */
static int evaluate(work *w, double t, const double *q)
{
    const int status = mbsri_pack(&mbsri_form_momentum, w->m, w->d, t, q, w->u, w->y);
    mbsri_zero((size_t)w->size, w->yp);
    mbsri_copy((size_t)w->m->rows, w->lambda, w->yp + w->loops);
    return status ? status : mbsr_dae_residual(w->m, w->d, MBSR_DAE_MOMENTUM, t, w->y, w->yp, w->F);
}

/* x from r at the state evaluated last; not good where that is singular. */
static int solve(work *w, double c, double *x)
{
    int status = mbsr_newton_factor(w->newton, w->d, w->t, w->y, w->yp, c);
    if (!status) status = mbsr_newton_solve(w->newton, w->r, x);
    if (status > 0) w->good = false;
    return status < 0 ? status : MBSR_OK;
}

/* Closed positions; not good where there are none. */
static int close_positions(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    const mbsr_assembly_opt assembly = mbsri_assembly_of(opt);
    const int status = mbsri_close_on_tree(w->m, w->d, w->t, &assembly, w->offset, w->q,
                                           &info->iterations, &w->good);
    return status ? status : evaluate(w, w->t, w->q);
}

/* Velocities that the rows allow, from F at the positions. */
static int find_velocities(work *w)
{
    const mbsr_model *m = w->m;
    double last = INFINITY;
    for (int step = 0; step < 8 && w->good; ++step) {
        const double open = mbsri_largest(m->rows, w->F + w->loops),
                     size = 1.0 + mbsri_largest(m->nu, w->u);
        if (open <= 1e-15 * size || (open >= 0.5 * last && open <= 1e-10 * size)) return MBSR_OK;
        last = open;
        mbsri_zero((size_t)w->size, w->r);
        mbsri_copy((size_t)m->rows, w->F + w->loops, w->r + w->loops);
        int status = solve(w, 100.0 * large, w->x);
        for (int k = 0; k < m->nu; ++k) w->u[k] -= w->x[w->rates + k];
        if (!status && w->good) status = evaluate(w, w->t, w->q);
        if (status) return status;
    }
    w->good = false;
    return MBSR_OK;
}

/* Whether some joint moves directions without mass. */
static bool deficient(const work *w)
{
    for (int i = 1; i <= w->m->bodies; ++i) {
        if (w->d->rank[i] < w->m->body[i].n) return true;
    }
    return false;
}

/* Not good where a massless direction yields the more the larger c is: a spring alone holds it. */
static int refuse_elastic(work *w)
{
    const int nu = w->m->nu, u = w->rates;
    mbsri_zero((size_t)w->size, w->r);
    mbsri_damped_push(w->m, w->d, w->r + u);
    int status = solve(w, large, w->x);
    if (!status && w->good) status = solve(w, 100.0 * large, w->other);
    if (status || !w->good) return status;
    const double largest = mbsri_largest(nu, w->other + u);
    for (int k = u; k < u + nu; ++k) {
        const double now = fabs(w->x[k]), then = fabs(w->other[k]);
        if (then > 5.0 * now && then > 1e-9 * largest) w->good = false;
    }
    return MBSR_OK;
}

/* Forces balance along directions without mass: u where dampers fix them, lambda where loops do. */
static int find_balance(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    const mbsr_model *m = w->m;
    double last = INFINITY;
    int status = mbsri_enter(m, w->d, true, MBSRI_STAGE_BACKWARD, "mbsr_dae_consistent");
    if (!status) status = refuse_elastic(w);
    for (int step = 0; step < opt->max_iterations && w->good && !status; ++step) {
        status = evaluate(w, w->t, w->q);
        mbsri_zero((size_t)w->rates, w->r);
        mbsri_copy((size_t)(w->size - w->rates), w->F + w->rates, w->r + w->rates);
        if (!status) status = solve(w, moderate, w->x);
        if (status || !w->good) return status;
        /* F_p: the forces on the joints */
        const double size = 1.0 + mbsri_largest(m->nu, w->u),
                     force = size + mbsri_largest(m->rows, w->lambda) +
                             mbsri_largest(m->nu, w->F + m->nq);
        double change = mbsri_largest(m->nu, w->x + w->rates) / size;
        for (int k = 0; k < m->nu; ++k) w->u[k] -= w->x[w->rates + k];
        for (int k = 0; k < m->rows; ++k) {
            w->lambda[k] -= moderate * w->x[w->loops + k];
            change = fmax(change, fabs(moderate * w->x[w->loops + k]) / force);
        }
        ++info->iterations;
        if (change <= opt->tolerance || (change > 0.25 * last && change <= 1e-6)) return MBSR_OK;
        last = change;
    }
    w->good = false;
    return status;
}

/* r <- -dF/dt of the algebraic equations, where y and y' are held. */
static int explicit_time(work *w)
{
    const double h = 1e-4;
    mbsri_zero((size_t)w->size, w->other);
    for (int l = 0; l < 4; ++l) {
        const int status = mbsr_dae_residual(
            w->m, w->d, MBSR_DAE_MOMENTUM, w->t + mbsri_difference_place(l) * h, w->y, w->yp, w->F);
        if (status) return status;
        for (int k = w->rates; k < w->size; ++k)
            w->other[k] -= mbsri_difference_weight(l) / (12.0 * h) * w->F[k];
    }
    return MBSR_OK;
}

/* The rates of y that the Newton system for c gives; -dF/dt stands in `other`. */
static int aim(work *w, double c, double *x)
{
    mbsri_copy((size_t)w->size, w->other, w->r);
    for (int k = 0; k < w->rates; ++k) w->r[k] = -c * w->F[k];
    return solve(w, c, x);
}

/* Two solutions, for c and 10 c, from which what decays within 1 / c is taken off. */
static int find_rates(work *w, double *udot)
{
    const mbsr_model *m = w->m;
    double last = INFINITY;
    int status = evaluate(w, w->t, w->q);
    if (!status) status = explicit_time(w);
    for (int step = 0; step < 12 && !status && w->good; ++step) {
        status = evaluate(w, w->t, w->q);
        if (!status) status = aim(w, large, w->x);
        if (!status && w->good) status = aim(w, 10.0 * large, w->further);
        if (status || !w->good) return status;
        for (int k = w->rates; k < w->size; ++k)
            w->x[k] = w->further[k] + (w->further[k] - w->x[k]) / 9.0;
        double change = mbsri_largest(m->rows, w->x + w->loops);
        const double size = mbsri_largest(m->rows, w->lambda) + mbsri_largest(m->nu, udot);
        for (int k = 0; k < m->rows; ++k) w->lambda[k] += w->x[w->loops + k];
        for (int k = 0; k < m->nu; ++k) {
            change = fmax(change, fabs(w->x[w->rates + k] - udot[k]));
            udot[k] = w->x[w->rates + k];
        }
        if (step > 0 && (change <= 1e-13 * size || (change >= 0.5 * last && change <= 1e-6 * size)))
            return MBSR_OK;
        last = change;
    }
    w->good = false;
    return status;
}

/* The state at closed positions, from these on; not good where there is none. */
static int find_state(work *w, double *udot, const mbsr_consistent_opt *opt,
                      mbsr_consistent_info *info)
{
    int status = find_velocities(w);
    if (!status && w->good && deficient(w)) status = find_balance(w, opt, info);
    if (!status && w->good) status = find_rates(w, udot);
    return status;
}

/* ---- redundant rows ---- */

/* Rows that depend on others at the positions q, or would if these were not open by that much, and how many
 * do not. */
static int choose_rows(work *w, const double *q, double open, bool *dropped, int *independent)
{
    const double far = 30.0 * open / (w->m->length > 0.0 ? w->m->length : 1.0),
                 dependent = fmax(MBSRI_DEPENDENT, fmin(far * far, 1e-2));
    bool served = false;
    mbsri_ranks found;
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_ranks_by_clusters(w->m, w->d, dependent, dropped, &found, &served);
    if (!served) w->good = false;
    *independent = found.independent;
    return status;
}

/* The largest gap at q of all rows, those left out too. */
static int widest_gap(work *w, const double *q, double *gap)
{
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_closure_gaps(w->m, w->d, w->r);
    for (int k = 0; k < w->m->held && w->offset; ++k) w->r[k] -= w->offset[k];
    *gap = mbsri_largest(w->m->held, w->r);
    return status;
}

static bool closed(const work *w, double open)
{
    return open <= 1e-10 * fmax(1.0, mbsri_largest((int)w->m->size_p, w->d->p));
}

/* Closes the loops without the rows that are redundant where the gaps are: what depends but for the gap
 * counts as redundant. */
static int close_without(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    enum { PASSES = 8 };
    double open = 0.0;
    int independent, status = widest_gap(w, w->q, &open);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        w->good = true;
        status = choose_rows(w, w->q, open, w->d->dropped, &independent);
        if (status || !w->good) return status;
        status = close_positions(w, opt, info);
        if (!status) status = widest_gap(w, w->q, &open);
        if (closed(w, open)) return status;
    }
    w->good = false;
    return status;
}

/* The rows that are redundant in the closed position; not good where more are independent in one nearby in which those
 * that are independent here stay closed: the position is singular (loops/ranks.h). */
static int choose_nearby(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    static const double step = 1e-3; /* rad or m */
    const mbsr_model *m = w->m;
    double *q = w->q, *there = w->q_given, *rate = w->further, open = 0.0;
    int here = 0, nearby = 0, status = widest_gap(w, q, &open);
    if (!status) status = choose_rows(w, q, open, w->d->dropped, &here);
    if (status || !w->good) return status;
    for (int k = 0; k < m->nu; ++k) rate[k] = fmod(0.6180339887498949 * (k + 1), 1.0) - 0.5;
    status = mbsri_velocities(m, w->d, rate);
    if (!status) status = mbsri_coordinate_rates(m, w->d, w->q_try);
    for (int k = 0; k < m->nq; ++k) there[k] = q[k] + step * w->q_try[k];
    if (!status) status = mbsri_normalise(m, w->d, there);
    w->q = there;
    if (!status) status = close_positions(w, opt, info);
    if (!status) status = widest_gap(w, there, &open);
    if (!status && w->good) status = choose_rows(w, there, open, w->there, &nearby);
    w->q = q;
    w->good = nearby <= here; /* also without such a position */
    return status ? status : evaluate(w, w->t, w->q);
}

/* Not good where rows that were left out are violated. */
static int check_left_out(work *w)
{
    double open;
    int status = widest_gap(w, w->q, &open);
    if (!status) status = mbsri_velocities(w->m, w->d, w->u);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_closure_rates(w->m, w->d, w->r);
    const double speed = 1.0 + mbsri_largest(w->m->nu, w->u);
    if (mbsri_largest(w->m->rows, w->r) > 1e-9 * speed) w->good = false;
    return status;
}

static int start_without(work *w, double *udot, const mbsr_consistent_opt *opt,
                         mbsr_consistent_info *info)
{
    const mbsr_model *m = w->m;
    mbsri_copy((size_t)m->nq, w->q_given, w->q);
    mbsri_copy((size_t)m->nu, w->u_given, w->u);
    mbsri_zero((size_t)m->rows, w->lambda);
    mbsri_zero((size_t)m->nu, udot);
    w->good = true;
    info->iterations = 0;
    int status = close_without(w, opt, info);
    if (!status && w->good) status = choose_nearby(w, opt, info);
    if (!status && w->good) status = find_state(w, udot, opt, info);
    if (!status && w->good) status = check_left_out(w);
    return status;
}

int mbsri_loops_tree_start(const mbsr_model *m, mbsr_data *d, double t, const double *offset,
                           double *q, double *u, double *udot, double *lambda,
                           const mbsr_consistent_opt *opt, mbsr_consistent_info *info, bool *served)
{
    const mbsr_error before = d->error;
    work w = {
        .m = m, .d = d, .t = t, .q = q, .u = u, .lambda = lambda, .offset = offset, .good = true};
    *served = false;
    w.rates = m->nq + m->nu;
    w.loops = w.rates + m->nu;
    w.places = w.loops + m->rows;
    w.size = w.places + m->held;
    for (int k = 0; k < m->rows; ++k) d->dropped[k] = false;
    mbsri_zero((size_t)m->rows, lambda);
    mbsri_zero((size_t)m->nu, udot);
    int status = open_work(&w);
    if (!status) status = close_positions(&w, opt, info);
    if (!status && w.good) status = find_state(&w, udot, opt, info);
    if (!status && !w.good) status = start_without(&w, udot, opt, info);
    *served = !status && w.good;
    close_work(&w);
    if (*served || (status < 0 && status != MBSR_ERR_SPACE)) return status;
    d->error = before;
    return MBSR_OK;
}
