/* Newton's method of one stage: see stage.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Corrections are delta = (dF/dY + c dF/dK)^-1 F, and their size is
 *
 *   |delta| = max (|delta q_k| / span_k, h |delta u_k| / span_k)
 *
 * by the spans of the coordinates (recursion/spans.h): 1 rad, the length typical of the tree. No
 * unit is preferred, and p and the multipliers follow from q and u. With theta = |delta| /
 * |delta before| what is left after a correction is about theta / (1 - theta) |delta|.
 *
 * The matrix stays while theta < 0.3. Else it is made anew where the iteration is. Where
 * contacts come and go or friction turns round, new matrices alone run in circles: delta takes
 * back the one before. The relaxation of Aitken, of u in spans,
 *
 *   omega <- omega x . (x - delta) / |x - delta|^2,     x the correction before,
 *
 * finds the zero of a correction that changes linearly along the line of both. It is taken where
 * theta > 0.5, between 0.1 and 1 and at most doubled from one correction to the next. */
#include "stepper/stage.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"

#include <math.h>

static int keep_cause(mbsr_stepper *s, int status, const mbsr_error *error)
{
    s->cause = *error;
    return status;
}

static int evaluate_residual(mbsr_stepper *s, const mbsri_stage_task *task)
{
    ++s->info.last.residuals;
    const int status =
        mbsr_dae_residual(s->model, s->data, MBSR_DAE_MOMENTUM, task->t, s->Y, s->K, s->F);
    return status ? keep_cause(s, status, mbsr_data_error(s->data)) : MBSR_OK;
}

static int factor_stage(mbsr_stepper *s, const mbsri_stage_task *task)
{
    ++s->info.last.factorisations;
    s->factored = 0.0;
    const int status = mbsr_newton_factor(s->newton, s->data, task->t, s->Y, s->K, task->c);
    if (status) return keep_cause(s, status, mbsr_newton_error(s->newton));
    s->factored = task->c;
    s->age = 0;
    return MBSR_OK;
}

static int solve_delta(mbsr_stepper *s)
{
    ++s->info.last.solves;
    const int status = mbsr_newton_solve(s->newton, s->F, s->delta);
    return status ? keep_cause(s, status, mbsr_newton_error(s->newton)) : MBSR_OK;
}

/* Largest of h x (n) beside their spans, or beside a part of h `at` where these are far from zero:
 * rounding. */
static double largest_share(int n, double h, const double *x, const double *at, const double *span)
{
    static const double part = 1e-5;
    double largest = 0.0;
    for (int k = 0; k < n; ++k) {
        const double rounding = part * h * fabs(at[k]),
                     share = h * fabs(x[k]) / (span[k] > rounding ? span[k] : rounding);
        if (share > largest) largest = share;
    }
    return largest;
}

static double size_of_correction(const mbsr_stepper *s, double h)
{
    const int nq = s->model->nq, nu = s->model->nu, u = nq + nu;
    const double q_size = largest_share(nq, 1.0, s->delta, s->Y, s->span);
    return fmax(q_size, largest_share(nu, h, s->delta + u, s->Y + u, s->span + nq));
}

/* omega after a correction that was taken by `share`. */
static double relaxation_after(const mbsr_stepper *s, double share)
{
    static const double least = 0.1, growth = 2.0;
    const int nu = s->model->nu, first = s->model->nq + nu;
    const double *span = s->span + s->model->nq;
    double along = 0.0, square = 0.0;
    for (int k = 0; k < nu; ++k) {
        const double x = s->before[first + k] / span[k], change = x - s->delta[first + k] / span[k];
        along += x * change;
        square += change * change;
    }
    const double best = square > 0.0 ? share * along / square : 1.0;
    return fmin(fmin(1.0, growth * share), fmax(least, best));
}

static void apply_correction(mbsr_stepper *s, double share, double c)
{
    for (size_t k = 0; k < s->size; ++k) {
        s->Y[k] -= share * s->delta[k];
        s->K[k] = c * (s->Y[k] - s->base[k]);
    }
    mbsri_copy(s->size, s->delta, s->before);
}

/* Whether loops are closed at Y; of stiff rows, whether their springs agree. */
static int check_gaps(mbsr_stepper *s, const mbsri_stage_task *task)
{
    const mbsr_model *m = s->model;
    if (m->position_rows == 0) return MBSR_OK;
    const int status = evaluate_residual(s, task);
    if (status) return status;
    const double length = m->typical.length > 0.0 ? m->typical.length : 1.0;
    const double gap = mbsri_largest(m->position_rows, s->F + m->nq + 2 * m->nu + m->rows);
    if (gap <= s->opt.tolerance * length) return MBSR_OK;
    return mbsri_fail(&s->cause, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "Newton's method leaves a gap of %.3g in a loop", gap);
}

int mbsri_stepper_stage(mbsr_stepper *s, const mbsri_stage_task *task)
{
    static const double slow = 0.3, stuck = 0.5;
    double last = INFINITY, share = 1.0;
    for (size_t k = 0; k < s->size; ++k) s->K[k] = task->c * (s->Y[k] - s->base[k]);
    int status = s->factored == task->c ? MBSR_OK : factor_stage(s, task);
    for (int k = 0; k < task->corrections && !status; ++k) {
        status = evaluate_residual(s, task);
        if (!status) status = solve_delta(s);
        if (status) return status;
        double size = size_of_correction(s, task->h), theta = k > 0 ? size / last : slow;
        if (theta > slow && size > s->opt.tolerance) {
            status = factor_stage(s, task);
            if (!status) status = solve_delta(s);
            if (status) return status;
            size = size_of_correction(s, task->h);
            theta = size / last;
        }
        share = k > 0 && theta > stuck ? relaxation_after(s, share) : 1.0;
        apply_correction(s, share, task->c);
        const double left = k > 0 && theta < 1.0 ? theta / (1.0 - theta) * size : INFINITY;
        if (size <= s->opt.tolerance || (share == 1.0 && left <= s->opt.tolerance)) return MBSR_OK;
        last = share * size;
    }
    if (status) return status;
    if (last <= task->enough) return check_gaps(s, task);
    return mbsri_fail(
        &s->cause, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "after %d corrections Newton's method moves coordinates by %.3g of their size still",
        task->corrections, last);
}
