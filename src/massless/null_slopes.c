/* Slopes of the forces in the directions that move no mass: C = d gamma / d u, S = d gamma / d q.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Forces are black boxes, so slopes are central differences. No single step serves all units: a
 * step that is right for a stiff law buries a soft one in the rounding of the forces beside it.
 * Each column is differenced with steps a decade apart, D(h), D(10 h), ...; each entry takes the
 * step with the smallest
 *
 *   error(h) = (rounding of the forces) / h + |D(h) - D(h / 10)|
 *
 * and counts as zero where its size is not ten times that error. */
#include "massless/null_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "massless/null_space.h"
#include "recursion/sizes.h"

#include <math.h>

/* Decades of steps relative to the size of the state, and the last at which a failure counts. */
enum {
    LOW = MBSRI_LOWEST_DECADE,
    Q_HIGH = 1,
    U_HIGH = MBSRI_HIGHEST_DECADE,
    NEAR = MBSRI_NEAR_DECADE
};

/* sizes (k) = max(sizes, the sum of the sizes of the forces that balance in each direction). */
static void force_sizes(mbsri_null_space *w, double *sizes)
{
    mbsri_gross_forces(w->m, w->d);
    for (int l = 0; l < w->k; ++l) {
        const double *vector = w->vector + (size_t)l * (size_t)w->m->max_n;
        const mbsri_group g = mbsri_group_of(w->m, w->d, w->head[l]);
        sizes[l] = fmax(sizes[l], mbsri_gross_load(w->m, w->d, &g, vector));
    }
}

/* slopes[row] = (gamma at q + h rate, u + h a, less gamma at - h) / 2 h, and the sizes of forces
 * there; rate or a may be NULL. */
static int difference(mbsri_null_space *w, double t, const double *q, const double *u,
                      const double *rate, const double *a, double h, int row)
{
    double *slopes = w->slopes + (size_t)row * (size_t)w->k,
           *sizes = w->sizes + (size_t)row * (size_t)w->k;
    mbsri_zero((size_t)w->k, sizes);
    for (int side = 0; side < 2; ++side) {
        const double step = side ? h : -h;
        for (int k = 0; k < w->m->nq; ++k) w->q[k] = q[k] + (rate ? step * rate[k] : 0.0);
        for (int k = 0; k < w->m->nu; ++k) w->u[k] = u[k] + (a ? step * a[k] : 0.0);
        const int status = mbsri_null_gamma(w, t, w->q, w->u, side ? w->ahead : w->behind);
        if (status) return status;
        force_sizes(w, sizes);
    }
    for (int l = 0; l < w->k; ++l) slopes[l] = (w->ahead[l] - w->behind[l]) / (2.0 * h);
    return MBSR_OK;
}

/* Row l of a column from the slopes and force sizes of `decades` steps, the first being `share`:
 * that with the smallest error, or zero. A slope at longer steps that contradicts the one found at
 * shorter ones belongs to another branch of the law, such as a stop not reached. */
static double choose(const mbsri_null_space *w, int l, int decades, double share, double unit)
{
    double best = INFINITY, slope = 0.0, before = 0.0;
    for (int e = 0; e < decades; ++e, share *= 10.0) {
        const int at = e * w->k + l;
        const double now = w->slopes[at], error = mbsri_slope_noise(decades, e, w->k, w->slopes + l,
                                                                    w->sizes[at], share, unit) +
                                                  fabs(now - before);
        if (fabs(now - slope) > 10.0 * best + error) break;
        before = now;
        if (!(error < best)) continue;
        best = error;
        slope = now;
    }
    return fabs(slope) > 10.0 * best ? slope : 0.0;
}

/* One column of C (rate == NULL) or S (a == NULL). A far state at which the model cannot be
 * evaluated ends the search. */
static int search(mbsri_null_space *w, double t, const double *q, const double *u,
                  const double *rate, const double *a, double unit, double *column)
{
    const int high = rate ? Q_HIGH : U_HIGH, k = w->k;
    int decades = 0;
    for (int decade = LOW; decade <= high; ++decade) {
        const mbsr_error reported = w->d->error;
        const int status = difference(w, t, q, u, rate, a, unit * pow(10.0, decade), decades);
        if (status && decade <= NEAR) return status;
        if (status) {
            w->d->error = reported;
            break;
        }
        ++decades;
    }
    for (int l = 0; l < k; ++l) column[l] = choose(w, l, decades, pow(10.0, LOW), unit);
    return MBSR_OK;
}

/* The least multiple of the direction x that changes one of the coordinates y by 1 + its size. */
static double unit_step(int n, const double *x, const double *y)
{
    double unit = INFINITY;
    for (int k = 0; k < n; ++k) unit = fmin(unit, (1.0 + fabs(y[k])) / fabs(x[k]));
    return isfinite(unit) ? unit : 1.0;
}

int mbsri_null_slopes(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    for (int l = 0; l < w->k; ++l) {
        const size_t column = (size_t)l * (size_t)w->k;
        const double *a = w->direction + (size_t)l * (size_t)m->nu;
        int status = search(w, t, q, u, NULL, a, unit_step(m->nu, a, u), w->C + column);
        if (!status) status = mbsri_null_rate(w, t, q, a, w->rate);
        if (status) return status;
        const double unit = unit_step(m->nq, w->rate, q);
        status = search(w, t, q, u, w->rate, NULL, unit, w->S + column);
        if (status) return status;
    }
    return MBSR_OK;
}
