/* Kinks: see kinks.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/kinks.h"

#include "ida/shift.h"
#include "ida/count.h"
#include "ida/error.h"
#include "ida/first_step.h"
#include "ida/tolerances.h"
#include "ida/watch.h"

#include <mbsrank/dynamics.h>

#include <float.h>
#include <math.h>
#include <string.h>

/* Where this derivative jumps IDA starts anew; where a higher one does, a step that ends there is
 * all that may be wanted, and across the points of a smooth table IDA finds its way with fewer. */
enum { RESTART = 1 };

/* Restarts without another look where c did not serve. */
enum { PATIENCE = 8 };

/* ---- the next kink ---- */

/* Of the caller's function. */
static int ask(mbsr_ida *ida, double t, mbsr_kink *next)
{
    *next = (mbsr_kink){ida->run.direction * INFINITY, 1};
    const int status = ida->opt.kink
                           ? ida->opt.kink(ida->opt.kink_user, t, (int)ida->run.direction, next)
                           : MBSR_OK;
    if (status)
        return mbsri_ida_refuse(&ida->error, status,
                                "mbsr_ida_advance: the function of kinks at t = %.10g returned %d",
                                t, status);
    if ((next->t - t) * ida->run.direction > 0.0 && next->derivative > 0) return MBSR_OK;
    return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE,
                            "mbsr_ida_advance: the next kink after t = %.17g is at %.17g, in "
                            "derivative %d",
                            t, next->t, next->derivative);
}

/* Of the function and of the tables in the model. */
static int find_after(mbsr_ida *ida, double t, mbsr_kink *first)
{
    mbsr_kink next;
    int status = ask(ida, t, &next);
    do {
        mbsr_model_kink(ida->model, t, (int)ida->run.direction, first);
        t = first->t;
    } while (first->derivative > RESTART);
    if ((first->t - next.t) * ida->run.direction > 0.0 || first->t == next.t) {
        const int other = first->t == next.t ? first->derivative : next.derivative;
        *first = next;
        if (other < first->derivative) first->derivative = other;
    }
    return status;
}

/* The first kink after t, or the end of the sample if that is sooner. */
static int find_next(mbsr_ida *ida, double t)
{
    mbsri_ida_kinks *k = &ida->kinks;
    const double far = ida->run.direction * INFINITY;
    mbsr_kink next = {.t = t};
    do { /* what is no further away than rounding has been reached */
        const int status = find_after(ida, next.t, &next);
        if (status) return status;
    } while (next.t != far && mbsri_ida_same_time(next.t, t));
    k->at = k->sampled ? k->end : far;
    k->derivative = 0;
    if (next.t != far &&
        ((next.t - k->at) * ida->run.direction < 0.0 || mbsri_ida_same_time(next.t, k->at))) {
        k->at = next.t;
        k->derivative = next.derivative;
    }
    k->gap = 16.0 * DBL_EPSILON * fmax(fabs(k->at), fabs(k->at - t));
    k->known = true;
    return MBSR_OK;
}

void mbsri_ida_arrive(mbsr_ida *ida)
{
    mbsri_ida_note_step(ida);
    ida->run.present = ida->kinks.at;
    ida->kinks.reached = true;
    ida->kinks.known = false;
}

/* ---- the state behind a kink ---- */

/* At t for q, p in y and a first u there: u is found, and `rate` has q', p', then u. Corrections of
 * u come from K = dF/dy + c dF/dy', which is factored at a large c, where those of q and p are
 * nothing beside them. False where they do not become small. */
static bool find_rates(mbsr_ida *ida, double t, N_Vector y, N_Vector rate)
{
    enum { MOST = 8 };
    static const double small = 1e-3; /* in tolerances */
    const int n = mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    double *F = N_VGetArrayPointer(rate), *r = N_VGetArrayPointer(ida->kinks.right),
           *delta = N_VGetArrayPointer(ida->work), *u = N_VGetArrayPointer(y), largest = INFINITY;
    for (int l = 0; l < MOST && !(largest < small); ++l) {
        ++ida->count.residuals;
        if (mbsr_dae_residual(ida->model, ida->data, ida->opt.form, t, u,
                              N_VGetArrayPointer(ida->zero), F))
            return false;
        for (int k = 0; k < ida->size; ++k) r[k] = k < n ? 0.0 : F[k];
        if (mbsr_newton_solve(ida->linear.link.newton, r, delta)) return false;
        largest = 0.0;
        for (int k = n; k < ida->size; ++k) {
            u[k] -= delta[k];
            largest = fmax(largest, fabs(delta[k]) / mbsri_ida_tolerance(ida, u, k));
        }
    }
    for (int k = 0; k < ida->size; ++k) F[k] = k < n ? -F[k] : u[k];
    return largest < small;
}

/* u and y' at t by the Newton solver, q and p in y. A factorisation is left for find_rates. */
static bool settle_velocities(mbsr_ida *ida, double t, double span)
{
    const int n = mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    mbsri_ida_kinks *k = &ida->kinks;
    double step = 0.0;
    if (!ida->linear.link.newton || mbsr_model_rows(ida->model) > 0) return false;
    IDAGetLastStep(ida->memory, &step);
    step = fmin(span, step != 0.0 ? fabs(step) : 1e-3 * ida->tol.time);
    N_VScale(1.0, ida->y, k->ahead);
    if (mbsr_newton_factor(ida->linear.link.newton, ida->data, t, N_VGetArrayPointer(ida->y),
                           N_VGetArrayPointer(ida->yp), 1e6 * ida->run.direction / step) ||
        !find_rates(ida, t, k->ahead, k->node[0]))
        return false;
    N_VScale(1.0, k->ahead, ida->y);
    memcpy(N_VGetArrayPointer(ida->yp), N_VGetArrayPointer(k->node[0]), (size_t)n * sizeof(double));
    return true;
}

/* p of q, u at t, from the positions on. */
static int momenta(mbsr_ida *ida, double t, const double *q, const double *u, double *p)
{
    int status = mbsr_stage_positions(ida->model, ida->data, t, q);
    if (!status) status = mbsr_stage_velocities(ida->model, ida->data, u);
    return status ? status : mbsr_momenta(ida->model, ida->data, p);
}

/* Changes u so that the momenta at t are those p before: u += M^+ (p - p(q, u, t)). They differ
 * where prescribed velocities jump. */
static int keep_momenta(mbsr_ida *ida, double t, const double *q, double *u, const double *p)
{
    const int nu = mbsr_model_nu(ida->model);
    double *jump = u + 2 * nu, *rate = u + 3 * nu;
    int status = momenta(ida, t, q, u, jump);
    if (status) return status;
    for (int k = 0; k < nu; ++k) jump[k] = p[k] - jump[k];
    for (int sign = 1; sign >= -1; sign -= 2) {
        status =
            mbsr_forward_dynamics(ida->model, ida->data, t, q, u, sign > 0 ? jump : NULL, rate);
        if (status && status != MBSR_UNDETERMINED) return status;
        if (sign > 0) memcpy(jump, rate, (size_t)nu * sizeof *rate);
    }
    for (int k = 0; k < nu; ++k) u[k] += jump[k] - rate[k];
    return MBSR_OK;
}

/* The same for any form, by a consistent start. `before`: time of y. */
static int start_again(mbsr_ida *ida, double before, double t)
{
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    double *q = N_VGetArrayPointer(ida->kinks.work), *u = q + nq, *p = u + nu,
           *y = N_VGetArrayPointer(ida->y);
    int status = mbsr_dae_unpack(ida->model, ida->data, ida->opt.form, before, y, q, u);
    if (ida->opt.form == MBSR_DAE_MOMENTUM)
        memcpy(p, y + nq, (size_t)nu * sizeof *p);
    else if (!status)
        status = momenta(ida, before, q, u, p);
    if (!status) status = keep_momenta(ida, t, q, u, p);
    if (!status) status = mbsr_dae_pack(ida->model, ida->data, ida->opt.form, t, q, u, y);
    if (status) return status;
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    opt.side = (int)ida->run.direction;
    return mbsr_dae_consistent(ida->model, ida->data, ida->opt.form, t, y,
                               N_VGetArrayPointer(ida->yp), &opt, NULL);
}

static int refuse_kink(mbsr_ida *ida, int status)
{
    const mbsr_error *error = mbsr_data_error(ida->data);
    N_VScale(1.0, ida->run.first_y, ida->y);
    N_VScale(1.0, ida->run.first_yp, ida->yp);
    ida->run.started = false;
    ida->run.failed = true;
    return mbsri_ida_pass_on(&ida->error, status, error,
                             "mbsr_ida_advance: behind the kink at t = %.10g", ida->run.present);
}

/* ---- c ---- */

/* The rates of node j, at x(t) + s sum of weights times the rates of the nodes. */
static bool look_ahead(mbsr_ida *ida, double t, double s, int j, double w0, double w1)
{
    mbsri_ida_kinks *k = &ida->kinks;
    const int n = mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    const double *f0 = N_VGetArrayPointer(k->node[0]), *f1 = N_VGetArrayPointer(k->node[1]);
    const bool first = j == 1 && w1 == 0.0;
    double *x = N_VGetArrayPointer(k->ahead);
    N_VScale(1.0, ida->y, k->ahead);
    for (int l = 0; l < n; ++l) x[l] += s * w0 * f0[l] + (first ? 0.0 : s * w1 * f1[l]);
    for (int l = n; l < ida->size && !first; ++l) x[l] = j == 1 ? f1[l] : 2.0 * f1[l] - f0[l];
    return find_rates(ida, t + j * s, k->ahead, k->node[j]);
}

/* y'' and y''' at t, and u', from nodes at t, t + s, t + 2 s; whether c serves for the span. The
 * states there are of the third order in s. After `settle`. */
static bool find_shift(mbsr_ida *ida, double t, double s, double span)
{
    mbsri_ida_kinks *k = &ida->kinks;
    const int n = mbsr_model_nq(ida->model) + mbsr_model_nu(ida->model);
    if (!look_ahead(ida, t, s, 1, 1.0, 0.0) || !look_ahead(ida, t, s, 1, 0.5, 0.5) ||
        !look_ahead(ida, t, s, 2, 0.0, 2.0))
        return false;
    const double *f0 = N_VGetArrayPointer(k->node[0]), *f1 = N_VGetArrayPointer(k->node[1]),
                 *f2 = N_VGetArrayPointer(k->node[2]);
    double *yp = N_VGetArrayPointer(ida->yp), *second = N_VGetArrayPointer(k->c_derivative[0]),
           *third = N_VGetArrayPointer(k->c_derivative[1]);
    for (int l = 0; l < ida->size; ++l) {
        const double first = (-1.5 * f0[l] + 2.0 * f1[l] - 0.5 * f2[l]) / s,
                     next = (f0[l] - 2.0 * f1[l] + f2[l]) / (s * s);
        if (l >= n) yp[l] = first;
        second[l] = l < n ? first : next;
        third[l] = l < n ? next : 0.0;
    }
    return mbsri_ida_norm(ida, n, third) * span < mbsri_ida_norm(ida, n, second);
}

/* ---- restart ---- */

/* The longest h up to `step` with which h, h, 2 h, 4 h .. fill the span. */
static double fit(double step, double span)
{
    double h = span;
    for (int n = 0; n < 8 && h > step; ++n) h *= 0.5;
    return fmin(h, step);
}

/* IDA starts anew at t, up to the next kink, which is `span` away. */
static int restart(mbsr_ida *ida, double t, double span, bool settled)
{
    static const double many = 1e3; /* beyond so many first steps order 1 does not matter */
    mbsri_ida_kinks *k = &ida->kinks;
    mbsri_ida_count(ida, &ida->count.before);
    k->shifted = false;
    const double usual = mbsri_ida_longest_first_step(ida),
                 longest = isfinite(span) ? fmax(usual, span / 8.0) : usual;
    double step = mbsri_ida_first_step(ida, ida->run.direction, longest);
    if (k->patience > 0) --k->patience;
    if (settled && k->patience == 0 && span < many * step) {
        k->shifted = find_shift(ida, t, ida->run.direction * span / 16.0, span);
        if (!k->shifted) k->patience = PATIENCE;
    }
    if (k->shifted && k->step > 0.0) step = 2.0 * k->step;
    k->from = ida->output.since = t;
    mbsri_ida_keep_start(ida);
    const int flag = IDAReInit(ida->memory, t, ida->y, ida->yp);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
    IDASetInitStep(ida->memory, ida->run.direction * fit(step, span));
    return MBSR_OK;
}

int mbsri_ida_leave_kink(mbsr_ida *ida)
{
    mbsri_ida_kinks *k = &ida->kinks;
    const double way = ida->run.direction, here = ida->run.present, gap = k->reached ? k->gap : 0.0,
                 after = here + way * gap;
    const bool anew = k->requested || (k->reached && k->derivative > 0 && k->derivative <= RESTART);
    int status = k->known ? MBSR_OK : find_next(ida, here);
    if (!status && anew) {
        const double span = fabs(k->at - here);
        mbsri_ida_keep_start(ida);
        N_VLinearSum(1.0, ida->y, 2.0 * way * gap, ida->yp, ida->y);
        const bool settled = settle_velocities(ida, after, span);
        if (!settled) status = start_again(ida, here - way * gap, after);
        if (status) return refuse_kink(ida, status);
        status = restart(ida, after, span, settled);
    }
    if (status) return status;
    k->requested = k->reached = false;
    if (k->aimed || isfinite(k->at)) {
        IDASetStopTime(ida->memory, isfinite(k->at) ? k->at - way * k->gap : way * DBL_MAX);
        k->aimed = true;
    }
    return MBSR_OK;
}
