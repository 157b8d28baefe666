/* Basis vectors freed of each other's large rates: see shorten.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/shorten.h"

#include "algebra/dense.h"
#include "massless/null_lift.h"
#include "recursion/group.h"

#include <float.h>
#include <math.h>

static const double growth_allowed = 32.0; /* of rates behind the joints where a vector begins */

/* Largest rate of vector l at the joints where it begins, velocities compared with angular rates
 * times the typical length. */
static double size_of_head(const mbsri_null_space *w, int l)
{
    const mbsr_model *m = w->m;
    const double *a = w->direction + (size_t)l * (size_t)m->nu;
    const mbsri_group g = mbsri_group_of(m, w->d, w->head[l]);
    double largest = 0.0;
    for (int k = 0; k < g.members; ++k) {
        const mbsri_body *b = m->body + g.member[k];
        for (int c = b->u; c < b->u + b->n; ++c)
            largest = fmax(largest, fabs(a[c]) / w->scale.span[c]);
    }
    return largest;
}

/* How many times as large the largest rate of vector l is, and its place. */
static double growth_of(const mbsri_null_space *w, int l, int *place)
{
    const double *a = w->direction + (size_t)l * (size_t)w->m->nu, head = size_of_head(w, l);
    double largest = 0.0;
    for (int c = 0; c < w->m->nu; ++c) {
        const double size = fabs(a[c]) / w->scale.span[c];
        if (!(size > largest)) continue;
        largest = size;
        *place = c;
    }
    return head > 0.0 ? largest / head : 0.0;
}

/* y (n) -= f x without what may be rounding, or errors where these are known. */
static void subtract(size_t n, double f, const double *x, const double *x_error, double *y,
                     double *y_error)
{
    for (size_t k = 0; k < n; ++k) {
        const double part = f * x[k], rounding = MBSRI_NULL_ROUNDING * (fabs(y[k]) + fabs(part));
        double error = rounding;
        y[k] -= part;
        if (y_error) error = y_error[k] += fabs(f) * x_error[k] + rounding;
        if (fabs(y[k]) <= MBSRI_NULL_CLEAR * error) y[k] = 0.0;
    }
}

/* A -= f (column l in column n, row l in row n), with the errors of A. */
static void subtract_both(int k, int n, int l, double f, double *A, double *error)
{
    for (int side = 0; side < 2; ++side) {
        for (int r = 0; r < k; ++r) {
            const int to = side ? r * k + n : n * k + r, from = side ? r * k + l : l * k + r;
            error[to] += fabs(f) * error[from] + DBL_EPSILON * (fabs(A[to]) + fabs(f * A[from]));
            A[to] -= f * A[from];
        }
    }
}

/* Vector n less f times vector l. */
static void mix(mbsri_null_space *w, int n, int l, double f)
{
    const size_t nu = (size_t)w->m->nu, k = (size_t)w->k, from = (size_t)l, to = (size_t)n;
    subtract(nu, f, w->direction + from * nu, w->lift.rate_error + from * nu,
             w->direction + to * nu, w->lift.rate_error + to * nu);
    subtract(k, f, w->sums.weights + from * k, NULL, w->sums.weights + to * k, NULL);
    subtract_both(w->k, n, l, f, w->C, w->C_error);
    subtract_both(w->k, n, l, f, w->S, w->S_error);
    if (w->sums.head[l] < w->sums.head[n]) w->sums.head[n] = w->sums.head[l];
}

static void start_mixing(mbsri_null_space *w)
{
    const size_t k = (size_t)w->k;
    mbsri_zero(k * k, w->sums.weights);
    for (size_t l = 0; l < k; ++l) w->sums.weights[l * (k + 1)] = 1.0;
    w->sums.on = true;
}

/* Leaves large rates to one vector each. */
static void choose_vectors(mbsri_null_space *w)
{
    const int k = w->k, nu = w->m->nu;
    int *taken = w->element.moving, place = 0;
    w->sums.on = false;
    for (int l = 0; l < k; ++l) taken[l] = growth_of(w, l, &place) <= growth_allowed;
    for (;;) {
        int most = -1, at = 0;
        double largest = growth_allowed;
        for (int l = 0; l < k; ++l) {
            const double growth = taken[l] ? 0.0 : growth_of(w, l, &place);
            if (!(growth > largest)) continue;
            largest = growth;
            most = l;
            at = place;
        }
        if (most < 0) return;
        if (!w->sums.on) start_mixing(w);
        taken[most] = 1;
        const double pivot = w->direction[(size_t)most * (size_t)nu + (size_t)at];
        for (int n = 0; n < k; ++n) {
            double *rate = w->direction + (size_t)n * (size_t)nu + (size_t)at;
            if (n == most || *rate == 0.0) continue;
            mix(w, n, most, *rate / pivot);
            *rate = 0.0;
        }
    }
}

int mbsri_null_shorten(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const size_t nu = (size_t)w->m->nu, nq = (size_t)w->m->nq, k = (size_t)w->k;
    choose_vectors(w);
    int status = w->sums.on ? mbsri_null_lift_again(w, t, q, u) : MBSR_OK;
    for (size_t l = 0; l < k && w->sums.on && !status; ++l)
        status = mbsri_null_rate_here(w, w->direction + l * nu, w->element.q_rate + l * nq);
    return status;
}
