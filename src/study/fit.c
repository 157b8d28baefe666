/* Parameters from measured data: see fit.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With J = d r / d (p / scale) of the parameters that are free, J = U S V^T, a step is
 *
 *   d = -V diag(s / (s^2 + lambda)) U^T r
 *
 * lambda after Nielsen (IMM-REP-1999-05). A parameter at a bound is held while the gradient presses
 * it there. Covariance of p / scale: noise^2 V S^-2 V^T. */
#include "base/cookie.h"
#include "base/error.h"
#include "files/arena.h"
#include "study/quantile.h"
#include "study/svd.h"

#include <mbsrank/fit.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct mbsr_fit_memory {
    mbsri_arena arena;
} mbsr_fit_memory;

typedef struct fitting {
    const mbsr_fit_opt *opt;
    mbsr_error *error;
    int m, n, free;             /* residuals, parameters, of these not at a bound */
    int *at_bound;              /* n: -1, 1 at a bound, 0 */
    int *column;                /* n: parameters that are free */
    double *scale;              /* n */
    double *p, *try;            /* n: where it is, where it looks */
    double *r, *there, *beyond; /* m: residuals at p, at try, at two differences */
    double *J;                  /* m x n: d r / d (p / scale), of all parameters */
    double *US;                 /* m x free: U diag(s) */
    double *V, *s;              /* free x free, free */
    double *d, *Ur;             /* n; free */
    double sum, lambda, growth;
    int iterations, evaluations;
} fitting;

static double sum_of_squares(int m, const double *r)
{
    double sum = 0.0;
    for (int i = 0; i < m; ++i) sum += r[i] * r[i];
    return sum;
}

/* Residuals at p; 1: there are none that are finite. */
static int evaluate_at(fitting *w, const double *p, double *r)
{
    const int status = w->opt->residual(w->opt->user, p, r);
    ++w->evaluations;
    return status ? status : isfinite(sum_of_squares(w->m, r)) ? MBSR_OK : MBSR_NOT_FINITE;
}

/* ---- options ---- */

mbsr_fit_opt mbsr_default_fit_opt(void)
{
    return (mbsr_fit_opt){.cookie = MBSRI_COOKIE,
                          .step = 1e-3,
                          .tolerance = 1e-8,
                          .max_iterations = 100,
                          .confidence = 0.95};
}

static int check_parameter(const mbsr_fit_opt *o, int k, mbsr_error *error)
{
    const double start = o->start[k], low = o->low ? o->low[k] : -INFINITY,
                 high = o->high ? o->high[k] : INFINITY, scale = o->scale ? o->scale[k] : 1.0;
    if (!isfinite(start))
        return mbsri_fail_plain(error, MBSR_NOT_FINITE, "start[%d] is %g", k, start);
    if (!(low < high))
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "parameter %d: low %g is not below high %g",
                                k, low, high);
    if (!(start >= low && start <= high))
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "start[%d], %g, is not in %g .. %g", k,
                                start, low, high);
    if (!(scale > 0.0 && isfinite(scale)))
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "scale[%d] is %g", k, scale);
    return MBSR_OK;
}

static int check_fit(const mbsr_fit_opt *o, mbsr_error *error)
{
    if (!o) return mbsri_fail_plain(error, MBSR_ERR_NULL, "opt is NULL");
    if (o->cookie != MBSRI_COOKIE)
        return mbsri_fail_plain(error, MBSR_ERR_NO_DEFAULT,
                                "opt was not made by mbsr_default_fit_opt");
    if (!o->start || !o->residual)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "start or residual is NULL");
    if (o->parameters < 1 || o->residuals <= o->parameters ||
        (int64_t)o->parameters * o->residuals > INT32_MAX)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "%d parameters of %d residuals",
                                o->parameters, o->residuals);
    if (!(o->step > 0.0 && o->step < 1.0 && o->tolerance > 0.0 && o->max_iterations > 0))
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "step %g, tolerance %g or max_iterations %d is out of range",
                                o->step, o->tolerance, o->max_iterations);
    if (!(o->confidence > 0.0 && o->confidence < 1.0) || o->noise_freedoms < 0)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE, "confidence is %g, noise_freedoms %d",
                                o->confidence, o->noise_freedoms);
    int status = MBSR_OK;
    for (int k = 0; k < o->parameters && !status; ++k) status = check_parameter(o, k, error);
    return status;
}

/* ---- derivatives ---- */

static double bound(const double *bounds, int k, double none)
{
    return bounds ? bounds[k] : none;
}

/* Column k of J by differences, to both sides where bounds and the residuals allow it. */
static int difference_column(fitting *w, int k)
{
    const double h = w->opt->step * w->scale[k], p = w->p[k];
    double *side[2] = {w->there, w->beyond}, at[2] = {0.0, 0.0};
    memcpy(w->try, w->p, (size_t)w->n * sizeof *w->p);
    for (int l = 0; l < 2; ++l) {
        const double low = bound(w->opt->low, k, -INFINITY),
                     high = bound(w->opt->high, k, INFINITY);
        w->try[k] = fmin(fmax(l ? p + h : p - h, low), high);
        const int status = w->try[k] != p ? evaluate_at(w, w->try, side[l]) : 1;
        if (status < 0) return status;
        at[l] = status ? p : w->try[k];
        if (status) memcpy(side[l], w->r, (size_t)w->m * sizeof *w->r);
    }
    const double width = (at[1] - at[0]) / w->scale[k];
    if (!(width > 0.0)) return MBSR_NO_CONVERGENCE;
    for (int i = 0; i < w->m; ++i) w->J[k * w->m + i] = (side[1][i] - side[0][i]) / width;
    return MBSR_OK;
}

/* By the caller's function; a positive status where it has none. */
static int take_slopes(fitting *w)
{
    const int status = w->opt->slopes(w->opt->user, w->p, w->J);
    if (status) return status;
    for (int k = 0; k < w->n; ++k)
        for (int i = 0; i < w->m; ++i) w->J[k * w->m + i] *= w->scale[k];
    return isfinite(sum_of_squares(w->m * w->n, w->J)) ? MBSR_OK : 1;
}

static int differentiate_all(fitting *w)
{
    int status = w->opt->slopes ? take_slopes(w) : 1;
    if (status <= 0) return status;
    status = MBSR_OK;
    for (int k = 0; k < w->n && !status; ++k) status = difference_column(w, k);
    return status;
}

/* Which parameters a bound holds, as the gradient says, and the factors of what is left of J. */
static void factor_free(fitting *w)
{
    w->free = 0;
    for (int k = 0; k < w->n; ++k) {
        double slope = 0.0;
        for (int i = 0; i < w->m; ++i) slope += w->J[k * w->m + i] * w->r[i];
        const int lower = w->p[k] <= bound(w->opt->low, k, -INFINITY) && slope > 0.0,
                  upper = w->p[k] >= bound(w->opt->high, k, INFINITY) && slope < 0.0;
        w->at_bound[k] = upper - lower;
        if (w->at_bound[k]) continue;
        memcpy(w->US + w->free * w->m, w->J + k * w->m, (size_t)w->m * sizeof *w->J);
        w->column[w->free++] = k;
    }
    mbsri_svd(w->m, w->free, w->US, w->V, w->s);
    for (int k = 0; k < w->free; ++k) {
        w->Ur[k] = 0.0;
        for (int i = 0; i < w->m; ++i) w->Ur[k] += w->US[k * w->m + i] * w->r[i];
        if (w->s[k] > 0.0) w->Ur[k] /= w->s[k];
    }
}

/* ---- steps ---- */

/* The step for lambda into d (over scale) and try; returns its length. */
static double propose(fitting *w)
{
    double length = 0.0;
    memset(w->d, 0, (size_t)w->n * sizeof *w->d);
    for (int k = 0; k < w->free; ++k) {
        const double s = w->s[k], part = s > 0.0 ? -s * w->Ur[k] / (s * s + w->lambda) : 0.0;
        for (int l = 0; l < w->free; ++l) w->d[w->column[l]] += w->V[k * w->free + l] * part;
    }
    for (int k = 0; k < w->n; ++k) {
        const double low = bound(w->opt->low, k, -INFINITY),
                     high = bound(w->opt->high, k, INFINITY);
        w->try[k] = fmin(fmax(w->p[k] + w->d[k] * w->scale[k], low), high);
        w->d[k] = (w->try[k] - w->p[k]) / w->scale[k];
        length = fmax(length, fabs(w->d[k]));
    }
    return length;
}

/* By how much the squares of the linear problem become less. */
static double promised(const fitting *w)
{
    double sum = 0.0;
    for (int i = 0; i < w->m; ++i) {
        double r = w->r[i];
        for (int k = 0; k < w->n; ++k) r += w->J[k * w->m + i] * w->d[k];
        sum += r * r;
    }
    return w->sum - sum;
}

/* Tries shorter steps until one is better. *moved: its length; 0: none is. */
static int make_step(fitting *w, double *moved)
{
    const double least = 0.01 * w->opt->tolerance;
    for (*moved = propose(w); *moved > least; *moved = propose(w)) {
        const int status = evaluate_at(w, w->try, w->there);
        if (status < 0) return status;
        const double sum = status ? INFINITY : sum_of_squares(w->m, w->there);
        if (sum < w->sum) {
            const double gain = (w->sum - sum) / fmax(promised(w), 1e-300), x = 2.0 * gain - 1.0;
            w->lambda *= fmax(1.0 / 3.0, 1.0 - x * x * x);
            w->growth = 2.0;
            memcpy(w->p, w->try, (size_t)w->n * sizeof *w->p);
            memcpy(w->r, w->there, (size_t)w->m * sizeof *w->r);
            w->sum = sum;
            return MBSR_OK;
        }
        w->lambda *= w->growth;
        w->growth *= 2.0;
    }
    *moved = 0.0;
    return MBSR_OK;
}

static int iterate_fit(fitting *w)
{
    double moved = INFINITY;
    int status = evaluate_at(w, w->p, w->r);
    if (status)
        return mbsri_fail_plain(w->error, status, "the residuals at the start: %s",
                                mbsr_status_text(status));
    w->sum = sum_of_squares(w->m, w->r);
    for (w->iterations = 0; moved > w->opt->tolerance; ++w->iterations) {
        if (w->iterations == w->opt->max_iterations)
            return mbsri_fail_plain(w->error, MBSR_NO_CONVERGENCE,
                                    "%d iterations do not end: the last one changed a parameter "
                                    "by %g of its scale",
                                    w->iterations, moved);
        const mbsr_fit_progress now = {w->iterations, w->evaluations, w->sum, w->p};
        if (w->opt->progress) status = w->opt->progress(w->opt->progress_user, &now);
        if (status) return mbsri_fail_plain(w->error, status, "the fit was stopped");
        status = differentiate_all(w);
        if (!status) {
            factor_free(w);
            if (w->iterations == 0) w->lambda = 1e-3 * w->s[0] * w->s[0];
            status = make_step(w, &moved);
        }
        if (status)
            return mbsri_fail_plain(w->error, status, "the residuals in iteration %d: %s",
                                    w->iterations, mbsr_status_text(status));
    }
    status = differentiate_all(w);
    if (!status) factor_free(w);
    return status ? mbsri_fail_plain(w->error, status, "the residuals at the end: %s",
                                     mbsr_status_text(status))
                  : MBSR_OK;
}

/* ---- what is told ---- */

/* Variances from the factors, directions, intervals. */
static void measure_fit(const fitting *w, mbsr_fit *f, double *direction, double *along,
                        double *deviation, double *low, double *high)
{
    const int n = w->n, fewer = w->opt->noise_freedoms,
              freedoms = fewer > 0 && fewer < f->freedoms ? fewer : f->freedoms;
    const double noise = w->opt->known_noise ? 1.0 : f->noise,
                 part = 0.5 + 0.5 * w->opt->confidence,
                 times = w->opt->known_noise ? mbsri_normal_quantile(part)
                                             : mbsri_student_quantile(part, freedoms);
    int last = n;
    for (int k = 0; k < n; ++k) {
        deviation[k] = w->at_bound[k] ? 0.0 : deviation[k];
        if (!w->at_bound[k]) continue;
        along[--last] = INFINITY;
        direction[last * n + k] = 1.0;
    }
    for (int k = 0; k < w->free; ++k) {
        /* beyond rounding in J, of which differences have left half the digits */
        const int told = w->s[k] > 1e-9 * w->s[0];
        along[k] = told ? noise / w->s[k] : INFINITY;
        for (int l = 0; l < w->free; ++l) {
            const double v = w->V[k * w->free + l], x = v * along[k];
            direction[k * n + w->column[l]] = v;
            if (told || fabs(v) > 1e-6) deviation[w->column[l]] += x * x;
        }
    }
    for (int k = 0; k < n; ++k) {
        deviation[k] = sqrt(deviation[k]) * w->scale[k];
        low[k] = w->p[k] - times * deviation[k];
        high[k] = w->p[k] + times * deviation[k];
    }
}

static int tell_fit(fitting *w, mbsr_fit *f, mbsri_arena *arena)
{
    const size_t n = (size_t)w->n;
    double *direction = mbsri_arena_take(arena, n * n * sizeof(double)),
           *numbers = mbsri_arena_take(arena, 4 * n * sizeof(double));
    if (!direction || !numbers) return mbsri_fail_plain(w->error, MBSR_ERR_NO_MEMORY, "no memory");
    f->parameters = w->n;
    f->residuals = w->m;
    f->value = w->p;
    f->residual = w->r;
    f->at_bound = w->at_bound;
    f->scale = w->scale;
    f->sum = w->sum;
    f->freedoms = w->m - w->free;
    f->noise = sqrt(w->sum / f->freedoms);
    f->iterations = w->iterations;
    f->evaluations = w->evaluations;
    measure_fit(w, f, direction, numbers, numbers + n, numbers + 2 * n, numbers + 3 * n);
    f->direction = direction;
    f->direction_deviation = numbers;
    f->deviation = numbers + n;
    f->low = numbers + 2 * n;
    f->high = numbers + 3 * n;
    for (int k = 0; k < w->n; ++k)
        for (int i = 0; i < w->m; ++i) w->J[k * w->m + i] /= w->scale[k];
    f->jacobian = w->J;
    return MBSR_OK;
}

static int take_fitting(fitting *w, mbsri_arena *arena)
{
    const size_t n = (size_t)w->n, m = (size_t)w->m;
    double **const of_n[] = {&w->scale, &w->p, &w->try, &w->s, &w->d, &w->Ur},
                   **const of_m[] = {&w->r, &w->there, &w->beyond};
    for (int k = 0; k < 6; ++k) *of_n[k] = mbsri_arena_take(arena, n * sizeof(double));
    for (int k = 0; k < 3; ++k) *of_m[k] = mbsri_arena_take(arena, m * sizeof(double));
    w->at_bound = mbsri_arena_take(arena, n * sizeof *w->at_bound);
    w->column = mbsri_arena_take(arena, n * sizeof *w->column);
    w->J = mbsri_arena_take(arena, m * n * sizeof(double));
    w->US = mbsri_arena_take(arena, m * n * sizeof(double));
    w->V = mbsri_arena_take(arena, n * n * sizeof(double));
    if (arena->failed) return mbsri_fail_plain(w->error, MBSR_ERR_NO_MEMORY, "no memory");
    for (int k = 0; k < w->n; ++k) {
        const double start = w->opt->start[k];
        w->p[k] = start;
        w->scale[k] = w->opt->scale ? w->opt->scale[k] : start != 0.0 ? fabs(start) : 1.0;
    }
    return MBSR_OK;
}

int mbsr_fit_create(const mbsr_fit_opt *opt, mbsr_fit **fit, mbsr_error *error)
{
    if (fit) *fit = NULL;
    if (!fit) return mbsri_fail_plain(error, MBSR_ERR_NULL, "fit is NULL");
    int status = check_fit(opt, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->allocator);
    mbsr_fit *f = mbsri_arena_take(&arena, sizeof *f);
    mbsr_fit_memory *memory = mbsri_arena_take(&arena, sizeof *memory);
    fitting w = {
        .opt = opt, .error = error, .m = opt->residuals, .n = opt->parameters, .growth = 2.0};
    status = take_fitting(&w, &arena);
    if (!status) status = iterate_fit(&w);
    if (!status) status = tell_fit(&w, f, &arena);
    if (status) {
        mbsri_arena_close(&arena);
        return status;
    }
    memory->arena = arena;
    f->memory = memory;
    *fit = f;
    return MBSR_OK;
}

void mbsr_fit_destroy(mbsr_fit *fit)
{
    if (!fit) return;
    mbsri_arena arena = fit->memory->arena; /* which holds the fit */
    mbsri_arena_close(&arena);
}
