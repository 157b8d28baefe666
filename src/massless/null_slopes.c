/* Slopes of the forces in the directions that move no mass: C = d gamma / d u, S = d gamma / d q.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements with derivatives of their own contribute these (element_slopes.h), in any units and with
 * rounding errors alone; their forces are held where they are while the rest is differenced: other
 * elements and weights, which are black boxes, and the change of the directions. No single step serves all units: a
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
#include "massless/element_slopes.h"
#include "massless/null_space.h"
#include "massless/scales.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
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
static double choose(const mbsri_null_space *w, int l, int decades, double share, double unit,
                     double *error)
{
    double best = INFINITY, slope = 0.0, before = 0.0;
    bool constant = true;
    for (int e = 0; e < decades; ++e, share *= 10.0) {
        const int at = e * w->k + l;
        const double now = w->slopes[at], noise = mbsri_slope_noise(decades, e, w->k, w->slopes + l,
                                                                    w->sizes[at], share, unit) +
                                                  fabs(now - before);
        constant = constant && now == 0.0;
        if (fabs(now - slope) > 10.0 * best + noise) break;
        before = now;
        if (!(noise < best)) continue;
        best = noise;
        slope = now;
    }
    *error = constant ? 0.0 : best;
    return fabs(slope) > 10.0 * best ? slope : 0.0;
}

/* One column of C (rate == NULL) or S (a == NULL) and its errors, of the forces that are not held.
 * A far state at which the model cannot be evaluated ends the search. */
static int search(mbsri_null_space *w, double t, const double *q, const double *u,
                  const double *rate, const double *a, double unit, double *column, double *error)
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
    for (int l = 0; l < k; ++l) column[l] = choose(w, l, decades, pow(10.0, LOW), unit, error + l);
    return MBSR_OK;
}

/* Entries that may be errors are zero. */
static void drop_errors(int count, double *A, const double *error)
{
    for (int k = 0; k < count; ++k) {
        if (fabs(A[k]) <= 10.0 * error[k]) A[k] = 0.0;
    }
}

/* C and S of what is not held: elements without derivatives, weights, the change of directions. */
static int differences(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    int status = MBSR_OK;
    for (int l = 0; l < w->k && !status; ++l) {
        const size_t column = (size_t)l * (size_t)w->k;
        const double *a = w->direction + (size_t)l * (size_t)m->nu,
                     *rate = w->q_rate + (size_t)l * (size_t)m->nq;
        status = search(w, t, q, u, NULL, a, mbsri_unit_step(m->nu, a, u, w->u_scale),
                        w->C + column, w->C_error + column);
        if (status) return status;
        status = search(w, t, q, u, rate, NULL, mbsri_unit_step(m->nq, rate, q, w->q_scale),
                        w->S + column, w->S_error + column);
    }
    return status;
}

int mbsri_null_slopes(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    const int entries = w->k * w->k;
    int status = mbsri_positions(m, w->d, t, q);
    if (!status) status = mbsri_velocities(m, w->d, u);
    if (!status) status = mbsri_forces(m, w->d, NULL);
    if (status) return status;
    if (!(w->size > 0.0)) mbsri_null_scales(w, q, u);
    mbsri_null_clean(w);
    status = mbsri_hold_elements(w);
    for (int l = 0; l < w->k && !status; ++l) {
        status = mbsri_null_rate(w, t, q, w->direction + (size_t)l * (size_t)m->nu,
                                 w->q_rate + (size_t)l * (size_t)m->nq);
    }
    if (status) return status;
    w->holding = true;
    status = differences(w, t, q, u);
    w->holding = false;
    if (!status) status = mbsri_element_slopes(w, t, q, u);
    drop_errors(entries, w->C, w->C_error);
    drop_errors(entries, w->S, w->S_error);
    return status;
}
