/* First-order errors of zeros, at a state and along a run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With F(t, y, y') = 0 the reduced model and w the neglected forces along its motion, the motion
 * with the masses is y + delta + O(second order),
 *
 *   dF/dy delta + dF/dy' delta' = (dF/dload) w,
 *
 * from rest but for the neglected momentum of the start, which acts as an impulse on it. delta' is
 * replaced by a formula of BDF; dF/dy' of differential variables is 1, and of Lambda only the
 * derivative counts, so that its past may be taken as zero. For one candidate alone that is all of
 * static displacement w / k, creep w / d and drift w t^2 / 2 M of whatever it moves. */
#include "small/errors.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "small/loads.h"
#include "small/swings.h"
#include "small/twins.h"

#include <math.h>

/* rhs of one candidate. */
static int load(mbsr_small_masses *s, mbsri_candidate *c, double t, const double *y,
                const double *yp, const mbsri_small_formula *f)
{
    const mbsr_model *m = s->reduced.model;
    const int d = m->body[c->i].d;
    for (int k = 0; k < d; ++k) s->work.load[k] = c->force[k] - f->impulse * c->impulse[k];
    const int status =
        mbsri_small_column(s, &s->reduced, t, y, yp, &c->load, s->work.load, s->work.rhs);
    for (int k = 0; k < m->nq + m->nu; ++k)
        s->work.rhs[k] -= f->b[0] * c->error[1][k] + f->b[1] * c->error[2][k];
    return status;
}

int mbsri_small_factor(mbsr_small_masses *s, double t, const double *y, const double *yp, double c)
{
    const int status = mbsr_newton_factor(s->reduced.newton, s->reduced.data, t, y, yp, c);
    ++s->factorised.count;
    return mbsri_small_failed(s, status, mbsr_newton_error(s->reduced.newton));
}

int mbsri_small_solve(mbsr_small_masses *s, double t, const double *y, const double *yp,
                      const mbsri_small_formula *f)
{
    int status = mbsri_small_unloaded(s, &s->reduced, t, y, yp);
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        if (c->keeps_mass) continue;
        status = load(s, c, t, y, yp, f);
        if (status) return status;
        status = mbsr_newton_solve(s->reduced.newton, s->work.rhs, c->error[0]);
        if (status) return mbsri_small_failed(s, status, mbsr_newton_error(s->reduced.newton));
    }
    return status;
}

/* ---- in the outputs ---- */

/* value: the outputs at (q, u) + sign (error of y). */
static int outputs_at(mbsr_small_masses *s, double t, const double *y, const double *error,
                      double sign, double *value)
{
    const mbsr_model *m = s->reduced.model;
    const int nq = m->nq, u = nq + m->nu;
    for (int k = 0; k < nq; ++k) s->work.q[k] = y[k] + sign * error[k];
    for (int k = 0; k < m->nu; ++k) s->work.u[k] = y[u + k] + sign * error[u + k];
    const int status = s->opt.output(s->opt.output_user, t, s->work.q, s->work.u, value);
    if (!status) return MBSR_OK;
    return mbsri_fail(&s->error, status, MBSR_NONE, MBSR_NONE,
                      "the function of outputs returned %d at t = %g", status, t);
}

static int compare(mbsr_small_masses *s, double t, const double *y, const double *error,
                   mbsri_small_worst *worst)
{
    int status = MBSR_OK;
    if (s->opt.output) {
        status = outputs_at(s, t, y, error, 1.0, s->work.above);
        if (!status) status = outputs_at(s, t, y, error, -1.0, s->work.below);
        if (status) return status;
    }
    for (int k = 0; k < s->outputs; ++k) {
        const double e =
            fabs(s->opt.output ? 0.5 * (s->work.above[k] - s->work.below[k]) : error[k]);
        const double share = e / s->tolerance[k];
        if (!isfinite(share))
            return mbsri_fail(&s->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                              "the error of output %d is not finite at t = %g", k, t);
        if (share > worst->share) *worst = (mbsri_small_worst){e, share, t, k};
    }
    return MBSR_OK;
}

int mbsri_small_note(mbsr_small_masses *s, double t, const double *y)
{
    int status = MBSR_OK;
    mbsri_zero((size_t)s->size, s->work.total);
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        if (c->keeps_mass) continue;
        for (int l = 0; l < s->size; ++l) s->work.total[l] += c->error[0][l];
        status = compare(s, t, y, c->error[0], &c->worst);
    }
    return status ? status : compare(s, t, y, s->work.total, &s->zeros.worst);
}

/* ---- along a run ---- */

static void shift(mbsr_small_masses *s)
{
    for (int k = 0; k < s->candidates; ++k) {
        double **error = s->candidate[k].error, *oldest = error[2];
        error[2] = error[1];
        error[1] = error[0];
        error[0] = oldest;
    }
}

/* The impulse acts in the first step; a formula of order 2 would carry its jump on, so the second
 * is implicit Euler, too. */
static mbsri_small_formula formula_to(const mbsr_small_masses *s, double t)
{
    const double h = t - s->run.t[0];
    if (s->run.states <= 2)
        return (mbsri_small_formula){1.0 / h, {-1.0 / h, 0.0}, s->run.states == 1 ? 1.0 / h : 0.0};
    const double x = h / (s->run.t[0] - s->run.t[1]);
    return (mbsri_small_formula){
        (1.0 + 2.0 * x) / ((1.0 + x) * h), {-(1.0 + x) / h, x * x / ((1.0 + x) * h)}, 0.0};
}

/* The errors begin as zero: what `start` has estimated for the whole duration goes. */
static void zero_errors(mbsr_small_masses *s)
{
    s->zeros.worst = (mbsri_small_worst){0.0, 0.0, s->start.t, 0};
    for (int k = 0; k < s->candidates; ++k) {
        mbsri_candidate *c = s->candidate + k;
        for (int l = 0; l < 3; ++l) mbsri_zero((size_t)s->size, c->error[l]);
        c->worst = s->zeros.worst;
    }
}

int mbsri_small_follow(mbsr_small_masses *s, double t, const double *y, const double *yp)
{
    if (s->run.states == 1) zero_errors(s);
    const mbsri_small_formula formula = formula_to(s, t);
    int status = mbsri_small_forces(s, t, y, yp);
    if (!status) status = mbsri_small_swings_follow(s, t, y);
    if (status) return status;
    shift(s);
    status = mbsri_small_factor(s, t, y, yp, formula.c);
    if (!status) status = mbsri_small_solve(s, t, y, yp, &formula);
    /* in the step of the impulse springs give way that swing back in the next */
    if (!status && s->run.states > 1) status = mbsri_small_note(s, t, y);
    if (status) return status;
    s->run.t[2] = s->run.t[1];
    s->run.t[1] = s->run.t[0];
    s->run.t[0] = t;
    ++s->run.states;
    return MBSR_OK;
}
