/* Slopes of the forces in the directions that move no mass: C = d gamma / d u, S = d gamma / d q.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements with derivatives of their own contribute these (element_slopes.h), in any units and with
 * rounding errors alone; their forces are held where they are while the rest is differenced: other
 * elements and weights, which are black boxes, and the change of the directions. No single step
 * serves all units: a step that is right for a stiff law buries a soft one in the rounding of the
 * forces beside it. Columns of one colour (couplings.h) are differenced together with steps a
 * decade apart, D(h), D(10 h), ...; each entry takes the step with the smallest
 *
 *   error(h) = (rounding of the forces) / h + |D(h) - D(h / 10)|
 *
 * and counts as zero where its size is not ten times that error. */
#include "massless/null_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "forces/gravity.h"
#include "massless/couplings.h"
#include "massless/element_slopes.h"
#include "massless/null_loops.h"
#include "massless/null_space.h"
#include "massless/scales.h"
#include "massless/shorten.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/rounding.h"
#include "recursion/sizes.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Decades of steps relative to the size of the state: from the first, and the last at which a
 * failure counts; the colour of all directions together; how many colours are differenced without
 * asking first whether it is worth while, which is less exact. */
enum { LOW = MBSRI_LOWEST_DECADE, NEAR = MBSRI_NEAR_DECADE, ALL = -1, FEW = 8 };

typedef struct range {
    int low, high;
} range;

/* sizes (k) += the sizes of the forces that balance in each direction, those of loops one by one.
 */
static void add_sizes(mbsri_null_space *w, double *sizes)
{
    mbsri_gross_forces(w->m, w->d);
    for (int l = 0; l < w->k; ++l) sizes[l] += mbsri_null_load(w, l);
    mbsri_null_loop_sizes(w, sizes);
}

/* slopes[row] = (gamma at q + h rate, u + h a, less gamma at - h) / 2 h, and the sizes of forces
 * there; rate or a may be NULL. */
static int difference(mbsri_null_space *w, double t, const double *q, const double *u,
                      const double *rate, const double *a, double h, int row)
{
    double *slopes = w->difference.slopes + (size_t)row * (size_t)w->k,
           *sizes = w->difference.sizes + (size_t)row * (size_t)w->k;
    mbsri_zero((size_t)w->k, sizes);
    for (int side = 0; side < 2; ++side) {
        const double step = side ? h : -h;
        for (int k = 0; k < w->m->nq; ++k) w->q[k] = q[k] + (rate ? step * rate[k] : 0.0);
        for (int k = 0; k < w->m->nu; ++k) w->u[k] = u[k] + (a ? step * a[k] : 0.0);
        const int status =
            mbsri_null_gamma(w, t, w->q, w->u, side ? w->difference.ahead : w->difference.behind);
        if (status) return status;
        add_sizes(w, sizes);
    }
    for (int l = 0; l < w->k; ++l)
        slopes[l] = (w->difference.ahead[l] - w->difference.behind[l]) / (2.0 * h);
    return MBSR_OK;
}

/* Row l of a column from the slopes and force sizes of `decades` steps, the first being `share`:
 * that with the smallest error, or zero. A slope at longer steps that contradicts the one found at
 * shorter ones belongs to another branch of the law, such as a stop not reached. */
static double choose_slope(const mbsri_null_space *w, int l, int decades, double share,
                           double least, double *error)
{
    double best = INFINITY, slope = 0.0, before = 0.0;
    bool constant = true;
    for (int e = 0; e < decades; ++e, share *= 10.0) {
        const int at = e * w->k + l;
        const double now = w->difference.slopes[at],
                     noise = mbsri_slope_noise(decades, e, w->k, w->difference.slopes + l,
                                               w->difference.sizes[at], share, 1.0) +
                             fabs(now - before);
        constant = constant && now == 0.0;
        if (fabs(now - slope) > 10.0 * best + noise) break;
        before = now;
        if (!(noise < best)) continue;
        best = noise;
        slope = now;
    }
    *error = constant ? 0.0 : fmax(best, least);
    return fabs(slope) > 10.0 * *error ? slope : 0.0;
}

/* The step along direction l that changes one of the rates, or positions, by its size. */
static double unit_of(const mbsri_null_space *w, const double *q, const double *u, bool velocity,
                      int l)
{
    const mbsr_model *m = w->m;
    return velocity
               ? mbsri_unit_step(m->nu, w->direction + (size_t)l * (size_t)m->nu, u, w->scale.u)
               : mbsri_unit_step(m->nq, w->element.q_rate + (size_t)l * (size_t)m->nq, q,
                                 w->scale.q);
}

/* Of direction l in the sum of all. */
static double weight_of(int l)
{
    return 1.0 + 0.5 * sin(12.9898 * l);
}

/* x = the directions of one colour, each times its unit, or of all with weights. */
static void displacement(const mbsri_null_space *w, const double *q, const double *u, bool velocity,
                         int colour, double *x)
{
    const int n = velocity ? w->m->nu : w->m->nq;
    mbsri_zero((size_t)n, x);
    for (int l = 0; l < w->k; ++l) {
        if (colour != ALL && w->difference.colour[l] != colour) continue;
        const double *along = (velocity ? w->direction : w->element.q_rate) + (size_t)l * (size_t)n;
        const double share = colour == ALL ? weight_of(l) : 1.0,
                     unit = share * unit_of(w, q, u, velocity, l);
        for (int k = 0; k < n; ++k) x[k] += unit * along[k];
    }
}

/* Slopes over steps a decade apart along the directions of one colour, or all; their number in
 * *decades. A far state at which the model cannot be evaluated ends the search. */
static int search(mbsri_null_space *w, double t, const double *q, const double *u, bool velocity,
                  range decades, int colour, int *found)
{
    double *x = velocity ? w->difference.shift : w->rate;
    *found = 0;
    displacement(w, q, u, velocity, colour, x);
    for (int decade = decades.low; decade <= decades.high; ++decade) {
        const mbsr_error reported = w->d->error;
        const int status = difference(w, t, q, u, velocity ? NULL : x, velocity ? x : NULL,
                                      pow(10.0, decade), *found);
        if (status && decade <= NEAR) return status;
        if (status) {
            w->d->error = reported;
            break;
        }
        ++*found;
    }
    return MBSR_OK;
}

/* Over a unit step, what may be rounding: slopes by position of less than that beside what elements
 * with derivatives make of positions off by typical sizes. So at velocities that balance the
 * rounding of springs nothing turns up that is not there at rest. */
static double least_slope(const mbsri_null_space *w, bool velocity, int l)
{
    return velocity ? 0.0 : DBL_EPSILON * w->element.strain[l];
}

/* The columns of one colour of C (velocity) or S and their errors, of the forces that are not held.
 */
static int find_columns(mbsri_null_space *w, double t, const double *q, const double *u,
                        bool velocity, range decades, int colour)
{
    const int k = w->k;
    double *A = velocity ? w->C : w->S, *error = velocity ? w->C_error : w->S_error;
    int found;
    const int status = search(w, t, q, u, velocity, decades, colour, &found);
    for (int l = 0; l < k && !status; ++l) {
        if (w->difference.colour[l] != colour) continue;
        const double unit = unit_of(w, q, u, velocity, l);
        for (int r = 0; r < k; ++r) {
            const size_t at = (size_t)l * (size_t)k + (size_t)r;
            if (!w->difference.affects[at]) continue;
            A[at] = choose_slope(w, r, found, pow(10.0, decades.low), least_slope(w, velocity, r),
                                 error + at) /
                    unit;
            error[at] /= unit;
        }
    }
    return status;
}

/* Which rows of S are zero, from the slope along the sum of all directions with weights that belong
 * to no pattern: their entries do not affect them any more, but for errors. */
static int drop_rows(mbsri_null_space *w, double t, const double *q, const double *u, range decades)
{
    const int k = w->k;
    int found;
    const int status = search(w, t, q, u, false, decades, ALL, &found);
    if (status) return status;
    for (int r = 0; r < k; ++r) {
        const bool zero = choose_slope(w, r, found, pow(10.0, decades.low),
                                       least_slope(w, false, r), w->difference.ahead + r) == 0.0;
        if (!zero) w->difference.ahead[r] = INFINITY;
    }
    for (int l = 0; l < k; ++l) {
        const double unit = unit_of(w, q, u, false, l);
        for (int r = 0; r < k; ++r) {
            const size_t at = (size_t)l * (size_t)k + (size_t)r;
            if (!w->difference.affects[at] || w->difference.ahead[r] == INFINITY) continue;
            w->difference.affects[at] = false;
            w->S_error[at] = w->difference.ahead[r] / unit;
        }
    }
    return MBSR_OK;
}

/* Whether directions of a colour affect any. */
static bool affects_some(const mbsri_null_space *w, int colour)
{
    const size_t k = (size_t)w->k;
    for (size_t l = 0; l < k; ++l) {
        if (w->difference.colour[l] == colour && memchr(w->difference.affects + l * k, true, k))
            return true;
    }
    return false;
}

/* Entries that may be errors are zero. */
static void drop_errors(int count, double *A, const double *error)
{
    for (int k = 0; k < count; ++k) {
        if (fabs(A[k]) <= 10.0 * error[k]) A[k] = 0.0;
    }
}

/* Which directions C and S have entries for before elements with derivatives add theirs. */
static void note_dense(mbsri_null_space *w)
{
    const int k = w->k;
    for (int side = 0; side < 2; ++side) {
        const double *A = side ? w->S : w->C, *error = side ? w->S_error : w->C_error;
        for (int l = 0; l < k; ++l) w->element.dense[side][l] = false;
        for (int l = 0; l < k; ++l) {
            for (int r = 0; r < k; ++r) {
                if (fabs(A[l * k + r]) > 10.0 * error[l * k + r])
                    w->element.dense[side][l] = w->element.dense[side][r] = true;
            }
        }
    }
    w->element.rows.count = w->element.entries.count = 0;
}

/* Whether what is not held changes as the directions do, with positions alone: not where there are
 * elements without derivatives, but for weights, or gyroscopic forces of what is not a rigid body.
 */
static bool are_smooth(const mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!w->loads.own[k] && !mbsri_is_gravity(&force[k].def)) return false;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const bool matrix = (b->inertia.kind == MBSR_INERTIA_MATRIX && b->inertia.matrix) ||
                            b->inertia.kind == MBSR_INERTIA_FUNCTION ||
                            b->inertia.kind == MBSR_INERTIA_FLEXIBLE;
        if (matrix || b->mass.added) return false;
    }
    return true;
}

bool mbsri_nothing_acts(const mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!w->loads.own[k]) return false;
    }
    const double *const still[] = {w->loads.f, w->d->V, w->d->kI, w->d->kII};
    for (int k = 0; k < 4; ++k) {
        for (size_t r = 0; r < m->size.v; ++r) {
            if (still[k][r] != 0.0) return false;
        }
    }
    return !(mbsri_largest(m->nu, w->loads.tau) > 0.0);
}

/* Loop forces where nothing acts but, perhaps, springs in rows that were given a gap: rounding. */
static void drop_loop_forces(mbsri_null_space *w)
{
    const mbsri_closure *c = w->m->closures.data;
    for (size_t n = 0; n < w->m->closures.count; ++n, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_loose(c, k)) return;
        }
    }
    mbsri_zero((size_t)w->m->rows, w->loads.lambda);
}

/* Whether nothing is left to be differenced. */
static bool is_at_rest(const mbsri_null_space *w)
{
    return mbsri_nothing_acts(w) &&
           !(w->loads.lambda && mbsri_largest(w->m->rows, w->loads.lambda) > 0.0);
}

/* C and S of what is not held: elements without derivatives, weights, the change of directions. */
static int differences(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const size_t entries = (size_t)w->k * (size_t)w->k;
    static const range positions = {LOW, 1}, rates = {LOW, MBSRI_HIGHEST_DECADE}, near = {-6, -1};
    const bool smooth = are_smooth(w);
    int status = MBSR_OK;
    double *const all[] = {w->C, w->S, w->C_error, w->S_error};
    for (int k = 0; k < 4; ++k) mbsri_zero(entries, all[k]);
    if (smooth && is_at_rest(w)) return MBSR_OK;
    if (smooth && w->difference.colours > FEW) status = drop_rows(w, t, q, u, near);
    for (int colour = 0; colour < w->difference.colours && !status; ++colour) {
        if (!smooth) status = find_columns(w, t, q, u, true, rates, colour);
        if (!status && affects_some(w, colour))
            status = find_columns(w, t, q, u, false, smooth ? near : positions, colour);
    }
    return status;
}

static int state(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const int status = mbsri_positions(w->m, w->d, t, q);
    return status ? status : mbsri_velocities(w->m, w->d, u);
}

int mbsri_null_slopes(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    int status = state(w, t, q, u);
    if (!status) status = mbsri_forces(m, w->d, NULL, NULL);
    if (status || w->k == 0) return status;
    if (!(w->size > 0.0)) {
        double natural;
        mbsri_null_scales(w, q, u);
        status = mbsri_element_rate(w, &natural);
        if (status) return status;
        mbsri_null_rate_scales(w, natural);
    }
    w->loads.lever = fmax(w->size, mbsri_longest_lever(m, w->d));
    status = mbsri_hold_elements(w);
    if (!status && w->loads.lambda && mbsri_nothing_acts(w)) drop_loop_forces(w);
    for (int l = 0; l < w->k && !status; ++l) {
        status = mbsri_null_rate_here(w, w->direction + (size_t)l * (size_t)m->nu,
                                      w->element.q_rate + (size_t)l * (size_t)m->nq);
    }
    if (status) return status;
    mbsri_null_couple(w);
    w->loads.on = true;
    status = differences(w, t, q, u);
    w->loads.on = false;
    if (!status) status = mbsri_null_shorten(w, t, q, u);
    mbsri_null_remix(w, true, w->element.strain);
    if (!status && w->loads.lambda) {
        status = state(w, t, q, u);
        if (!status) status = mbsri_null_leave_held(w);
    }
    mbsri_null_extents(w);
    note_dense(w);
    if (!status) status = mbsri_element_slopes(w, t, q, u);
    if (!status && w->loads.lambda) status = mbsri_null_stiff_rows(w);
    drop_errors(w->k * w->k, w->C, w->C_error);
    drop_errors(w->k * w->k, w->S, w->S_error);
    return status;
}
