/* One step: see step.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * F(t, y, y') = 0 of the momentum form, y = (q, p, u, Lambda, Eta), is linear in y' by a matrix
 * that depends on q, and u has no y' in it. A Rosenbrock method, which takes a constant mass
 * matrix and one solution a stage, would leave g(q) = 0 open by its error; so the stages are
 * those of diagonally implicit methods,
 *
 *   F(t_n + c_i h, Y_i, K_i) = 0,   Y_i = y_n + h sum_j a_ij K_j,   K_i = (Y_i - known) / (gamma h)
 *
 * each solved by a bounded number of corrections (stage.c), of which the first is the linearly
 * implicit step. Both methods are L-stable, and their last stage is the result, in which u
 * follows from p and forces without mass balance, loops are closed and their rates zero:
 *
 *   order 1: implicit Euler      gamma = 1
 *   order 2: SDIRK of two stages, gamma = 1 - sqrt(1/2), c = (gamma, 1), b = (1 - gamma, gamma),
 *            a = (gamma, 0; b)   (R. Alexander, SIAM J. Numer. Anal. 14, 1977, 1006-1021)
 *
 * With index 1 (loops, dampers) u and the rates of the multipliers are functions of q and p in
 * each stage, and all variables have the order of the method. Where springs alone hold what has
 * no mass (index 2), q has it, and u there is a difference of positions over h: order 1.
 *
 * One matrix, that of c = 1 / (gamma h) where stage 1 is guessed, serves both stages, and with
 * matrix_steps > 1 those of further steps of the same h, unless corrections are slow.
 *
 * Substeps: a part of the step that fails is halved, and its halves again, until parts are h /
 * 2^halvings. Each part is tried once, so that a step takes at most 2^(halvings + 1) - 1
 * attempts. Where the smallest part fails it is tried once more, with order 1, more corrections
 * and a looser end. After that the step is refused.
 *
 * Quaternions are normalised after each substep, and Lambda and Eta, whose origin is free, begin
 * at zero in each: nothing grows with the length of a run. */
#include "stepper/step.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "recursion/closures.h"
#include "stepper/energy.h"
#include "stepper/stage.h"

#include <math.h>

/* At a part that can be halved, at one that cannot, and once more at that one. */
typedef enum kind { HALVABLE, SMALLEST, LAST_RESORT } kind;

/* Corrections of the last resort, as a multiple; ends of iterations that do not come to the
 * tolerance. */
enum { PATIENCE = 4 };
static const double enough = 1e-4, enough_at_last = 1e-3;

mbsr_stepper_work mbsri_stepper_bound(const mbsr_stepper *s)
{
    const int smallest = 1 << s->opt.halvings, attempts = 2 * smallest - 1;
    const int corrections = (attempts * s->opt.order + smallest * PATIENCE) * s->opt.corrections;
    const int stages = attempts * s->opt.order + smallest;
    return (mbsr_stepper_work){.factorisations = stages + corrections,
                               .residuals =
                                   corrections + (s->model->position_rows > 0 ? stages : 0),
                               .solves = 2 * corrections,
                               .attempts = attempts + smallest,
                               .substeps = smallest};
}

/* s->mean of u: adds that of the stage in Y. */
static void add_mean(mbsr_stepper *s, double weight)
{
    const double *u = s->Y + s->model->nq + s->model->nu;
    for (int k = 0; k < s->model->nu; ++k) s->mean[k] += weight * u[k];
}

/* From s->y at t by h, into Y and K. */
static int solve_stages(mbsr_stepper *s, kind what, double t, double h)
{
    const bool last = what == LAST_RESORT;
    const int order = last ? 1 : s->opt.order;
    const double g = order == 2 ? 1.0 - sqrt(0.5) : 1.0;
    mbsri_stage_task task = {.t = t + g * h,
                             .h = h,
                             .c = 1.0 / (g * h),
                             .corrections = (last ? PATIENCE : 1) * s->opt.corrections,
                             .enough = fmax(last ? enough_at_last : enough, s->opt.tolerance)};
    if (s->age >= s->opt.matrix_steps) s->factored = 0.0;
    for (size_t k = 0; k < s->size; ++k) {
        s->base[k] = s->y[k];
        s->Y[k] = s->y[k] + g * h * s->yp[k];
    }
    int status = mbsri_stepper_stage(s, &task);
    if (status) return status;
    mbsri_zero((size_t)s->model->nu, s->mean);
    add_mean(s, order == 2 ? 1.0 - g : g);
    if (order == 1) return MBSR_OK;
    for (size_t k = 0; k < s->size; ++k) {
        s->base[k] = s->y[k] + (1.0 - g) * h * s->K[k];
        s->Y[k] = s->base[k] + g * h * s->K[k];
    }
    task.t = t + h;
    status = mbsri_stepper_stage(s, &task);
    if (!status) add_mean(s, g);
    return status;
}

/* Lambda and Eta from zero again, but for forces of stiff rows. */
static void forget_multipliers(mbsr_stepper *s)
{
    const mbsr_model *m = s->model;
    double *Lambda = s->Y + m->nq + 2 * m->nu;
    const mbsri_closure *c = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k) {
        for (int row = 0; row < c[k].rows; ++row)
            if (!mbsri_is_stiff(c + k, row)) Lambda[c[k].row + row] = 0.0;
    }
    mbsri_zero((size_t)m->position_rows, Lambda + m->rows);
}

/* One substep, which becomes the state where it succeeds. */
static int attempt(mbsr_stepper *s, kind what, double t, double h)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    ++s->info.last.attempts;
    int status = solve_stages(s, what, t, h);
    if (status) return status;
    status = mbsr_normalise(m, d, s->Y);
    if (!status) status = mbsr_stage_positions(m, d, t + h, s->Y);
    if (!status) status = mbsr_stage_velocities(m, d, s->Y + m->nq + m->nu);
    if (status) s->cause = *mbsr_data_error(d);
    if (!status) status = mbsri_stepper_settle(s, h, what != HALVABLE);
    if (status) return status;
    forget_multipliers(s);
    mbsri_copy(s->size, s->Y, s->y);
    mbsri_copy(s->size, s->K, s->yp);
    ++s->info.last.substeps;
    ++s->age;
    return MBSR_OK;
}

/* All parts of a step of length h that begins at t. */
static int go(mbsr_stepper *s, double t, double h)
{
    const int parts = 1 << s->opt.halvings;
    int level = 0;
    for (int at = 0; at < parts;) {
        const double begin = t + h * at / parts, length = h / (1 << level);
        const kind what = level == s->opt.halvings ? SMALLEST : HALVABLE;
        int status = attempt(s, what, begin, length);
        if (status) s->factored = 0.0;
        if (status > 0 && what == HALVABLE) {
            ++level;
            continue;
        }
        if (status > 0) {
            ++s->info.last_resorts;
            status = attempt(s, LAST_RESORT, begin, length);
        }
        if (status) return status;
        at += parts >> level;
        while (level > 0 && at % (parts >> (level - 1)) == 0) --level;
    }
    return MBSR_OK;
}

static void keep_state(mbsr_stepper *s)
{
    mbsri_copy(s->size, s->y, s->kept_y);
    mbsri_copy(s->size, s->yp, s->kept_yp);
    s->kept_account = s->account;
}

static int restore_and_refuse(mbsr_stepper *s, int status, double t_end)
{
    const mbsr_model *m = s->model;
    mbsri_copy(s->size, s->kept_y, s->y);
    mbsri_copy(s->size, s->kept_yp, s->yp);
    s->account = s->kept_account;
    ++s->info.refused;
    const mbsr_error cause = s->cause;
    /* they have worked for this state before */
    if (!mbsr_stage_positions(m, s->data, s->t, s->y))
        (void)mbsr_stage_velocities(m, s->data, s->y + m->nq + m->nu);
    return mbsri_fail(
        &s->error, status, cause.body, cause.force,
        "mbsr_stepper: the step from t = %.9g s by %.3g s is refused after %d attempts: %.160s",
        s->t, t_end - s->t, s->info.last.attempts, cause.text);
}

static int larger_count(int a, int b)
{
    return a > b ? a : b;
}

static void count_work(mbsr_stepper_info *info)
{
    const mbsr_stepper_work *last = &info->last;
    mbsr_stepper_work *most = &info->most;
    most->factorisations = larger_count(most->factorisations, last->factorisations);
    most->residuals = larger_count(most->residuals, last->residuals);
    most->solves = larger_count(most->solves, last->solves);
    most->attempts = larger_count(most->attempts, last->attempts);
    most->substeps = larger_count(most->substeps, last->substeps);
}

int mbsri_stepper_advance(mbsr_stepper *s, double t_end, double h)
{
    s->info.last = (mbsr_stepper_work){0};
    keep_state(s);
    const int status = go(s, s->t, h);
    count_work(&s->info);
    if (status) {
        s->factored = 0.0;
        return restore_and_refuse(s, status, t_end);
    }
    s->t = t_end;
    ++s->info.steps;
    return MBSR_OK;
}
