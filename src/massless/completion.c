/* Completing a state: see completion.h of the public headers.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * K(c) = dF/dy + c dF/dy' of the momentum form, r = (r_q, r_p, r_u, r_Lambda, r_Eta). As c grows, x = K(c)^-1 r has for
 * r_q = r_p = 0
 *
 *   x_q, x_p -> 0 in trees; with loops what closes them in the weights w, and impulses C^T I
 *   x_u -> the correction of velocities,     c x_Lambda -> that of loop forces, and c I
 *
 * so that Newton's method with r = (0, 0, F_u, F_Lambda, F_Eta) settles u at given q and p. The rates follow from
 * F = 0 differentiated, K(c) y' = c dF/dy' y' - dF/dt in the rows of algebraic equations. In the others r = c q' and c p', with what is
 * known of them, gives x_q and x_p that miss q' and p' by a share of 1/c, and the next solution aims so much further. What x_Lambda
 * finds is missing in the loop forces, which p' was found with.
 *
 * Rates of trees all of whose directions move mass are those of forward dynamics. */
#include "massless/completion_elastic.h"
#include "massless/completion_matrix.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "forms/loops.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/loops.h>

#include <float.h>
#include <math.h>

/* c in the time in which the state changes much, one after the other until one serves: beyond all that is stiff, but not so
 * far that springs which alone hold something are drowned. */
static const double ladder[] = {1e6, 1e9, 1e4, 1e12};
enum { RUNGS = sizeof ladder / sizeof ladder[0] };

/* ---- creation ---- */

/* Memory for all vectors in one block, and the dense matrix where there is no Newton solver. */
static bool allocate(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const size_t size = (size_t)w->size, nq = (size_t)m->nq, nu = (size_t)m->nu,
                 dense = w->newton ? 0 : size;
    double **const vector[] = {&w->y,          &w->yp,      &w->F,          &w->r,     &w->x,
                               &w->other,      &w->rate,    &w->time,       &w->given, &w->ahead,
                               &w->ahead_rate, &w->further, &w->force_rate, &w->q,     &w->u,
                               &w->tau,        &w->inverse, &w->work};
    const size_t rows = (size_t)m->rows;
    const size_t length[] = {size, size, size, size, size, size, size, size,         size + rows,
                             size, size, size, rows, nq,   nu,   nu,   dense * size, 4 * dense};
    enum { VECTORS = sizeof length / sizeof length[0] };
    size_t total = 1;
    for (int k = 0; k < VECTORS; ++k) total += length[k];
    const size_t bytes = total * sizeof(double) + dense * sizeof(int);
    w->memory = mbsri_allocate(&m->allocator, bytes);
    if (!w->memory) return false;
    w->info.bytes = sizeof *w + bytes;
    double *next = w->memory;
    mbsri_zero(total, next);
    for (int k = 0; k < VECTORS; ++k) {
        *vector[k] = next;
        next += length[k];
    }
    w->pivots = (int *)(void *)next;
    return true;
}

/* Beyond this rank of elements across the tree (newton.h) a dense matrix is no worse. */
enum { LARGEST_RANK = 600 };

/* Its Newton solver, exact; none where there is no such. */
static int make_newton(mbsr_completion *w, const mbsr_newton_opt *opt, mbsr_error *error)
{
    mbsr_newton_opt own = opt ? *opt : mbsr_default_newton_opt();
    mbsr_newton_info info = {.exact = 0};
    mbsr_error refusal;
    own.method = MBSR_NEWTON_AUTO;
    own.max_rank = LARGEST_RANK;
    own.products = 0;
    const int status = mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, &own, &w->newton, &refusal);
    if (status == MBSR_ERR_SPACE || status == MBSR_ERR_LEAN) return MBSR_OK;
    if (status && error) *error = refusal;
    if (status) return status;
    mbsr_newton_get_info(w->newton, &info);
    w->info.bytes += info.bytes;
    if (info.exact) return MBSR_OK;
    mbsr_newton_destroy(w->newton);
    w->newton = NULL;
    return MBSR_OK;
}

int mbsr_completion_create(const mbsr_model *model, const mbsr_newton_opt *opt,
                           mbsr_completion **completion, mbsr_error *error)
{
    static const char name[] = "mbsr_completion_create";
    if (completion) *completion = NULL;
    if (!model || !completion) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          model ? "completion" : "model");
    }
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    }
    mbsr_completion *w = mbsri_allocate(&model->allocator, sizeof *w);
    if (!w) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", name);
    }
    const int rates = model->nq + model->nu, loops = rates + model->nu;
    *w = (mbsr_completion){.m = model,
                           .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""},
                           .times = {0.0, -INFINITY, INFINITY},
                           .size = loops + model->rows + model->held,
                           .rates = rates,
                           .loops = loops,
                           .places = loops + model->rows};
    int status = make_newton(w, opt, error);
    if (!status && !allocate(w)) {
        status = mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                            "%s: no memory for %d numbers", name, w->size);
    }
    if (status) {
        mbsr_completion_destroy(w);
        return status;
    }
    *completion = w;
    return MBSR_OK;
}

void mbsr_completion_destroy(mbsr_completion *completion)
{
    if (!completion) return;
    const mbsr_allocator allocator = completion->m->allocator;
    mbsr_newton_destroy(completion->newton);
    mbsri_release(&allocator, completion->memory);
    mbsri_release(&allocator, completion);
}

/* ---- questions ---- */

int mbsr_completion_set_times(mbsr_completion *completion, const mbsr_completion_times *times)
{
    mbsr_completion *w = completion;
    if (!w || !times) return MBSR_ERR_NULL;
    if (times->scale >= 0.0 && isfinite(times->scale) && times->from < times->to) {
        w->times = *times;
        return MBSR_OK;
    }
    return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "mbsr_completion_set_times: scale is %g, from %g to %g", times->scale,
                      times->from, times->to);
}

int mbsr_completion_get_info(const mbsr_completion *completion, mbsr_completion_info *info)
{
    if (!completion || !info) return MBSR_ERR_NULL;
    *info = completion->info;
    return MBSR_OK;
}

const mbsr_error *mbsr_completion_error(const mbsr_completion *completion)
{
    static const mbsr_error null = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "completion is NULL"};
    return completion ? &completion->error : &null;
}

/* ---- velocities ---- */

static int here(mbsr_completion *w)
{
    return mbsri_completion_residual(w, w->t, w->y, w->yp);
}

/* y less x, as far as it is to be settled, loop forces by c x; the size of the correction beside that of velocities, and of
 * forces where these hold what has no mass. Elsewhere they follow from accelerations. */
static double take_off(mbsr_completion *w, double c)
{
    const mbsr_model *m = w->m;
    const double speed = 1e-3 * mbsri_span_rate(&(mbsri_spans){.rate = m->frequency}) +
                         mbsri_completion_speed(w, w->y + w->rates);
    const int first = m->rows > 0 ? 0 : w->rates;
    double force = mbsri_largest(m->nu, w->F + m->nq), change = 0.0;
    for (int k = first; k < w->loops; ++k) w->y[k] -= w->x[k];
    const mbsri_closure *closure = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            w->yp[at] -= c * w->x[at];
            if (mbsri_is_stiff(closure, k)) continue;
            change = fmax(change, fabs(c * w->x[at]));
            force = fmax(force, fabs(w->yp[at]));
        }
    }
    change = w->deficient && change > 0.0 ? change / force : 0.0;
    return fmax(change, mbsri_completion_speed(w, w->x + w->rates) / speed);
}

/* x from r, without what springs alone hold; `fresh`: the matrix at hand will do. */
static int correct(mbsr_completion *w, double c, bool fresh)
{
    if (w->elastic) {
        const int status = mbsri_completion_split(w, c, w->r);
        for (int k = w->loops; k < w->size; ++k) w->x[k] = w->other[k] / c;
        return status;
    }
    const int status = fresh ? MBSR_OK : mbsri_completion_factor(w, c);
    return status ? status : mbsri_completion_solve(w, w->r, w->x);
}

/* Whether corrections of these sizes, relative to what is corrected, are followed by none that counts. */
static bool converged(double change, double last, double enough, double near)
{
    if (change <= enough || last == INFINITY) return change <= enough;
    return change * (change / last) <= enough || (change > 0.25 * last && change <= near);
}

/* Beyond c where loops are closed, so that of x_p little but impulses is left. */
static const double settles = 1e2;

/* u and loop forces at the positions and momenta of w->y, with the residual there. */
static int settle(mbsr_completion *w, double least_c)
{
    enum { MOST = 30 };
    static const double enough = 1e-12, old = 0.03;
    const double near = w->m->rows > 0 ? 1e-6 : 1e-8;
    const double c = w->m->rows > 0 && !w->elastic ? settles * least_c : least_c;
    double last = INFINITY;
    bool fresh = w->factored == c;
    for (int step = 0; step < MOST; ++step) {
        mbsri_zero((size_t)w->rates, w->r);
        mbsri_copy((size_t)(w->size - w->rates), w->F + w->rates, w->r + w->rates);
        int status = correct(w, c, fresh);
        if (status) return status;
        const double change = take_off(w, c);
        if (w->m->rows > 0) status = mbsri_normalise(w->m, w->d, w->y);
        if (!status) status = here(w);
        if (status || converged(change, last, enough, near)) return status;
        fresh = change <= old * last;
        last = change;
    }
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "velocities without mass were not found: Newton's method does not "
                                 "converge");
}

/* ---- rates ---- */

/* A quotient of differences in time: places in steps h, weights over h. */
typedef struct quotient {
    int points;
    double h, place[4], weight[4];
} quotient;

/* Central where that fits into the span allowed, else on the longer side. Short, since third derivatives jump at the points of
 * a spline, which outputs are likely to be at. */
static quotient choose_quotient(const mbsr_completion *w)
{
    const double ahead = w->times.to - w->t, behind = w->t - w->times.from,
                 time = mbsri_completion_time(w), side = ahead > behind ? 1.0 : -1.0;
    quotient made = {.points = 2,
                     .h = mbsri_binary(fmax(1e-7 * time, 1e-9 * fabs(w->t))),
                     .place = {1.0, -1.0},
                     .weight = {0.5, -0.5}};
    if (fmin(ahead, behind) >= made.h) return made;
    made.points = 4;
    made.h = fmin(1e-4 * time, 0.19 * fmax(ahead, behind));
    for (int l = 0; l < 4; ++l) {
        made.place[l] = mbsri_difference_place(l) + 3.0 * side;
        made.weight[l] = mbsri_difference_weight(l) / 12.0;
    }
    return made;
}

/* w->time += weight F, minus what stands in w->other; whether F differs from that. */
static bool add_difference(mbsr_completion *w, double weight)
{
    bool differs = false;
    for (int k = w->rates; k < w->size; ++k) {
        w->time[k] -= weight * (w->F[k] - w->other[k]);
        differs = differs || w->F[k] != w->other[k];
    }
    return differs;
}

/* The part of a change of s by s', of which F is a linear function. */
static int differ_in_springs(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const double step = mbsri_completion_time(w);
    const mbsri_closure *closure = m->closures.data;
    bool any = false;
    mbsri_copy((size_t)w->size, w->y, w->ahead);
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k)) continue;
            w->ahead[at] += step * w->yp[at];
            any = true;
        }
    }
    if (!any) return MBSR_OK;
    const int status = mbsri_completion_residual(w, w->t, w->ahead, w->yp);
    add_difference(w, 1.0 / step);
    return status;
}

/* Minus the rate of F in the algebraic equations, y and y' being held but for the forces s of stiff rows, whose s' is known;
 * F is that at y afterwards. Where a step in time changes nothing, nothing depends on it. */
static int differ_in_time(mbsr_completion *w)
{
    const quotient by = choose_quotient(w);
    bool changes = true;
    mbsri_copy((size_t)w->size, w->F, w->other);
    mbsri_zero((size_t)w->size, w->time);
    int status = differ_in_springs(w);
    for (int l = 0; l < by.points && !status && changes; ++l) {
        status = mbsri_completion_residual(w, w->t + by.place[l] * by.h, w->y, w->yp);
        const bool differs = add_difference(w, by.weight[l] / by.h);
        changes = differs || l > 0;
    }
    mbsri_copy((size_t)w->size, w->other, w->F);
    return status;
}

/* q' and p' with the loop forces in w->yp, from F at y' = 0. */
static void known_rates(const mbsr_completion *w, double *rate)
{
    const mbsr_model *m = w->m;
    for (int k = 0; k < w->rates; ++k) rate[k] = -w->F[k];
    for (int k = 0; k < m->nu; ++k) rate[m->nq + k] += w->tau[k];
}

/* Loop forces += x of rigid rows; the largest change, beside all forces. */
static double add_forces(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *closure = m->closures.data;
    double change = 0.0, size = mbsri_largest(m->nu, w->rate + m->nq);
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k)) {
                change = fmax(change, fabs(w->x[at]));
                w->yp[at] += w->x[at];
            }
            size = fmax(size, fabs(w->yp[at]));
        }
    }
    return change > 0.0 ? change / size : 0.0;
}

/* One solution for each of `count` matrices c_j, from r_j; those of one alone are kept in w->newton. */
static int solve_each(mbsr_completion *w, int count, const double *c, double *const *r,
                      double *const *x, bool first)
{
    int status = MBSR_OK;
    for (int j = 0; j < count && !status; ++j) {
        if (first || count > 1) status = mbsri_completion_factor(w, c[j]);
        if (!status) status = mbsri_completion_solve(w, r[j], x[j]);
    }
    return status;
}

/* x[0] becomes the limit of the solutions as c grows: of velocities without those of elastic directions, which grow
 * with it. What it has been taken off is the size of the part that decays. */
static double join(const mbsr_completion *w, const double *c, double *const *x)
{
    const double slope = 1.0 / (c[1] - c[0]), size = mbsri_completion_speed(w, x[1] + w->rates);
    double *u[2] = {x[0] + w->rates, x[1] + w->rates};
    for (int k = w->loops; k < w->places; ++k) x[0][k] = slope * (c[1] * x[1][k] - c[0] * x[0][k]);
    for (int k = 0; k < w->m->nu; ++k) {
        const double first = u[0][k];
        if (w->elastic) {
            u[0][k] -= slope * c[0] * (u[1][k] - first);
        } else {
            u[0][k] = slope * (c[1] * u[1][k] - c[0] * first);
            u[1][k] -= u[0][k];
        }
    }
    return w->elastic || !(size > 0.0) ? 0.0 : mbsri_completion_speed(w, u[1]) / size;
}

/* Takes up u' and loop forces of x; the size of what changes. */
static double take_up(mbsr_completion *w, const double *x)
{
    const int nu = w->m->nu;
    const double time = mbsri_completion_time(w);
    double *udot = w->rate + w->rates;
    for (int k = 0; k < nu; ++k) udot[k] -= x[w->rates + k];
    const double change = mbsri_completion_speed(w, udot);
    mbsri_copy((size_t)nu, x + w->rates, udot);
    const double size = mbsri_completion_speed(w, udot) + 1e-3 / (time * time);
    return fmax(change / size, add_forces(w));
}

static int too_fast(mbsr_completion *w)
{
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "accelerations were not found: something stiff is far faster than "
                                 "the motion");
}

/* u' into w->rate, loop forces into w->yp, by Newton systems at the state. Without loops, and where springs alone hold
 * directions, solutions aim further until x_q and x_p are the rates. Positions that loops hold let x_q be no other: two
 * solutions tell the part that decays as c grows. */
static int solve_rates(mbsr_completion *w, double least_c)
{
    enum { MOST = 40 };
    static const double enough = 1e-12, near = 1e-6, decays = 1e-3;
    const bool aims = w->elastic || w->m->rows == 0;
    const int count = w->elastic || !aims ? 2 : 1;
    const double c[2] = {least_c, MBSRI_COMPLETION_RATIO * least_c};
    double *const r[2] = {w->r, w->further}, *const x[2] = {w->x, w->other};
    double *before = w->ahead, *first = w->time, last = INFINITY;
    int status = differ_in_time(w);
    known_rates(w, w->rate);
    mbsri_zero((size_t)w->m->nu, w->rate + w->rates);
    for (int j = 0; j < count; ++j) {
        mbsri_copy((size_t)w->size, w->time, r[j]);
        for (int k = 0; k < w->rates; ++k) r[j][k] = c[j] * w->rate[k];
    }
    for (int step = 0; step < MOST && !status; ++step) {
        status = solve_each(w, count, c, r, x, step == 0);
        if (status) return status;
        mbsri_copy((size_t)w->size, x[0], first);
        const double decay = count > 1 ? join(w, c, x) : 0.0, change = take_up(w, x[0]);
        mbsri_copy((size_t)w->size, w->rate, before);
        if (w->m->rows > 0) status = here(w);
        known_rates(w, w->rate);
        if (decay > decays) return too_fast(w);
        if (status || (step > 0 && converged(change, last, enough, near))) return status;
        if (step > 3 && change > 0.5 * last) break;
        last = change;
        for (int j = 0; j < count; ++j) {
            const double *solution = j == 0 ? first : x[1];
            for (int k = 0; k < w->rates; ++k) {
                const double more = w->rate[k] - before[k];
                r[j][k] += c[j] * (aims ? more + w->rate[k] - solution[k] : more);
            }
        }
    }
    return status ? status : too_fast(w);
}

/* Whether some rows are left to others. */
static bool leaves_rows(const mbsr_completion *w)
{
    for (int k = 0; k < w->m->rows; ++k) {
        if (w->d->dropped[k]) return true;
    }
    return false;
}

/* Loop forces of rigid rows that exert what w->other (rows) exerts, without those rows that are left to others:
 * K(c) x = (0, c C^T lambda, 0) has x_p = 0 and x_Lambda = -lambda where all directions move mass. */
static int share_forces(mbsr_completion *w, double c)
{
    const mbsr_model *m = w->m;
    if (!leaves_rows(w)) return MBSR_OK;
    int status = mbsr_closures_transpose(m, w->d, w->other, w->ahead);
    if (status) w->error = *mbsr_data_error(w->d);
    mbsri_zero((size_t)w->size, w->r);
    for (int k = 0; k < m->nu; ++k) w->r[m->nq + k] = c * w->ahead[k];
    if (!status) status = mbsri_completion_factor(w, c);
    if (!status) status = mbsri_completion_solve(w, w->r, w->x);
    for (int k = 0; k < m->rows && !status; ++k) w->other[k] = -w->x[w->loops + k];
    return status;
}

/* u' and loop forces by forward dynamics; MBSR_UNDETERMINED where there are directions that nothing with mass nor a
 * rigid row determines. */
static int accelerate(mbsr_completion *w, double c)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *closure = m->closures.data;
    double *lambda = w->other;
    int status =
        mbsr_forward_dynamics(m, w->d, w->t, w->y, w->y + w->rates, w->tau, w->rate + w->rates);
    if (!status && m->rows > 0) status = mbsr_closures_force(m, w->d, lambda);
    if (status) w->error = *mbsr_data_error(w->d);
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            if (mbsri_is_stiff(closure, k)) lambda[closure->row + k] = 0.0;
        }
    }
    if (!status) status = share_forces(w, c);
    closure = m->closures.data;
    for (size_t id = 0; id < m->closures.count && !status; ++id, ++closure) {
        for (int k = closure->row; k < closure->row + closure->rows; ++k) {
            if (!mbsri_is_stiff(closure, k - closure->row)) w->yp[w->loops + k] = lambda[k];
        }
    }
    if (!status && m->rows > 0) status = here(w);
    known_rates(w, w->rate);
    return status;
}

/* All of w->rate. */
static int find_rates(mbsr_completion *w, double c)
{
    if (!w->deficient || (w->m->rows > 0 && !leaves_rows(w))) {
        int status = accelerate(w, c);
        if (status != MBSR_UNDETERMINED) return status;
        status = here(w);
        if (status) return status;
    }
    const int status = solve_rates(w, c);
    return !status && w->elastic ? mbsri_completion_bend(w, c) : status;
}

/* ---- states ---- */

static int find_velocities(mbsr_completion *w, double c)
{
    enum { PASSES = 6 };
    int status = settle(w, c);
    double last = INFINITY;
    for (int pass = 0; pass < PASSES && w->elastic && !status; ++pass) {
        double change = 0.0;
        status = mbsri_completion_drift(w, c, &change);
        if (!status) status = settle(w, c);
        if (!(change < 0.5 * last)) break;
        last = change;
    }
    return status;
}

/* u and all rates from w->y, whose residual is known, and loop forces in w->yp. */
static int attempt(mbsr_completion *w, double c, bool velocities)
{
    const int status = velocities ? find_velocities(w, c) : MBSR_OK;
    return status ? status : find_rates(w, c);
}

/* The same with one c after the other; the failure that counts is the first, but for singular matrices: far out they are so
 * because something soft is drowned. From w->given, with loop forces behind it. */
static int search(mbsr_completion *w, bool velocities)
{
    const size_t size = (size_t)w->size, rows = (size_t)w->m->rows;
    mbsr_error first = {.status = MBSR_OK};
    mbsri_copy(size, w->given, w->y);
    const double time = mbsri_completion_time(w);
    for (int step = 0; step < RUNGS; ++step) {
        const double c = ladder[step] / time;
        mbsri_copy(size, w->given, w->y);
        mbsri_zero(size, w->yp);
        mbsri_copy(rows, w->given + size, w->yp + w->loops);
        int status = here(w);
        if (status) return status;
        w->deficient = mbsr_total_rank(w->m, w->d) < w->m->nu;
        w->elastic = false;
        w->factored = 0.0;
        if (w->deficient) status = mbsri_completion_find_elastic(w, c);
        if (!status) status = attempt(w, c, velocities);
        if (status <= 0) return status;
        if (first.status == MBSR_OK || first.status == MBSR_SINGULAR_BLOCK) first = w->error;
        first.status = first.status == MBSR_OK ? status : first.status;
    }
    w->error = first;
    return first.status;
}

/* ---- the calls ---- */

static int refuse(mbsr_completion *w, int status)
{
    w->error = *mbsr_data_error(w->d);
    return status;
}

/* What all calls begin with. */
static int enter(mbsr_completion *w, mbsr_data *d, double t, bool arguments, const char *function)
{
    if (!w) return MBSR_ERR_NULL;
    if (!d || !arguments) {
        return mbsri_fail(&w->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    }
    w->d = d;
    w->t = t;
    int status = mbsri_enter(w->m, d, true, MBSRI_STAGE_NONE, function);
    if (!status) status = mbsri_check_input(d, 1, &t, function, "t");
    mbsri_zero((size_t)w->m->nu, w->tau);
    return status ? refuse(w, status) : MBSR_OK;
}

/* The data is at the accelerations found; the stages run when somebody asks. */
static void leave(const mbsr_completion *w, mbsr_data *d)
{
    const mbsr_model *m = w->m;
    if (d->lean) return;
    d->stage = MBSRI_STAGE_NONE;
    d->t = w->t;
    d->accelerated = false;
    mbsri_remember(m, d, MBSRI_PENDING_MOTION, w->y, w->y + w->rates, w->tau);
    mbsri_copy((size_t)m->nu, w->rate + w->rates, d->udot_last);
    if (m->rows > 0) mbsri_loops_take(m, d, w->y + w->loops, w->yp + w->loops);
    d->loaded = m->rows > 0;
}

/* A failure of the Newton systems in the words of the caller. */
static int conclude(mbsr_completion *w, int status)
{
    ++w->info.states;
    w->found = status == MBSR_OK;
    if (w->found) leave(w, w->d);
    if (status != MBSR_SINGULAR_BLOCK) return status;
    w->error.status = MBSR_UNDETERMINED;
    return MBSR_UNDETERMINED;
}

int mbsr_completion_motion(const mbsr_completion *completion, mbsr_data *data, double *q, double *u,
                           double *udot, double *lambda)
{
    const mbsr_completion *w = completion;
    if (!w || !data) return MBSR_ERR_NULL;
    if (data->model != w->m) return MBSR_ERR_MISMATCH;
    if (!w->found) return MBSR_ERR_SEQUENCE;
    const size_t nq = (size_t)w->m->nq, nu = (size_t)w->m->nu;
    leave(w, data);
    if (q) mbsri_copy(nq, w->y, q);
    if (u) mbsri_copy(nu, w->y + w->rates, u);
    if (udot) mbsri_copy(nu, w->rate + w->rates, udot);
    return lambda && w->m->rows > 0 ? mbsr_closures_force(w->m, data, lambda) : MBSR_OK;
}

/* The state of another form. */
static int complete_form(mbsr_completion *w, const mbsri_dae_form *form, double *y, double *yp)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = mbsri_unpack(form, m, d, w->t, y, w->q, w->u);
    if (!status) status = mbsri_pack(&mbsri_form_momentum, m, d, w->t, w->q, w->u, w->given);
    if (status) return refuse(w, status);
    status = search(w, true);
    if (status) return status;
    const double *u = w->y + w->rates;
    status = mbsri_positions(m, d, w->t, w->y);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (!status) status = form->pack(m, d, w->t, w->y, u, w->ahead);
    if (!status) status = form->start(m, d, w->t, w->ahead, w->rate + w->rates, w->ahead_rate);
    if (status) return refuse(w, status);
    mbsri_copy((size_t)form->size(m), w->ahead, y);
    mbsri_copy((size_t)form->size(m), w->ahead_rate, yp);
    return MBSR_OK;
}

static int complete_momentum(mbsr_completion *w, double *y, double *yp)
{
    const size_t size = (size_t)w->size, rows = (size_t)w->m->rows;
    mbsri_copy(size, y, w->given);
    mbsri_copy(rows, yp + w->loops, w->given + size);
    int status = mbsri_check_input(w->d, size + rows, w->given, "mbsr_complete", "y");
    if (!status) status = mbsri_normalise(w->m, w->d, w->given);
    if (status) return refuse(w, status);
    status = search(w, true);
    if (status) return status;
    mbsri_copy((size_t)w->loops, w->rate, w->ahead_rate);
    mbsri_copy(size - (size_t)w->loops, w->yp + w->loops, w->ahead_rate + w->loops);
    status = mbsri_check_result(w->m, w->d, size, w->ahead_rate, "mbsr_complete");
    if (status) return refuse(w, status);
    mbsri_copy(size, w->y, y);
    mbsri_copy(size, w->ahead_rate, yp);
    return MBSR_OK;
}

int mbsr_complete(mbsr_completion *completion, mbsr_data *data, mbsr_dae_form form, double t,
                  double *y, double *yp)
{
    static const char name[] = "mbsr_complete";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, y && yp, name);
    if (status) return status;
    const mbsri_dae_form *found = mbsri_find_form(form);
    if (!found) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: form is %d, no such form", name, (int)form);
    }
    if (w->m->rows > 0 && form != MBSR_DAE_MOMENTUM) {
        return mbsri_fail(&w->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "%s: the model has closures, which only the momentum form takes", name);
    }
    status =
        form == MBSR_DAE_MOMENTUM ? complete_momentum(w, y, yp) : complete_form(w, found, y, yp);
    return conclude(w, status);
}

int mbsr_complete_dynamics(mbsr_completion *completion, mbsr_data *data, double t, const double *q,
                           const double *u, const double *tau, double *udot, double *lambda)
{
    static const char name[] = "mbsr_complete_dynamics";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, q && u && udot, name);
    if (status) return status;
    const mbsr_model *m = w->m;
    if (tau) status = mbsri_check_input(data, (size_t)m->nu, tau, name, "tau");
    if (tau && !status) mbsri_copy((size_t)m->nu, tau, w->tau);
    if (!status) status = mbsri_pack(&mbsri_form_momentum, m, data, t, q, u, w->given);
    mbsri_zero((size_t)m->rows, w->given + w->size);
    if (status) return refuse(w, status);
    status = search(w, m->rows > 0); /* forces on bodies without mass make loop forces */
    if (!status) {
        mbsri_copy((size_t)m->nu, w->rate + w->rates, udot);
        if (lambda) mbsri_copy((size_t)m->rows, w->yp + w->loops, lambda);
    }
    return conclude(w, status);
}

/* Newton's method for F(t, y, y' + c (y - y_given)) = 0, from w->y, w->yp. */
static int relax(mbsr_completion *w, double c)
{
    enum { MOST = 12 };
    static const double enough = 1e-10, near = 1e-6;
    double last = INFINITY;
    int status = here(w);
    for (int step = 0; step < MOST && !status; ++step) {
        status = mbsri_completion_factor(w, c);
        if (!status) status = mbsri_completion_solve(w, w->F, w->x);
        if (status) return status;
        const double change =
            mbsri_completion_speed(w, w->x + w->rates) /
            (1e-3 / mbsri_completion_time(w) + mbsri_completion_speed(w, w->y + w->rates));
        for (int k = 0; k < w->size; ++k) {
            w->y[k] -= w->x[k];
            w->yp[k] -= c * w->x[k];
        }
        status = here(w);
        if (status || change <= enough || (change > 0.5 * last && change <= near)) return status;
        last = change;
    }
    return status ? status
                  : mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                          "Newton's method does not take out the strain");
}

int mbsr_completion_relax(mbsr_completion *completion, mbsr_data *data, double t, double rate,
                          double *y, double *yp)
{
    static const char name[] = "mbsr_completion_relax";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, y && yp, name);
    if (status) return status;
    if (!(isfinite(rate) && rate != 0.0)) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "%s: rate is %g", name,
                          rate);
    }
    const size_t size = (size_t)w->size;
    status = mbsri_check_input(data, size, y, name, "y");
    if (!status) status = mbsri_check_input(data, size, yp, name, "yp");
    if (status) return refuse(w, status);
    mbsri_copy(size, y, w->y);
    mbsri_copy(size, yp, w->yp);
    status = relax(w, rate);
    if (!status) {
        mbsri_copy(size, w->y, y);
        mbsri_copy(size, w->yp, yp);
    }
    w->found = false;
    return status == MBSR_SINGULAR_BLOCK ? MBSR_UNDETERMINED : status;
}
