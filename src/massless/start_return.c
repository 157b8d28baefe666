/* Ways back of a consistent start: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Springs balance at many positions, as dampers give way to any; the one that is looked for differs
 * from that given by a displacement along directions that springs alone hold, as they are there. So
 * it depends on no path. With z, the displacement that is left to the state given, and P = sum of
 * J^T M (displacement) of the masses,
 *
 *   K(c) x = (0, c P, F_u,u z, 0, 0), c -> infinity:  q += G a
 *
 * a does to masses and to dampers what the way back does. */
#include "massless/start_return.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "recursion/kinematics.h"

#include <math.h>

static int report_failure(mbsr_completion *w, int status)
{
    if (status) w->error = w->d->error;
    return status;
}

/* q += G x at the positions q, in place. */
static int move_along(mbsri_start *s, double *q, const double *x)
{
    mbsr_completion *w = s->w;
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, x);
    if (!status) status = mbsri_coordinate_rates(w->m, w->d, w->form.q);
    for (int k = 0; k < w->m->nq; ++k) q[k] += w->form.q[k];
    if (!status) status = mbsri_normalise(w->m, w->d, q);
    return report_failure(w, status);
}

/* What momenta the masses need to be where they were, into s->missing. */
static int miss_masses(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, w->t, w->y);
    mbsri_zero((size_t)m->nu, w->form.u);
    if (!status) status = mbsri_velocities(m, w->d, w->form.u);
    if (status) return report_failure(w, status);
    mbsri_masses_displacement(m, w->d, &s->masses, w->y, s->missing);
    return MBSR_OK;
}

int mbsri_start_return_masses(mbsri_start *s)
{
    static const double nothing = 1e-15;
    mbsr_completion *w = s->w;
    int status = miss_masses(s);
    if (status) return status;
    mbsri_zero((size_t)w->size, w->r);
    status = mbsri_start_solve(s, s->missing);
    if (status || mbsri_completion_speed(w, w->x + w->rates) <= nothing) return status;
    return move_along(s, w->y, w->x + w->rates);
}

/* x = (L L^T)^-1 x. */
static void solve_by_cholesky(int n, const double *L, double *x)
{
    mbsri_divide_by_cholesky(1, n, L, x);
    for (int k = n - 1; k >= 0; --k) {
        for (int l = k + 1; l < n; ++l) x[k] -= L[k * n + l] * x[l];
        x[k] /= L[k * n + k];
    }
}

/* z (n) with G z closest to dq, in joint i at the positions of the data. */
static int rates_towards(mbsri_start *s, int i, const double *dq, double *z)
{
    mbsr_data *d = s->w->d;
    const mbsri_body *b = s->w->m->body + i;
    double *u = d->u + b->iu, *G = s->columns, *A = G + b->nq * b->n;
    int status = MBSR_OK;
    if (!b->joint.table->coordinate_rates) {
        mbsri_copy((size_t)b->n, dq, z);
        return MBSR_OK;
    }
    for (int k = 0; k < b->n && !status; ++k) {
        for (int l = 0; l < b->n; ++l) u[l] = l == k ? 1.0 : 0.0;
        status = mbsri_coordinate_rates_of(s->w->m, d, i, G + k * b->nq);
    }
    for (int k = 0; k < b->n; ++k) {
        z[k] = mbsri_dot(b->nq, G + k * b->nq, dq);
        for (int l = 0; l < b->n; ++l)
            A[k * b->n + l] = mbsri_dot(b->nq, G + k * b->nq, G + l * b->nq);
    }
    if (!status && mbsri_cholesky(b->n, A)) solve_by_cholesky(b->n, A, z);
    return status;
}

/* The displacement from w->y to the state given, into w->u. */
static int find_way(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, w->t, w->y);
    mbsri_zero((size_t)m->nu, w->form.u);
    if (!status) status = mbsri_velocities(m, w->d, w->form.u);
    for (int k = 0; k < m->nq; ++k) w->form.q[k] = s->given.q[k] - w->y[k];
    for (int i = 1; i <= m->bodies && !status; ++i) {
        const mbsri_body *b = m->body + i;
        status = rates_towards(s, i, w->form.q + b->q, w->form.u + b->u);
    }
    return report_failure(w, status);
}

/* F_u,u z of balances of forces, z = w->u, into the rows of u of w->r: by two states beside w->y,
 * which is as it was afterwards. */
static int differ(mbsri_start *s)
{
    static const double short_way = 1e-4;
    mbsr_completion *w = s->w;
    const size_t nu = (size_t)w->m->nu;
    double *u = w->y + w->rates, *here = s->before, *z = s->step;
    const double step = short_way / (mbsri_completion_speed(w, w->form.u) * s->time);
    int status = MBSR_OK;
    if (!isfinite(step)) return MBSR_OK;
    mbsri_copy((size_t)w->size, w->y, here);
    mbsri_copy(nu, w->form.u, z);
    for (int side = -1; side <= 1 && !status; side += 2) {
        for (size_t k = 0; k < nu; ++k) u[k] = here[(size_t)w->rates + k] + side * step * z[k];
        status = mbsri_start_evaluate(s, true);
        for (size_t k = 0; k < nu; ++k) {
            if (s->lacks[k])
                w->r[(size_t)w->rates + k] += side * w->F[(size_t)w->rates + k] / (2.0 * step);
        }
    }
    mbsri_copy((size_t)w->size, here, w->y);
    return status;
}

/* Weights of differences of ways, `count` of them, that take most off the newest way; fewer where
 * these depend on each other. */
static void weigh_ways(const mbsri_start *s, int count, double *weight)
{
    const double *per_span = s->w->span.per, *way = s->ways;
    const int nu = s->w->m->nu;
    double A[MBSRI_WAYS * MBSRI_WAYS] = {0.0};
    for (int i = 0; i < count; ++i) {
        weight[i] = 0.0;
        for (int k = 0; k < nu; ++k) {
            const double d = (way[i * nu + k] - way[(i + 1) * nu + k]) * per_span[k];
            weight[i] += d * way[k] * per_span[k];
            for (int j = 0; j < count; ++j)
                A[j * count + i] += d * (way[j * nu + k] - way[(j + 1) * nu + k]) * per_span[k];
        }
        A[i * count + i] *= 1.0 + 1e-12;
    }
    if (count > 0 && mbsri_cholesky(count, A)) {
        solve_by_cholesky(count, A, weight);
    } else {
        for (int i = 0; i < count; ++i) weight[i] = 0.0;
    }
}

/* Anderson's step: the newest way less what made the last ones shorter. */
static void shorten_way(mbsri_start *s, int count, double *step)
{
    const size_t nu = (size_t)s->w->m->nu;
    const double *way = s->ways, *rest = s->ways + MBSRI_WAYS * nu;
    double weight[MBSRI_WAYS];
    weigh_ways(s, count, weight);
    mbsri_copy(nu, way, step);
    for (size_t i = 0; i < (size_t)count; ++i) {
        for (size_t k = 0; k < nu; ++k) {
            const size_t now = i * nu + k, before = now + nu;
            step[k] -= weight[i] * (way[now] - way[before] + rest[before] - rest[now]);
        }
    }
}

/* Makes room for the newest of the ways, or of what was left to the state given. */
static void push_way(size_t nu, const double *x, double *ways)
{
    for (size_t k = (MBSRI_WAYS - 1) * nu; k-- > 0;) ways[nu + k] = ways[k];
    mbsri_copy(nu, x, ways);
}

int mbsri_start_return(mbsri_start *s, int number, double *way)
{
    mbsr_completion *w = s->w;
    const size_t nu = (size_t)w->m->nu;
    static const double far = 3.0; /* beside what a way is itself */
    const int count = number < MBSRI_WAYS ? number : MBSRI_WAYS - 1;
    *way = 0.0;
    int status = find_way(s);
    mbsri_zero((size_t)w->size, w->r);
    if (!status) push_way(nu, w->form.u, s->ways + MBSRI_WAYS * nu);
    if (!status) status = differ(s);
    if (!status) status = miss_masses(s);
    if (!status) status = mbsri_start_solve(s, s->missing);
    if (status) return status;
    push_way(nu, w->x + w->rates, s->ways);
    *way = mbsri_completion_speed(w, w->x + w->rates);
    shorten_way(s, count, s->step);
    const double longest = mbsri_completion_speed(w, s->step), most = far * *way;
    for (size_t k = 0; k < nu && longest > most; ++k) s->step[k] *= most / longest;
    return move_along(s, w->y, s->step);
}
