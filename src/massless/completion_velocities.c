/* Velocities and loop forces at given positions and momenta: see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Newton's method with r = (0, 0, F_u, F_Lambda, F_Eta), with a matrix of this state or of one
 * before for as long as it contracts. */
#include "massless/completion_velocities.h"

#include "massless/completion_elastic.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

/* Of velocities, and of loop forces: corrections that need not be followed by others. */
static const double tiny = 1e-11;

/* Corrections, relative to what they correct: of velocities, and of loop forces where these hold
 * what has no mass. */
typedef struct corrections {
    double speed, force;
} corrections;

/* Sizes of those in w->x; `forces`: whether loop forces are taken off. Where all has mass these
 * follow from accelerations. */
static corrections measure_corrections(mbsr_completion *w, double c, bool forces)
{
    const double speed = 1e-3 * w->span.least + mbsri_completion_speed(w, w->y + w->rates);
    double force = mbsri_completion_load(w, w->F + w->m->nq), change = 0.0;
    if (forces && w->kind.deficient) {
        change = c * mbsri_completion_force(w, w->x + w->loops);
        force = fmax(force, fmax(change, mbsri_completion_force(w, w->yp + w->loops)));
    }
    return (corrections){.speed = mbsri_completion_speed(w, w->x + w->rates) / speed,
                         .force = change > 0.0 ? change / force : 0.0};
}

/* y less x, as far as it is to be settled, loop forces by c x; the residual there. */
static int take_off(mbsr_completion *w, double c, bool forces)
{
    const mbsr_model *m = w->m;
    const int first = m->rows > 0 ? 0 : w->rates;
    for (int k = first; k < w->loops; ++k) w->y[k] -= w->x[k];
    for (int k = w->loops; k < w->places && forces; ++k) w->yp[k] -= c * w->x[k];
    const int status = m->rows > 0 ? mbsri_normalise(m, w->d, w->y) : MBSR_OK;
    if (status) w->error = w->d->error;
    return status ? status : mbsri_completion_residual(w, w->t, w->y, w->yp);
}

/* Where all has mass, nothing is closed and the correction is small: the same without an
 * evaluation. By its rows K(c) x = (0, 0, F_u) has F_q,u x_u = -c x_q but for 1/c, and so for p.
 * False where it would not do. */
static bool take_off_linearly(mbsr_completion *w, double c, corrections now, corrections last)
{
    static const double small = 1e-6, left = 1e-10;
    const bool converges =
        now.speed <= small && last.speed < INFINITY && now.speed * now.speed <= left * last.speed;
    if (w->kind.deficient || w->m->rows > 0 || !(converges || now.speed <= tiny)) return false;
    for (int k = 0; k < w->rates; ++k) w->F[k] += c * w->x[k];
    for (int k = w->rates; k < w->loops; ++k) w->y[k] -= w->x[k];
    return true;
}

/* x from r, without what springs alone hold. */
static int correct(mbsr_completion *w, int which)
{
    if (!w->kind.elastic) return mbsri_completion_solve(w, which, w->r, w->x);
    const int status = mbsri_completion_split(w, w->r);
    for (int k = w->loops; k < w->size; ++k) w->x[k] = w->other[k] / w->solver.c;
    return status;
}

/* Whether u is settled but for the corrections in w->x, which need not be taken. */
static bool nothing_left(corrections now)
{
    static const double little = 1e-10;
    return now.speed <= little && now.force <= little;
}

/* Whether forces balance but for rounding: none of F_u beside forces, and those that change momenta
 * within the time. */
static bool balances(mbsr_completion *w)
{
    static const double rounding = 1e-10;
    const mbsr_model *m = w->m;
    const double forces = mbsri_completion_load(w, w->F + m->nq) +
                          mbsri_completion_force(w, w->yp + w->loops),
                 changes = mbsri_completion_load(w, w->y + m->nq) / mbsri_completion_time(w);
    return mbsri_completion_load(w, w->F + w->rates) <= rounding * (forces + changes);
}

/* Whether u is settled once a correction is taken. Impulses at the size of rounding are large
 * forces in c x_Lambda: loop forces that balance may keep changing. Where all has mass and nothing
 * is closed F_u is linear in u, and a matrix of this state leaves a share of 1/c. */
static bool settled(mbsr_completion *w, corrections now, corrections last, bool fresh)
{
    static const double linear = 1e-4;
    const double near = w->m->rows > 0 ? 1e-6 : 1e-8;
    if (fresh && !w->kind.deficient && w->m->rows == 0) return now.speed <= linear;
    return mbsri_completion_converged(now.speed, last.speed, tiny, near) &&
           (mbsri_completion_converged(now.force, last.force, tiny, near) || balances(w));
}

/* Whether what is left is less than u can tell: a matrix of this state corrects u by less than its
 * rounding, and loop forces over and over by as little. */
static bool stands(const mbsr_completion *w, corrections now, corrections last, bool fresh)
{
    return w->m->rows > 0 && fresh && fmax(now.speed, last.speed) <= tiny && now.force < 1.0 &&
           now.force >= 0.5 * last.force;
}

int mbsri_completion_spring_rates(mbsr_completion *w)
{
    const mbsri_closure *closure = w->m->closures.data;
    bool any = false;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k) || w->F[at] == 0.0) continue;
            w->yp[at] -= closure->def.stiffness[k] * w->F[at];
            any = true;
        }
    }
    return any ? mbsri_completion_residual(w, w->t, w->y, w->yp) : MBSR_OK;
}

static int settle_velocities(mbsr_completion *w)
{
    enum { MOST = 30 };
    static const double old = 0.03;
    const bool closed = w->m->rows > 0;
    /* far out, where only impulses are left of x_p, and of a linear F_u nothing is */
    const int which = !w->kind.elastic && (closed || !w->kind.deficient) ? MBSRI_FAR : MBSRI_NEAR;
    const double c = mbsri_completion_c(w, which);
    corrections last = {INFINITY, INFINITY};
    bool fresh = !mbsri_completion_has(w, which), again = false;
    for (int step = 0; step < MOST; ++step) {
        int status = MBSR_OK;
        if (again) status = mbsri_completion_factor(w, which);
        if (again && !status && w->kind.elastic) status = mbsri_completion_factor(w, MBSRI_FAR);
        if (!status) status = mbsri_completion_spring_rates(w);
        mbsri_zero((size_t)w->rates, w->r);
        mbsri_copy((size_t)(w->size - w->rates), w->F + w->rates, w->r + w->rates);
        if (!status) status = correct(w, which);
        if (status) return status;
        /* the first corrections of closed models are impulses, not forces */
        const bool forces = closed && (w->kind.elastic || !w->kind.deficient || step > 0);
        const corrections now = measure_corrections(w, c, forces);
        if (step > 0 && (nothing_left(now) || stands(w, now, last, again))) return MBSR_OK;
        if (take_off_linearly(w, c, now, last)) return MBSR_OK;
        status = take_off(w, c, forces);
        if (status || ((forces || !closed) && settled(w, now, last, fresh || again))) return status;
        again = now.speed > old * last.speed || now.force > old * last.force;
        last = (corrections){now.speed, forces || !closed ? now.force : INFINITY};
    }
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "velocities without mass were not found: Newton's method does not "
                                 "converge");
}

int mbsri_completion_velocities(mbsr_completion *w)
{
    enum { PASSES = 6 };
    static const double enough = 1e-12;
    int status = settle_velocities(w);
    double last = INFINITY;
    mbsri_zero((size_t)w->m->nu, w->rate + w->rates);
    for (int pass = 0; pass < PASSES && w->kind.elastic && !status; ++pass) {
        double change = 0.0;
        status = mbsri_completion_drift(w, &change);
        if (change <= enough * mbsri_completion_speed(w, w->y + w->rates)) break;
        if (!status) status = mbsri_completion_residual(w, w->t, w->y, w->yp);
        if (!status) status = settle_velocities(w);
        if (!(change < 0.5 * last)) break;
        last = change;
    }
    return status;
}
