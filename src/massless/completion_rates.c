/* Accelerations and loop forces at a state: see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/completion_rates.h"

#include "massless/completion_elastic.h"
#include "massless/completion_velocities.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "recursion/closures.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>

static int here(mbsr_completion *w)
{
    return mbsri_completion_residual(w, w->t, w->y, w->yp);
}

enum { STEPS = 4 }; /* of a difference in time */

/* A step in time, s: back into what has been, where that is smooth for all of them. Outputs are
 * likely to be at the points of a table, where third derivatives jump. */
static double choose_step(const mbsr_completion *w)
{
    const double ahead = w->times.to - w->t, behind = w->t - w->times.from,
                 h = mbsri_binary(fmax(4e-6 * mbsri_completion_time(w), 1e-9 * fabs(w->t))),
                 share = 0.9 / STEPS;
    if (behind >= STEPS * h) return -h;
    return ahead > behind ? fmin(h, share * ahead) : -share * behind;
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
    mbsri_copy((size_t)w->size, w->y, w->ahead.y);
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k)) continue;
            w->ahead.y[at] += step * w->yp[at];
            any = true;
        }
    }
    if (!any) return MBSR_OK;
    const int status = mbsri_completion_residual(w, w->t, w->ahead.y, w->yp);
    add_difference(w, 1.0 / step);
    return status;
}

/* Minus the rate of F in the algebraic equations, y and y' being held but for the forces s of stiff
 * rows, whose s' is known; F is that at y afterwards. Rounding of F counts by 1e-9, what changes a
 * thousand times in the model's time by less. Where a step in time changes nothing, nothing
 * depends on it. */
static int differ_in_time(mbsr_completion *w)
{
    static const double weight[STEPS] = {4.0, -3.0, 4.0 / 3.0, -0.25}; /* exact for quartics */
    const double h = choose_step(w);
    bool changes = true;
    mbsri_copy((size_t)w->size, w->F, w->other);
    mbsri_zero((size_t)w->size, w->time);
    int status = differ_in_springs(w);
    for (int l = 0; l < STEPS && !status && changes; ++l) {
        status = mbsri_completion_residual(w, w->t + (l + 1) * h, w->y, w->yp);
        changes = add_difference(w, weight[l] / h);
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

/* Loop forces += x of rigid rows; what changes, beside all forces. */
static double add_forces(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *closure = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k)) w->yp[at] += w->x[at];
        }
    }
    const double change = mbsri_completion_force(w, w->x + w->loops),
                 size = fmax(mbsri_completion_load(w, w->rate + m->nq),
                             mbsri_completion_force(w, w->yp + w->loops));
    return change > 0.0 ? change / size : 0.0;
}

/* x[0] becomes the limit of the solutions as c grows: of velocities without those of elastic
 * directions, which grow with it. What it has been taken off is the size of the part that decays.
 */
static double join(const mbsr_completion *w, double *const *x)
{
    const double c[2] = {mbsri_completion_c(w, MBSRI_NEAR), mbsri_completion_c(w, MBSRI_FAR)};
    const double slope = 1.0 / (c[1] - c[0]), size = mbsri_completion_size(w, x[1] + w->rates);
    double *u[2] = {x[0] + w->rates, x[1] + w->rates};
    for (int k = w->loops; k < w->places; ++k) x[0][k] = slope * (c[1] * x[1][k] - c[0] * x[0][k]);
    for (int k = 0; k < w->m->nu; ++k) {
        const double first = u[0][k];
        if (w->kind.elastic) {
            u[0][k] -= slope * c[0] * (u[1][k] - first);
        } else {
            u[0][k] = slope * (c[1] * u[1][k] - c[0] * first);
            u[1][k] -= u[0][k];
        }
    }
    return w->kind.elastic ? 0.0 : mbsri_completion_speed(w, u[1]) / size;
}

/* Takes up u' and loop forces of x; the sizes of what changes in the one and in the other. */
static double take_up(mbsr_completion *w, const double *x, double *forces)
{
    const int nu = w->m->nu;
    double *udot = w->rate + w->rates;
    for (int k = 0; k < nu; ++k) udot[k] -= x[w->rates + k];
    const double change = mbsri_completion_speed(w, udot);
    mbsri_copy((size_t)nu, x + w->rates, udot);
    *forces = add_forces(w);
    return change / mbsri_completion_size(w, udot);
}

/* Whether what loop forces have changed by at last, in w->x, is nothing beside what all forces
 * change by while the motion does and goes on for the time, or a slow one where nothing moves:
 * where no forces act, or each element balances itself, there are no others to tell rounding by. F
 * is that at the state, and is again. */
static int ask_rounding(mbsr_completion *w, bool *rounding)
{
    static const double share = 1e-3, nothing = 1e-10;
    const mbsr_model *m = w->m;
    const double time = mbsri_completion_time(w), *udot = w->rate + w->rates,
                 least = 1e-3 / (time * time);
    const bool moves = mbsri_completion_speed(w, udot) >= least;
    const double left = mbsri_completion_force(w, w->x + w->loops);
    double most = 0.0;
    mbsri_copy((size_t)w->size, w->y, w->ahead.y);
    mbsri_copy((size_t)w->size, w->F, w->other);
    for (int k = 0; k < m->nu; ++k) {
        const double slow = (1.0 + 0.5 * sin(12.9898 * k)) * least / w->span.per[k];
        w->form.u[k] = share * time * (moves ? udot[k] : slow);
        w->ahead.y[w->rates + k] += w->form.u[k];
    }
    int status = mbsri_completion_moves(w, w->y, w->form.u, w->form.q);
    for (int k = 0; k < m->nq; ++k) w->ahead.y[k] += time * w->form.q[k];
    if (!status) status = mbsri_completion_residual(w, w->t, w->ahead.y, w->yp);
    for (int k = w->rates; k < w->loops; ++k)
        most = fmax(most, fabs(w->F[k] - w->other[k]) / (share * w->span.per[k - w->rates]));
    *rounding = !status && left <= nothing * most;
    return status ? status : here(w);
}

static int too_fast(mbsr_completion *w)
{
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "accelerations were not found: something stiff is far faster than "
                                 "the motion");
}

/* Loop forces less what rounding in x_Lambda, times c, leaves of the balance F_u along directions
 * without mass, and the q' and p' of these: K x = (0, 0, -c F_u, 0, 0). */
static int keep_balance(mbsr_completion *w)
{
    const double c = mbsri_completion_c(w, MBSRI_NEAR), *F = w->F + w->rates;
    double *r = w->ahead.yp;
    mbsri_zero((size_t)w->size, r);
    for (int k = 0; k < w->m->nu; ++k) r[w->rates + k] = w->lacks[k] ? -c * F[k] : 0.0;
    int status = mbsri_completion_solve(w, MBSRI_NEAR, r, w->x);
    if (status) return status;
    add_forces(w);
    status = here(w);
    known_rates(w, w->rate);
    return status;
}

/* r += share F_u over the time. */
static void add_forces_of_rates(const mbsr_completion *w, double share, double *r)
{
    const double by = share / mbsri_completion_time(w);
    for (int k = w->rates; k < w->loops; ++k) r[k] += by * w->F[k];
}

/* The s of stiff rows are aimed as positions are; their rates are part of the right side, and so
 * is what their dampers do by the s'' found so far. F is that at the state, and is again. */
static int aim_springs(mbsr_completion *w, double c, const double *solution, double *r)
{
    const mbsri_closure *closure = w->m->closures.data;
    const double time = mbsri_completion_time(w);
    bool damped = false;
    mbsri_copy((size_t)w->size, w->yp, w->ahead.yp);
    for (size_t id = 0; id < w->m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int at = w->loops + closure->row + k;
            if (!mbsri_is_stiff(closure, k)) continue;
            r[at] -= c * solution[at] / closure->def.stiffness[k];
            w->ahead.yp[at] += time * c * solution[at];
            damped = damped || closure->def.damping[k] > 0.0;
        }
    }
    if (!damped) return MBSR_OK;
    add_forces_of_rates(w, 1.0, r);
    const int status = mbsri_completion_residual(w, w->t, w->y, w->ahead.yp);
    add_forces_of_rates(w, -1.0, r);
    return status ? status : here(w);
}

/* u' into w->rate, loop forces into w->yp, by Newton systems at the state. Without loops, and where
 * springs alone hold directions, solutions aim further until x_q and x_p are the rates. Positions
 * that loops hold let x_q be no other: two solutions tell the part that decays as c grows; not the
 * first time, when loop forces may still have a share of c in them, from impulses. *loaded: by how
 * much of all forces loop forces have changed that the matrices are of. exactly: forces balance to
 * the last digit at the state, and do afterwards; where u is settled to fewer digits F_u is what u
 * lacks, and no loop force takes it up. Refused where the part that decays is more than `decays`.
 */
static int solve_rates(mbsr_completion *w, bool exactly, double decays, double *loaded)
{
    enum { MOST = 40 };
    static const double enough = 1e-11, near = 1e-6;
    const bool aims = w->kind.elastic || w->m->rows == 0, keeps = exactly && w->m->rows > 0;
    const int count = w->kind.elastic || !aims ? 2 : 1;
    double *const r[2] = {w->r, w->further}, *const x[2] = {w->x, w->other};
    double *before = w->ahead.y, *first = w->time, last = INFINITY;
    int status = differ_in_time(w);
    known_rates(w, w->rate);
    mbsri_zero((size_t)w->m->nu, w->rate + w->rates);
    for (int j = 0; j < count; ++j) {
        mbsri_copy((size_t)w->size, w->time, r[j]);
        for (int k = 0; k < w->rates; ++k) r[j][k] = mbsri_completion_c(w, j) * w->rate[k];
    }
    if (!status && keeps) mbsri_completion_lacking(w, w->lacks);
    for (int step = 0; step < MOST && !status; ++step) {
        for (int j = 0; j < count && !status; ++j) {
            if (step == 0) status = mbsri_completion_factor(w, j);
            if (!status) status = mbsri_completion_solve(w, j, r[j], x[j]);
        }
        if (status) return status;
        mbsri_copy((size_t)w->size, x[0], first);
        double forces;
        const double decay = count > 1 ? join(w, x) : 0.0, moved = take_up(w, x[0], &forces),
                     change = fmax(moved, forces);
        if (step == 0) *loaded = forces;
        mbsri_copy((size_t)w->size, w->rate, before);
        if (w->m->rows > 0) status = here(w);
        known_rates(w, w->rate);
        if (status) return status;
        if (step > 0 && decay > decays) return too_fast(w);
        if (step > 0 && mbsri_completion_converged(change, last, enough, near))
            return keeps ? keep_balance(w) : MBSR_OK;
        if (step > 3 && change > 0.5 * last) {
            bool rounding = false;
            if (moved <= near) status = ask_rounding(w, &rounding);
            if (status || !rounding) return status ? status : too_fast(w);
            return keeps ? keep_balance(w) : MBSR_OK;
        }
        last = change;
        if (keeps) status = keep_balance(w);
        for (int j = 0; j < count; ++j) {
            const double *solution = j == 0 ? first : x[1];
            for (int k = 0; k < w->rates; ++k) {
                const double more = w->rate[k] - before[k];
                r[j][k] +=
                    mbsri_completion_c(w, j) * (aims ? more + w->rate[k] - solution[k] : more);
            }
            if (aims && !status) status = aim_springs(w, mbsri_completion_c(w, j), solution, r[j]);
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

/* Loop forces of rigid rows that exert what w->other (rows) exerts, without those rows that are
 * left to others: K(c) x = (0, c C^T lambda, 0) has x_p = 0 and x_Lambda = -lambda where all
 * directions move mass. */
static int share_forces(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const double c = mbsri_completion_c(w, MBSRI_FAR);
    if (!leaves_rows(w)) return MBSR_OK;
    int status = mbsr_closures_transpose(m, w->d, w->other, w->ahead.y);
    if (status) w->error = *mbsr_data_error(w->d);
    mbsri_zero((size_t)w->size, w->r);
    for (int k = 0; k < m->nu; ++k) w->r[m->nq + k] = c * w->ahead.y[k];
    if (!status) status = mbsri_completion_factor(w, MBSRI_FAR);
    if (!status) status = mbsri_completion_solve(w, MBSRI_FAR, w->r, w->x);
    for (int k = 0; k < m->rows && !status; ++k) w->other[k] = -w->x[w->loops + k];
    return status;
}

/* Loop forces of rigid rows, and how fast springs of stiff ones change, into yp. */
static int take_loops(mbsr_completion *w, const double *lambda)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *closure = m->closures.data;
    double *rate = w->ahead.y;
    const int status = mbsr_closures_rate(m, w->d, rate);
    if (status) w->error = *mbsr_data_error(w->d);
    for (size_t id = 0; id < m->closures.count && !status; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            const int row = closure->row + k;
            w->yp[w->loops + row] =
                mbsri_is_stiff(closure, k) ? closure->def.stiffness[k] * rate[row] : lambda[row];
        }
    }
    return status;
}

int mbsri_completion_forward(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    if (w->kind.deficient && (m->rows == 0 || leaves_rows(w))) return MBSR_UNDETERMINED;
    const mbsri_closure *closure = m->closures.data;
    double *lambda = w->other;
    int status =
        mbsr_forward_dynamics(m, w->d, w->t, w->y, w->y + w->rates, w->tau, w->rate + w->rates);
    if (!status && m->rows > 0) status = mbsr_closures_lambda(m, w->d, lambda);
    if (status) w->error = *mbsr_data_error(w->d);
    for (size_t id = 0; id < m->closures.count; ++id, ++closure) {
        for (int k = 0; k < closure->rows; ++k) {
            if (mbsri_is_stiff(closure, k)) lambda[closure->row + k] = 0.0;
        }
    }
    if (!status) status = share_forces(w);
    if (!status && m->rows > 0) status = take_loops(w, lambda);
    const bool left = status == MBSR_UNDETERMINED;
    if (left || (!status && m->rows > 0)) status = here(w);
    known_rates(w, w->rate);
    return status || !left ? status : MBSR_UNDETERMINED;
}

/* Of closed models, where solutions do not aim at q', what is missing falls with c^2: where it is
 * more than rounding of forces, farther out. Of trees springs beside far larger dampers are drowned
 * by c times these: solutions creep, less so nearer. */
static int solve_by_turns(mbsr_completion *w, bool exactly, double *loaded)
{
    enum { WAYS = 4 };
    static const struct {
        double c, decays;
    } closed[WAYS] = {{1e2, 1e-5}, {1e4, 1e-5}, {1e2, 1e-3}, {1.0, 1e-3}};
    const double c = w->solver.c;
    const bool tree = w->m->rows == 0, some = w->kind.deficient && w->kind.elastic == tree;
    int status = MBSR_NO_CONVERGENCE;
    for (int k = some ? 0 : WAYS - 1; k < WAYS && status > 0; ++k) {
        w->solver.c = c * (tree && some ? pow(0.1, k) : closed[k].c);
        status = solve_rates(w, exactly, closed[k].decays, loaded);
        w->solver.c = c;
    }
    return status;
}

/* u' by forward dynamics where some rows are left to others, if these serve: they know which, while
 * solutions at finite c keep a share of what the rows left out would have to do. */
static int take_forward(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    if (!w->kind.deficient || !leaves_rows(w)) return MBSR_OK;
    const mbsr_error before = w->d->error;
    double *udot = w->form.u;
    int status = mbsr_forward_dynamics(m, w->d, w->t, w->y, w->y + w->rates, w->tau, udot);
    if (!status) mbsri_copy((size_t)m->nu, udot, w->rate + w->rates);
    if (status < 0) w->error = w->d->error;
    if (status > 0) w->d->error = before; /* what was found by Newton systems holds */
    if (status >= 0) status = here(w);
    if (!status) known_rates(w, w->rate);
    return status;
}

int mbsri_completion_rates(mbsr_completion *w, bool exactly)
{
    enum { TURNS = 4 };
    static const double known = 1e-8; /* of loop forces, whose work changes with the directions */
    int status = mbsri_completion_spring_rates(w);
    if (!status) status = mbsri_completion_forward(w);
    if (status != MBSR_UNDETERMINED) return status;
    double loaded = INFINITY;
    status = MBSR_OK;
    for (int turn = 0; turn < TURNS && loaded > known && !status; ++turn)
        status = solve_by_turns(w, exactly, &loaded);
    if (!status && w->kind.elastic) status = mbsri_completion_accelerate(w, exactly);
    return status ? status : take_forward(w);
}
