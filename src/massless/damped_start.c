/* A consistent start in O(N): see damped_start.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The algebraic equations F_u(t, q, p, u) = 0 of the momentum form fix u for given q and p where
 * dF_u/du is regular: index 1. The Newton system for a large c keeps q and p, since dq = (G du +
 * r_q) / c and dp = (dP + r_p) / c, so that
 *
 *   u <- u - du,   r = (0, 0, F_u)
 *
 * Along a direction that a spring alone holds, du grows with c, while what dampers hold stays and
 * what masses hold shrinks. Two solutions with c and 100 c tell.
 *
 * Then u' is the third part of the solution (q', p', u') of dF_u/dy y' = -dF_u/dt: of the Newton
 * system whose r_q and r_p are chosen so that dq = q' and dp = p'. */
#include "massless/damped_start.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "forms/dae.h"
#include "recursion/rank.h"
#include "recursion/spans.h"

#include <mbsrank/newton.h>

#include <math.h>

typedef struct work {
    const mbsr_model *m;
    mbsr_data *d;
    double t;
    int size, rates; /* of y; where its u begins */
    mbsr_newton *newton;
    double *y, *yp;            /* the state; zeros */
    double *F, *r, *x, *other; /* size each */
    void *memory;
} work;

static const double large = 1e8; /* 1/s */
enum { LARGEST_RANK = 600 };

static int open_work(work *w)
{
    mbsr_error error;
    const size_t size = (size_t)w->size;
    w->memory = mbsri_allocate(&w->m->allocator, 6 * size * sizeof(double));
    if (!w->memory) {
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d numbers", w->size);
    }
    double **const vector[] = {&w->y, &w->yp, &w->F, &w->r, &w->x, &w->other};
    for (size_t k = 0; k < 6; ++k) *vector[k] = (double *)w->memory + k * size;
    mbsri_zero(size, w->yp);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.max_rank = LARGEST_RANK; /* a few solutions are worth a large correction */
    const int status = mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, &opt, &w->newton, &error);
    if (status) w->d->error = error;
    return status;
}

static void close_work(work *w)
{
    mbsr_newton_destroy(w->newton);
    mbsri_release(&w->m->allocator, w->memory);
}

static int residual(work *w, double t)
{
    return mbsr_dae_residual(w->m, w->d, MBSR_DAE_MOMENTUM, t, w->y, w->yp, w->F);
}

/* x from r with the factor c. */
static int solve(work *w, double c, const double *r, double *x)
{
    int status = mbsr_newton_factor(w->newton, w->d, w->t, w->y, w->yp, c);
    if (!status) status = mbsr_newton_solve(w->newton, r, x);
    return status;
}

void mbsri_damped_push(const mbsr_model *m, mbsr_data *d, double *force)
{
    mbsri_zero((size_t)m->nu, force);
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (mbsri_group_rank(d, &g) == g.n) continue;
        double *f = d->vec;
        for (int k = 0; k < g.n; ++k) f[k] = 1.0 + 0.5 * sin(12.9898 * (g.ig + k));
        mbsri_null_force(m, d, &g, f, f);
        mbsri_group_scatter(m, &g, f, force);
    }
}

/* Whether all massless rates are damped. */
static int all_damped(work *w, bool *damped)
{
    const int u = w->rates;
    mbsri_zero((size_t)w->size, w->r);
    mbsri_damped_push(w->m, w->d, w->r + u);
    int status = solve(w, large, w->r, w->x);
    if (!status) status = solve(w, 100.0 * large, w->r, w->other);
    if (status) return status;
    const double largest = mbsri_largest(w->size - u, w->other + u);
    *damped = true;
    for (int k = u; k < w->size; ++k) {
        const double now = fabs(w->x[k]), then = fabs(w->other[k]);
        if (then > 5.0 * now && then > 1e-9 * largest) *damped = false;
    }
    return MBSR_OK;
}

/* The largest of the rates u beside their spans. */
static double largest_share(const work *w, const double *u)
{
    const mbsri_spans s = mbsri_spans_of(w->m, NULL);
    double largest = 0.0;
    for (int i = 1; i <= w->m->bodies; ++i) {
        const mbsri_body *b = w->m->body + i;
        for (int k = 0; k < b->n; ++k)
            largest = fmax(largest, fabs(u[b->u + k]) / mbsri_rate_span(&s, w->m, b, k));
    }
    return largest;
}

/* F_u = 0; false where it does not converge. */
static int find_rates(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info,
                      bool *found)
{
    const int u = w->rates, count = w->size - u;
    double last = INFINITY;
    mbsri_zero((size_t)u, w->r);
    *found = false;
    for (int step = 0; step < opt->max_iterations; ++step) {
        int status = residual(w, w->t);
        if (status) return status;
        mbsri_copy((size_t)count, w->F + u, w->r + u);
        status = solve(w, large, w->r, w->x);
        if (status) return status;
        const double change = largest_share(w, w->x + u), size = 1.0 + largest_share(w, w->y + u);
        for (int k = u; k < w->size; ++k) w->y[k] -= w->x[k];
        info->iterations = step + 1;
        *found = change <= opt->tolerance * size || (change > 0.25 * last && change <= 1e-6 * size);
        if (*found) return MBSR_OK;
        last = change;
    }
    return MBSR_OK;
}

/* r_u = -dF_u/dt, where y is held; from one side, at 3 h. */
static int explicit_time(work *w, int side)
{
    const mbsri_spans s = mbsri_spans_of(w->m, NULL);
    const double h = 1e-4 / mbsri_span_rate(&s);
    const int u = w->rates;
    mbsri_zero((size_t)w->size, w->r);
    for (int l = 0; l < 4; ++l) {
        const int status = residual(w, w->t + (mbsri_difference_place(l) + 3.0 * side) * h);
        if (status) return status;
        for (int k = u; k < w->size; ++k)
            w->r[k] -= mbsri_difference_weight(l) / (12.0 * h) * w->F[k];
    }
    return MBSR_OK;
}

/* dq and dp miss q' and p' by the share that decays within 1 / c; the next solution aims so much
 * further. */
static int find_accelerations(work *w, int side, double *udot)
{
    const int u = w->rates;
    int status = explicit_time(w, side);
    if (!status) status = residual(w, w->t);
    if (!status) status = mbsr_newton_factor(w->newton, w->d, w->t, w->y, w->yp, large);
    mbsri_zero((size_t)w->size, w->x);
    double last = INFINITY;
    for (int step = 0; step < 30 && !status; ++step) {
        /* q' and p' are -F where y' = 0 */
        for (int k = 0; k < u; ++k) w->r[k] += large * (-w->F[k] - w->x[k]);
        mbsri_copy((size_t)w->size, w->x, w->other);
        status = mbsr_newton_solve(w->newton, w->r, w->x);
        for (int k = 0; k < w->size; ++k) w->other[k] -= w->x[k];
        const double change = mbsri_largest(w->size - u, w->other + u);
        if (!(change < last) || change <= 1e-14 * mbsri_largest(w->size - u, w->x + u)) break;
        last = change;
    }
    if (!status) mbsri_copy((size_t)(w->size - u), w->x + u, udot);
    return status;
}

int mbsri_damped_start(const mbsr_model *m, mbsr_data *d, double t, const double *q, double *u,
                       double *udot, const mbsr_consistent_opt *opt, mbsr_consistent_info *info,
                       bool *served)
{
    const mbsr_error before = d->error;
    work w = {.m = m, .d = d, .t = t, .size = m->nq + 2 * m->nu, .rates = m->nq + m->nu};
    *served = false;
    int status = open_work(&w);
    mbsr_newton_info newton = {.exact = 0};
    if (!status) mbsr_newton_get_info(w.newton, &newton);
    bool good = !status && newton.exact;
    if (good) status = mbsri_pack(&mbsri_form_momentum, m, d, t, q, u, w.y);
    if (good && !status) status = all_damped(&w, &good);
    if (good && !status) status = find_rates(&w, opt, info, &good);
    if (good && !status) status = find_accelerations(&w, opt->side, udot);
    if (good && !status) {
        mbsri_copy((size_t)m->nu, w.y + w.rates, u);
        *served = true;
    }
    close_work(&w);
    if (*served || (status < 0 && status != MBSR_ERR_SPACE)) return status;
    d->error = before;
    return MBSR_OK;
}
