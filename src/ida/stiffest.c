/* The force elements whose stiffness fails error tests and Newton's method.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the direction v (joint rates) that the filter took off an error last, an element with the
 * energy E(q) and the dissipated power P(q, u) adds
 *
 *   s = E'' + c P'' / 2,    c of the step: d E / d q twice along G v, P twice along v
 *
 * to v^T K v. Both are quadratic in v for springs and dampers: second differences. Where Newton's
 * method failed its corrections lie across the stiff direction, which is not known: there it is the
 * sum of s / M_jj over the unit vectors v of the coordinates, squares of frequencies, to be
 * compared with c^2 of the longest step so far: the present one may be very short where nothing
 * converges. The same is asked where a run has ended and neither is known. */
#include "ida/stiffest.h"

#include "ida/shift.h"
#include "ida/error.h"
#include "ida/stiff.h"

#include <mbsrank/dynamics.h>

#include <float.h>
#include <math.h>

/* Where elements are asked; work and vectors of the caller. */
typedef struct place {
    const mbsr_model *model;
    mbsr_data *data;
    double t, c;
    double *state;     /* q, u: nq + nu */
    double *v, *work;  /* nu; nq + nu */
    double *stiffness; /* of all elements */
} place;

/* Positions and velocities at q + step G v, u + step v. */
static int move_state(const place *p, double step, const double *v)
{
    const int nq = mbsr_model_nq(p->model), nu = mbsr_model_nu(p->model);
    const double *u = p->state + nq;
    double *q = p->work, *w = q + nq;
    int status = mbsr_stage_positions(p->model, p->data, p->t, p->state);
    if (!status) status = mbsr_stage_velocities(p->model, p->data, v);
    if (!status) status = mbsr_coordinate_rates(p->model, p->data, q);
    for (int k = 0; k < nq; ++k) q[k] = p->state[k] + step * q[k];
    for (int k = 0; k < nu; ++k) w[k] = u[k] + step * v[k];
    if (!status) status = mbsr_stage_positions(p->model, p->data, p->t, q);
    return status ? status : mbsr_stage_velocities(p->model, p->data, w);
}

/* The step along v: small beside what moves, and well above rounding. */
static double extent(const place *p, const double *v)
{
    double largest = 0.0;
    for (int k = 0; k < mbsr_model_nu(p->model); ++k) largest = fmax(largest, fabs(v[k]));
    return largest > 0.0 ? cbrt(DBL_EPSILON) / largest : 0.0;
}

/* Adds factor (E / step^2, c P / 2 step^2) of each element, where the data stands. */
static int add(const place *p, double factor)
{
    int status = MBSR_OK;
    for (int k = 0; k < mbsr_model_forces(p->model) && !status; ++k) {
        double energy = 0.0, power = 0.0;
        if (mbsr_force_closure(p->model, k) != MBSR_NONE) continue;
        status = mbsr_force_power(p->model, p->data, k, &energy, &power);
        p->stiffness[k] += factor * (energy + 0.5 * p->c * power);
    }
    return status;
}

/* Adds factor s of each element along v. */
static int along(const place *p, const double *v, double factor)
{
    const double step = extent(p, v);
    int status = MBSR_OK;
    for (int side = -1; side <= 1 && !status && step > 0.0; ++side) {
        status = move_state(p, side * step, v);
        if (!status) status = add(p, factor * (side ? 1.0 : -2.0) / (step * step));
    }
    return status;
}

/* v^T M v */
static int mass_of(const place *p, const double *v, double *mass)
{
    double kinetic = 0.0, potential = 0.0;
    int status = mbsr_stage_positions(p->model, p->data, p->t, p->state);
    if (!status) status = mbsr_stage_velocities(p->model, p->data, v);
    if (!status) status = mbsr_energy(p->model, p->data, &kinetic, &potential);
    *mass = 2.0 * kinetic;
    return status;
}

/* All coordinates that move mass. */
static int along_all(const place *p)
{
    const int nu = mbsr_model_nu(p->model);
    double *v = p->v;
    int status = MBSR_OK;
    for (int k = 0; k < nu; ++k) v[k] = 0.0;
    for (int k = 0; k < nu && !status; ++k) {
        double mass = 0.0;
        v[k] = 1.0;
        status = mass_of(p, v, &mass);
        if (!status && mass > 0.0) status = along(p, v, 1.0 / mass);
        v[k] = 0.0;
    }
    return status;
}

/* The largest of s that is not among the `known` first ones; MBSR_NONE: none is positive. */
static int largest(const double *s, int forces, int known, const int *taken)
{
    int best = MBSR_NONE;
    for (int k = 0; k < forces; ++k) {
        bool again = false;
        for (int j = 0; j < known; ++j) again = again || taken[j] == k;
        if (!again && s[k] > 0.0 && (best == MBSR_NONE || s[k] > s[best])) best = k;
    }
    return best;
}

/* The answer, along `direction` or, where that is NULL, all coordinates: of these, elements count
 * that are fast beside c. */
static int rank(const place *p, const double *direction, int most, int *force, double *share,
                int *count)
{
    const int forces = mbsr_model_forces(p->model);
    const double least = direction ? 0.0 : p->c * p->c;
    double sum = 0.0;
    for (int k = 0; k < forces; ++k) p->stiffness[k] = 0.0;
    const int status = direction ? along(p, direction, 1.0) : along_all(p);
    for (int k = 0; k < forces; ++k) sum += fmax(0.0, p->stiffness[k]);
    if (status || !(sum >= least && isfinite(sum))) return status;
    for (int k = 0; k < most; ++k) {
        const int next = largest(p->stiffness, forces, k, force);
        if (next == MBSR_NONE) break;
        force[k] = next;
        share[k] = p->stiffness[next] / sum;
        ++*count;
    }
    return MBSR_OK;
}

/* ---- what is known of the failure ---- */

/* Whether a step has shown what is stiff. */
static bool knows(const mbsri_stiff *s)
{
    return s->info.stiff_tests > 0 || s->info.careful_failures > 0;
}

/* c of the longest step so far. */
static double slowest(const mbsri_stiff *s)
{
    double h = 0.0;
    if (s->blame.slowest > 0.0) return s->blame.slowest;
    if (!s->memory) return INFINITY;
    if (IDAGetLastStep(s->memory, &h) < 0 || h == 0.0) IDAGetActualInitStep(s->memory, &h);
    return h == 0.0 ? INFINITY : 1.0 / fabs(h);
}

/* Where s knows: the c of that step, and the direction; NULL where iterations failed. The
 * velocities of y begin at `first`. */
static const double *recall(const mbsri_stiff *s, int first, double *c)
{
    IDAGetCurrentCj(s->memory, c);
    *c = fabs(*c);
    if (!s->blame.of_iteration) return N_VGetArrayPointer(s->blame.direction) + first;
    if (s->blame.slowest > 0.0) *c = fmin(*c, s->blame.slowest);
    return NULL;
}

/* The elements at the state s->change at t, which is where s knows or not. */
static int ask(mbsri_stiff *s, const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
               double t, bool known, int most, int *force, double *share, int *count)
{
    const int nq = mbsr_model_nq(model), nu = mbsr_model_nu(model);
    place p = {.model = model,
               .data = data,
               .t = t,
               .c = slowest(s),
               .state = N_VGetArrayPointer(s->filtered),
               .v = N_VGetArrayPointer(s->trial),
               .work = N_VGetArrayPointer(s->change),
               .stiffness = s->blame.stiffness};
    const int first = form == MBSR_DAE_MOMENTUM ? nq + nu : nq; /* of velocities */
    const double *direction = known ? recall(s, first, &p.c) : NULL;
    const int status = mbsr_dae_unpack(model, data, form, t, p.work, p.state, p.state + nq);
    return status ? status : rank(&p, direction, most, force, share, count);
}

/* ---- of the driver ---- */

int mbsr_ida_stiffest(mbsr_ida *ida, int most, int *force, double *share, int *count)
{
    if (!ida || !count || (most > 0 && (!force || !share))) return MBSR_ERR_NULL;
    mbsri_stiff *s = mbsri_stiff_of(ida->nonlinear);
    const mbsr_dae_form form = ida->opt.form;
    int status = MBSR_OK;
    *count = 0;
    if (form != MBSR_DAE_INDEX1 && knows(s)) {
        N_VScale(1.0, s->blame.state, s->change);
        mbsri_ida_add_shift(ida, s->blame.at, 0, s->change);
        status = ask(s, ida->model, ida->data, form, s->blame.at, true, most, force, share, count);
    }
    if (ida->run.failed && ida->failing.callback == MBSR_OK && *count == 0) {
        N_VScale(1.0, ida->y, s->change);
        status =
            ask(s, ida->model, ida->data, form, ida->run.present, false, most, force, share, count);
    }
    if (!status) return MBSR_OK;
    return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(ida->data), "mbsr_ida_stiffest");
}

/* What fails, after a flag of IDA. */
static const char *what_fails(const mbsr_ida *ida, int flag)
{
    bool iterations = flag != IDA_ERR_FAIL;
    if (flag == IDA_TOO_MUCH_WORK) iterations = mbsri_stiff_of(ida->nonlinear)->blame.of_iteration;
    return iterations ? "Newton's method fails" : "error tests fail";
}

void mbsri_ida_blame_stiff(mbsr_ida *ida, int flag)
{
    int force[2], count = 0;
    double share[2];
    const mbsr_error before = ida->error;
    const int status = mbsr_ida_stiffest(ida, 2, force, share, &count);
    ida->error = before;
    if (status || count == 0) return;
    char second[40] = "";
    if (count > 1 && share[1] > 0.1)
        snprintf(second, sizeof second, " and %d (%.0f %%)", force[1], 100.0 * share[1]);
    const int code = before.status;
    mbsri_ida_fail(&ida->error, code, before.body, force[0],
                   "%.120s; %s by the stiffness of force element %d (%.0f %%)%s: "
                   "make it a stiff closure (as_closure), or softer",
                   before.text, what_fails(ida, flag), force[0], 100.0 * share[0], second);
}

/* ---- of an IDA of one's own ---- */

/* The state: where s knows, or the end of the last step, if some attempt has failed since the
 * start. */
static bool find_state(mbsri_stiff *s, bool known, N_Vector y, double *t)
{
    long tests = 0, iterations = 0;
    if (!s->memory) return false;
    *t = s->blame.at;
    if (known) N_VScale(1.0, s->blame.state, y);
    if (known) return true;
    IDAGetNumErrTestFails(s->memory, &tests);
    IDAGetNumNonlinSolvConvFails(s->memory, &iterations);
    return tests + iterations > 0 && IDAGetCurrentTime(s->memory, t) >= 0 &&
           IDAGetDky(s->memory, *t, 0, y) >= 0;
}

int mbsr_sundials_stiffest(SUNNonlinearSolver solver, const mbsr_model *model, mbsr_data *data,
                           int most, int *force, double *share, int *count)
{
    if (!solver || !model || !data || !count || (most > 0 && (!force || !share)))
        return MBSR_ERR_NULL;
    mbsri_stiff *s = mbsri_stiff_of(solver);
    if (!s || s->blame.forces != mbsr_model_forces(model) ||
        N_VGetLength(s->change) != mbsr_dae_size(model, MBSR_DAE_MOMENTUM))
        return MBSR_ERR_VALUE;
    const bool known = knows(s);
    double t = 0.0;
    *count = 0;
    if (!find_state(s, known, s->change, &t)) return MBSR_OK;
    return ask(s, model, data, MBSR_DAE_MOMENTUM, t, known, most, force, share, count);
}
