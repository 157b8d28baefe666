/* Velocities of a consistent start: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   K(c) x = (0, c (M (u - u_0) - C^T I), F_u, C u + g_t, 0):  u -= x_u,  I -= x_Lambda,
 *       lambda -= its part over c
 *
 * with F_u in joints of which some direction moves no mass. Momenta come from the difference of
 * velocities, so that rounding of M u is not multiplied by the inverse of M, and joints that carry
 * mass keep their rates to the last digit. */
#include "massless/completion_elastic.h"
#include "massless/completion_velocities.h"
#include "massless/start_velocities.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "forms/momentum.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

/* Momenta of velocities u at the positions of the data. */
static int momenta_of(mbsr_completion *w, const double *u, double *p)
{
    const int status = mbsri_velocities(w->m, w->d, u);
    if (status) {
        w->error = w->d->error;
        return status;
    }
    mbsri_momenta(w->m, w->d, p);
    return MBSR_OK;
}

int mbsri_start_momenta(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, w->t, w->y);
    if (!status) status = momenta_of(w, s->given.u, s->target);
    mbsri_zero((size_t)m->nu, s->beyond);
    if (status || !s->displaced) return status;
    mbsri_copy((size_t)m->nu, s->target, s->beyond);
    mbsri_masses_momenta(m, w->d, &s->masses, s->target);
    for (int k = 0; k < m->nu; ++k) s->beyond[k] = s->target[k] - s->beyond[k];
    return MBSR_OK;
}

/* p of w->y, and what the momenta of u are more than these, of u - u_given. */
static int compare(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    const size_t nu = (size_t)m->nu;
    double *p = w->y + m->nq, *u = w->y + w->rates, *still = w->ahead.y, *changed = w->ahead.y + nu;
    int status = mbsri_positions(m, w->d, w->t, w->y);
    mbsri_zero(nu, s->missing);
    if (!status && m->rows > 0) {
        status = mbsri_closure_jacobians(m, w->d);
        if (!status) mbsri_closure_transpose(m, w->d, s->impulse, s->missing);
    }
    mbsri_zero(nu, w->form.u);
    if (!status) status = momenta_of(w, w->form.u, still); /* a root that moves */
    for (size_t k = 0; k < nu; ++k) w->form.u[k] = u[k] - s->given.u[k];
    if (!status) status = momenta_of(w, w->form.u, changed);
    for (size_t k = 0; k < nu; ++k) {
        p[k] = s->target[k] + s->missing[k];
        /* in joints that lack some inertia F_u says it */
        s->missing[k] = s->lacks[k] ? 0.0 : changed[k] - still[k] - s->missing[k] - s->beyond[k];
    }
    return status;
}

/* The correction at w->y, into w->x and w->other. */
static int aim(mbsri_start *s, bool fresh)
{
    int status = compare(s);
    if (!status) status = mbsri_start_evaluate(s, false);
    if (!status) status = mbsri_completion_spring_rates(s->w);
    if (!status && fresh) status = mbsri_start_factor(s);
    mbsri_start_rows(s, true, true, false);
    return status ? status : mbsri_start_solve(s, s->missing);
}

static void note(mbsri_start *s)
{
    const mbsr_completion *w = s->w;
    const size_t rows = (size_t)w->m->rows;
    mbsri_copy((size_t)w->size, w->y, s->before);
    mbsri_copy(rows, s->impulse, s->impulse_before);
    mbsri_copy(rows, w->yp + w->loops, s->load_before);
    mbsri_copy((size_t)w->size, w->x, s->step);
    mbsri_copy(rows, w->other + w->loops, s->load_step);
}

static void take_share(mbsri_start *s, double share)
{
    mbsr_completion *w = s->w;
    for (int k = w->rates; k < w->loops; ++k) w->y[k] = s->before[k] - share * s->step[k];
    for (int k = 0; k < w->m->rows; ++k) {
        s->impulse[k] = s->impulse_before[k] - share * s->step[w->loops + k];
        w->yp[w->loops + k] = s->load_before[k] - share * s->load_step[k];
    }
}

/* Goes along the step as far as it leads on: *share. Zero: nowhere. Far from the balance of springs
 * the matrix lacks what is proportional to forces left, and whole steps may lead on though they do
 * not seem to: *leaps. */
static int advance(mbsri_start *s, double change, double size, int *leaps, double *share)
{
    enum { HALVINGS = 14, LEAPS = 12 };
    static const double small = 1e-7, short_way = 0.1, rounding = 1e-12;
    mbsr_completion *w = s->w;
    bool found = change <= small;
    int status = MBSR_OK;
    *share = 1.0;
    take_share(s, 1.0);
    if (found) return MBSR_OK;
    for (int tries = 0; tries < HALVINGS && !found; ++tries) {
        if (tries > 0) *share *= 0.5;
        take_share(s, *share);
        status = aim(s, false);
        if (status < 0) return status;
        found = !status && mbsri_completion_speed(w, w->x + w->rates) / size <=
                               (1.0 - 0.5 * *share) * change + rounding;
    }
    if (w->kind.elastic && (!found || *share < short_way) && ++*leaps <= LEAPS) {
        *share = 1.0;
        take_share(s, 1.0);
        return MBSR_OK;
    }
    if (!found) *share = 0.0;
    return MBSR_OK;
}

/* Whether a change by which velocities do not get better is rounding: what balances but for that
 * serves as long as they are known to what is usual, and where springs do not settle too, with no
 * other c to more. */
static bool is_rounding(mbsri_start *s, double change, double size)
{
    static const double rounding = 1e-5, usual = 100.0;
    const double known = fmin(1.0, usual * s->w->span.least / size) * rounding;
    if (!(change <= known && mbsri_start_balances(s))) return false;
    if (s->w->kind.elastic || s->c.serves) return true;
    if (s->c.rounded == 0.0) s->c.rounded = s->w->solver.c, s->c.widest = s->widest;
    return false;
}

int mbsri_start_velocities(mbsri_start *s, bool drift)
{
    static const double near = 1e-9, slow = 0.1;
    mbsr_completion *w = s->w;
    const double *u = w->y + w->rates;
    double last = INFINITY;
    int leaps = 0, slowly = 0;
    mbsri_zero((size_t)w->m->nu, w->rate + w->rates);
    for (int step = 0; step < s->opt->max_iterations; ++step) {
        double share = 1.0, drifted = 0.0;
        int status = aim(s, true);
        if (status) return status;
        const double size = 1e-3 * w->span.least + mbsri_completion_speed(w, u);
        double change = mbsri_completion_speed(w, w->x + w->rates) / size;
        note(s);
        ++s->info->iterations;
        status = advance(s, change, size, &leaps, &share);
        if (status) return status;
        if (share == 0.0 && is_rounding(s, change, size)) {
            take_share(s, 0.0);
            return MBSR_OK;
        }
        if (share == 0.0 || (share < 0.01 && change < 1e-3)) break;
        if (w->kind.elastic && drift) {
            status = mbsri_completion_drift(w, &drifted);
            if (status) return status;
            /* it is known to the rounding of differences in a thousandth of the model's time */
            change = fmax(change, drifted / (w->span.least + mbsri_completion_speed(w, u)));
        }
        /* the first loop forces are those of a wrong state */
        const bool known = step > 0 || w->m->rows == 0;
        if (share == 1.0 && known &&
            (change <= s->opt->tolerance || (change > 0.25 * last && change <= near)))
            return MBSR_OK;
        if (share == 1.0 && step > 2 && change > slow * last && change < 1e-2 && ++slowly > 3) {
            if (change <= 10.0 * near || is_rounding(s, change, size)) return MBSR_OK;
            break;
        }
        last = change;
    }
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE, "velocity");
}
