/* A consistent start: positions, Y^T gamma = 0 by Newton's method with step halving.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/null_slopes.h"

#include <float.h>
#include <math.h>

static double elastic_defect(const mbsri_start *s, const double *gamma, double *turned)
{
    mbsri_start_turn(s, gamma, turned);
    return s->damped < s->w.k ? mbsri_largest(s->w.k - s->damped, turned + s->damped) : 0.0;
}

/* q + step q', with q' in qdot that of the direction in udot. */
static int try_position(mbsri_start *s, double step, double *defect)
{
    mbsri_null_space *w = &s->w;
    for (int c = 0; c < w->m->nq; ++c) w->q[c] = s->q[c] + step * s->qdot[c];
    const int status = mbsri_null_gamma(w, s->t, w->q, s->u, s->moved);
    if (status) return status;
    *defect = elastic_defect(s, s->moved, s->trial);
    return MBSR_OK;
}

static int move_positions(mbsri_start *s, double before, bool *stuck)
{
    mbsri_null_space *w = &s->w;
    double after = INFINITY, step = 1.0;
    *stuck = false;
    for (int k = 0; k < MBSRI_HALVINGS; ++k, step *= 0.5) {
        const int status = try_position(s, step, &after);
        if (status < 0) return status;
        if (status || !(after < before)) continue;
        for (int c = 0; c < w->m->nq; ++c) s->q[c] += step * s->qdot[c];
        return MBSR_OK;
    }
    *stuck = true;
    return MBSR_OK;
}

/* Moves u by typical rates in all null directions, to where forces may change with it. */
static void move_off(mbsri_start *s)
{
    const mbsri_null_space *w = &s->w;
    for (int l = 0; l < w->k; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)w->m->nu,
                     step = (1.0 + 0.25 * sin(12.9898 * l)) /
                            mbsri_start_relative(w->m->nu, a, w->u_scale);
        mbsri_ax(w->m->nu, 1, step, a, &(double){1.0}, s->u);
    }
    s->moved_off = true;
}

/* The direction of a step at a state that split has seen: qdot; s->defect has gamma. */
static int aim_positions(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    mbsri_start_turn(s, s->defect, s->moved);
    for (int r = 0; r < w->k; ++r) s->moved[r] = r < s->damped ? 0.0 : -s->moved[r];
    mbsri_start_drop_rounding(s, s->damped, w->k - s->damped, s->moved);
    mbsri_start_springs(s);
    const int status = mbsri_start_factor(s, MBSRI_LEAST_STIFFNESS);
    if (status) return status;
    mbsri_start_solve(s, s->moved);
    mbsri_zero((size_t)w->m->nu, s->udot);
    mbsri_null_combine(w, s->weights, s->udot);
    return mbsri_null_rate(w, s->t, s->q, s->udot, s->qdot);
}

/* One step; *done: the positions are found. */
static int step_positions(mbsri_start *s, int number, double *last, bool *done)
{
    mbsri_null_space *w = &s->w;
    int status = mbsri_start_directions(s);
    if (!status) status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (status) return status;
    if (number == 0 && !s->moved_off) s->info.force_defect = mbsri_largest(w->k, s->defect);
    *done = s->damped == w->k;
    if (*done) return MBSR_OK;
    const bool still = mbsri_start_imbalance(s, s->defect, false) <= MBSRI_GAMMA_ROUNDING;
    const double before = elastic_defect(s, s->defect, s->moved);
    if (number == 0) s->first_defect = before;
    status = aim_positions(s);
    if (status == MBSR_UNDETERMINED && !still && !s->moved_off && number == 0 &&
        !mbsri_start_relaxed(s, s->defect, false)) {
        move_off(s);
        return MBSR_OK;
    }
    /* springs that held at the start and have given way with the force still there */
    if (status == MBSR_UNDETERMINED && before > 1e-3 * s->first_defect && s->info.iterations > 0)
        return mbsri_start_unbalanced(s, "position balances the springs", s->defect);
    if (status) return status;
    *done =
        still || mbsri_start_settled(s, last, mbsri_start_relative(w->m->nq, s->qdot, w->q_scale),
                                     mbsri_start_relative(w->m->nq, s->q, w->q_scale), 1e-8);
    if (*done) return MBSR_OK;
    s->info.iterations += 1;
    status = move_positions(s, before, done);
    const double size = fmax(mbsri_start_relative(w->m->nq, s->q, w->q_scale), 1e-3);
    if (*done && *last > 1e-6 * size)
        return mbsri_start_unbalanced(s, "position balances the springs", s->defect);
    return status;
}

int mbsri_start_positions(mbsri_start *s)
{
    double last = INFINITY;
    bool done = false;
    int status = MBSR_OK;
    for (int step = 0; step < s->opt->max_iterations && !status && !done; ++step)
        status = step_positions(s, step, &last, &done);
    if (status || done) return status;
    return mbsri_fail(
        &s->w.d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_dae_consistent: positions did not converge in %d iterations (the last one changed "
        "them by %g of their size)",
        s->opt->max_iterations, last);
}
