/* A consistent start: velocities, Yc^T gamma = 0 and Y^T gamma' = 0.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/null_slopes.h"

#include <float.h>
#include <math.h>

/* out = gamma' along q' = G u with u held fixed; gamma is in s->defect. */
static int drift(mbsri_start *s, double *out)
{
    const int status = mbsri_null_rate(&s->w, s->t, s->q, s->u, s->qdot);
    return status ? status
                  : mbsri_start_differences(s, mbsri_start_short_time(s, 1e-5), false, s->defect,
                                            out, NULL);
}

/* out = [Yc^T gamma; Y^T gamma'] at u, and gamma in s->defect; *left: the imbalance of the
 * first, and the sizes that it is measured by. */
static int velocity_defect(mbsri_start *s, double *out, double *left, double *sizes)
{
    mbsri_null_space *w = &s->w;
    int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    *left = mbsri_start_imbalance(s, s->defect, true);
    mbsri_copy((size_t)w->k, w->force, sizes);
    mbsri_start_turn(s, s->defect, out);
    if (s->damped == w->k) return MBSR_OK;
    status = drift(s, s->trial);
    mbsri_start_turn(s, s->trial, s->weights);
    for (int r = s->damped; r < w->k && !status; ++r) out[r] = s->weights[r];
    return status;
}

/* u + step change, until the damped rows of the defect, of size `before`, get smaller: the others
 * are linear in u. */
static int move_velocities(mbsri_start *s, double before, bool *stuck)
{
    mbsri_null_space *w = &s->w;
    const int nu = w->m->nu;
    double step = 1.0;
    *stuck = false;
    for (int k = 0; k < MBSRI_HALVINGS; ++k, step *= 0.5) {
        for (int c = 0; c < nu; ++c) w->u[c] = s->u[c] + step * s->change[c];
        const int status = mbsri_null_gamma(w, s->t, s->q, w->u, s->trial);
        if (status < 0 && status != MBSR_NOT_FINITE) return status;
        if (status) continue;
        mbsri_start_turn(s, s->trial, s->moved);
        if (s->damped > 0 && !(mbsri_largest(s->damped, s->moved) < before)) continue;
        for (int c = 0; c < nu; ++c) s->u[c] += step * s->change[c];
        return MBSR_OK;
    }
    *stuck = true;
    return MBSR_OK;
}

/* One step; *done: the velocities are found. */
static int step_velocities(mbsri_start *s, int number, double *last, bool *done)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    double left = 0.0;
    bool stuck = false;
    const int damped = s->damped;
    int status = number > 0 ? mbsri_start_directions(s) : MBSR_OK;
    if (!status && s->damped != damped) /* a law has no slope there */
        return mbsri_null_gamma(w, s->t, s->q, s->u, s->defect)
                   ? MBSR_NO_CONVERGENCE
                   : mbsri_start_unbalanced(s, "velocity balances the forces", s->defect);
    if (!status) status = velocity_defect(s, s->moved, &left, number == 0 ? s->sizes : s->trial);
    if (status) return status;
    const double before = mbsri_largest(s->damped, s->moved);
    for (int r = 0; r < k; ++r) s->moved[r] = -s->moved[r];
    mbsri_start_drop_rounding(s, 0, s->damped, s->moved);
    mbsri_start_springs(s);
    status = mbsri_start_factor(s, MBSRI_LEAST_STIFFNESS);
    if (status == MBSR_UNDETERMINED && number > 0)
        return mbsri_start_unbalanced(s, "velocity balances the forces", s->defect);
    if (status) return status;
    mbsri_start_solve(s, s->moved);
    mbsri_zero((size_t)nu, s->change);
    mbsri_null_combine(w, s->weights, s->change);
    s->info.iterations += 1;
    const double change = mbsri_start_relative(nu, s->change, w->u_scale),
                 size = mbsri_start_relative(nu, s->u, w->u_scale);
    const bool level = s->damped == k || change > 0.25 * *last;
    *done =
        (left <= MBSRI_GAMMA_ROUNDING && level) || mbsri_start_settled(s, last, change, size, 1e-6);
    if (*done) {
        for (int c = 0; c < nu; ++c) s->u[c] += s->change[c];
        return MBSR_OK;
    }
    status = move_velocities(s, before, &stuck);
    /* rounding of forces that cancelled unseen */
    if (stuck && (left <= 1e-9 || mbsri_start_relaxed(s, s->defect, true))) {
        for (int c = 0; c < nu; ++c) s->u[c] += s->change[c];
        *done = level;
        stuck = false;
    }
    return stuck && !status ? mbsri_start_unbalanced(s, "velocity balances the forces", s->defect)
                            : status;
}

/* Whether gamma has become small beside what it was made of at the velocities given: it is, beside
 * anything, where velocities run away. */
static int check_velocities(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    const int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    const double least = 1e-6 * mbsri_largest(w->k, s->sizes);
    /* what changes velocities by as little as a correction that is the last */
    mbsri_zero((size_t)w->k, s->trial);
    mbsri_start_add_dampers(s, 1e-3 * s->opt->tolerance, s->trial);
    for (int l = 0; l < w->k && least > 0.0; ++l) {
        const double rounding = fmax(MBSRI_GAMMA_ROUNDING * w->strain[l], s->trial[l]),
                     small = fmax(1e-3 * fmax(s->sizes[l], least), rounding);
        if (s->reduced.row_taken[l] && fabs(s->defect[l]) > small)
            return mbsri_start_unbalanced(s, "velocity balances the forces", s->defect);
    }
    return MBSR_OK;
}

/* *steps: of the iterations, how many are left. */
static int iterate_velocities(mbsri_start *s, int *steps)
{
    double last = INFINITY;
    bool done = false;
    int status = MBSR_OK;
    for (int number = 0; *steps > 0 && !status && !done; ++number, --*steps)
        status = step_velocities(s, number, &last, &done);
    if (!status && done) return check_velocities(s);
    if (status) return status;
    return mbsri_fail(
        &s->w.d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: velocities did not converge in %d iterations (the last one changed "
        "them by %g of their size)",
        s->opt->max_iterations, last);
}

/* Takes the null directions out of u, with typical rates as weights: dampers and friction are
 * steepest near rest. */
static int come_to_rest(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    const int k = w->k, nu = w->m->nu;
    mbsri_reduction *gram = &s->rest;
    for (int c = 0; c < k; ++c) {
        s->moved[c] = 0.0;
        for (int r = 0; r < k; ++r) gram->A[c * k + r] = gram->error[c * k + r] = 0.0;
        for (int l = 0; l < nu; ++l) {
            const double a =
                w->direction[(size_t)c * (size_t)nu + (size_t)l] / (w->u_scale[l] * w->u_scale[l]);
            s->moved[c] -= a * s->u[l];
            for (int r = 0; r < k; ++r)
                gram->A[c * k + r] += a * w->direction[(size_t)r * (size_t)nu + (size_t)l];
        }
    }
    mbsri_reduce(gram, k, k, k, DBL_EPSILON, NULL);
    mbsri_zero((size_t)k, s->weights);
    mbsri_start_back(gram, false, s->moved, s->weights);
    mbsri_null_combine(w, s->weights, s->u);
    return mbsri_start_directions(s);
}

/* From the velocities given; if no step from there leads on, from rest. */
int mbsri_start_velocities(mbsri_start *s)
{
    int steps = s->opt->max_iterations;
    const int status = iterate_velocities(s, &steps);
    if (status != MBSR_NO_CONVERGENCE || steps == 0) return status;
    const mbsr_error first = s->w.d->error;
    mbsri_copy((size_t)s->w.m->nu, s->u_given, s->u);
    int again = come_to_rest(s);
    if (!again) again = iterate_velocities(s, &steps);
    if (again == MBSR_NO_CONVERGENCE) s->w.d->error = first;
    return again;
}
