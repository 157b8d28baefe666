/* Start of a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/drift.h"
#include "ida/error.h"
#include "ida/shift.h"
#include "ida/linear.h"
#include "ida/loops.h"
#include "ida/outputs.h"
#include "ida/progress.h"
#include "ida/stiff.h"
#include "ida/tolerances.h"
#include "ida/watch.h"

#include <mbsrank/index.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Refuses a start that is not finite; names the first wrong entry. */
static int check_start(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    if (!isfinite(t))
        return mbsri_ida_refuse(&ida->error, MBSR_NOT_FINITE, "mbsr_ida_start: t is %g", t);
    for (int k = 0; k < ida->size; ++k) {
        if (isfinite(y[k]) && isfinite(yp[k])) continue;
        const bool rate = isfinite(y[k]);
        return mbsri_ida_refuse(&ida->error, MBSR_NOT_FINITE, "mbsr_ida_start: %s[%d] is %g",
                                rate ? "yp" : "y", k, rate ? yp[k] : y[k]);
    }
    return MBSR_OK;
}

/* Tells IDA which variables are algebraic; an IDA flag. `work` serves for the vector IDA copies. */
static int identify(mbsr_ida *ida)
{
    const int status =
        mbsr_dae_id(ida->model, ida->data, ida->opt.form, N_VGetArrayPointer(ida->work));
    if (status) return IDA_ILL_INPUT;
    const int flag = IDASetId(ida->memory, ida->work);
    return flag < 0 ? flag : IDASetSuppressAlg(ida->memory, ida->opt.suppress_algebraic != 0);
}

/* The residual at the start, which tells the ranks of the joint blocks. */
static int evaluate_residual(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    const int status = mbsr_dae_residual(ida->model, ida->data, ida->opt.form, t, y, yp,
                                         N_VGetArrayPointer(ida->work));
    if (!status) return MBSR_OK;
    return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(ida->data),
                             "mbsr_ida_start: residual at t = %.10g", t);
}

/* Names the first direction of a report that nothing determines, with what the report advises. */
static int refuse_undetermined(mbsr_ida *ida, const mbsr_index_report *report)
{
    const mbsr_direction *direction = report->direction;
    const char *first = strstr(report->text, "give it");
    char advice[128] = "";
    if (first) snprintf(advice, sizeof advice, "%.*s", (int)strcspn(first, "\n"), first);
    const mbsr_direction_term *term = direction->term;
    for (int k = 1; k < direction->terms; ++k) {
        if (fabs(direction->term[k].weight) > fabs(term->weight)) term = direction->term + k;
    }
    return mbsri_ida_fail(
        &ida->error, MBSR_UNDETERMINED, term->body, MBSR_NONE,
        "mbsr_ida_start: u%d of body %d '%.40s' moves no mass, and no force resists it%s: %s "
        "(mbsr_index_report_create names all)",
        term->coordinate, term->body, mbsr_body_name(ida->model, term->body),
        direction->terms > 1 ? " together with others" : "", advice);
}

static int refuse_memory(mbsr_ida *ida)
{
    return mbsri_ida_refuse(&ida->error, MBSR_ERR_NO_MEMORY, "mbsr_ida_start: %s",
                            mbsr_data_error(ida->data)->text);
}

/* Refuses a start with joint rates that neither mass nor force determines: no step would lead from
 * it. Only where ranks are deficient, and where the Newton solver, if there is one, finds its
 * equations singular, the index report decides; what it cannot tell is no reason to refuse. */
static int check_determined(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    static const double c = 1e3; /* 1/s */
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    double *q = N_VGetArrayPointer(ida->displaced), *u = q + nq;
    if (mbsr_total_rank(ida->model, ida->data) == nu || mbsr_model_rows(ida->model) > 0)
        return MBSR_OK;
    mbsr_newton *newton = ida->linear.link.newton;
    mbsr_index_report *report = NULL;
    int status = MBSR_OK;
    if (!newton || mbsr_newton_factor(newton, ida->data, t, y, yp, c) == MBSR_SINGULAR_BLOCK) {
        status = mbsr_dae_unpack(ida->model, ida->data, ida->opt.form, t, y, q, u);
        if (!status) status = mbsr_index_report_create(ida->model, ida->data, t, q, u, &report);
        if (status == MBSR_ERR_NO_MEMORY) return refuse_memory(ida);
        const bool refused = report && report->undetermined > 0;
        status = refused ? refuse_undetermined(ida, report) : MBSR_OK;
        mbsr_index_report_destroy(ida->model, report);
    }
    const bool moved_on = ida->opt.form != MBSR_DAE_INVERSE_DYNAMICS;
    return !status && moved_on ? evaluate_residual(ida, t, y, yp) : status;
}

/* Refuses a start at which the forces along directions without mass do not balance: by more than a
 * thousandth of themselves, so that Newton's method would change the state by this many tolerances.
 * IDA would take the step for one that is too long, and shorten it for ever. */
static int check_balance(mbsr_ida *ida, double t, const double *y)
{
    static const double imbalance = 1e-3, tolerances = 1e4;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const int momenta = ida->opt.form == MBSR_DAE_MOMENTUM ? nu : 0;
    double *dq = N_VGetArrayPointer(ida->displaced), *du = dq + nq, share = 0.0, worst = 0.0;
    int body = MBSR_NONE;
    if (mbsr_total_rank(ida->model, ida->data) == nu || mbsr_model_rows(ida->model) > 0)
        return MBSR_OK;
    mbsr_data *data = ida->data;
    const mbsr_dae_form form = ida->opt.form;
    int status = mbsr_dae_imbalance(ida->model, data, form, t, y, &share, &body, NULL, NULL);
    if (!status && share > imbalance)
        status = mbsr_dae_imbalance(ida->model, data, form, t, y, &share, &body, dq, du);
    if (status == MBSR_ERR_NO_MEMORY) return refuse_memory(ida);
    if (status || !(share > imbalance)) return MBSR_OK; /* the residual says why */
    for (int k = 0; k < nq; ++k) worst = fmax(worst, fabs(dq[k]) / mbsri_ida_tolerance(ida, y, k));
    for (int k = 0; k < nu; ++k)
        worst = fmax(worst, fabs(du[k]) / mbsri_ida_tolerance(ida, y, nq + momenta + k));
    if (!(worst > tolerances)) return MBSR_OK;
    return mbsri_ida_fail(
        &ida->error, MBSR_NO_CONVERGENCE, body, MBSR_NONE,
        "mbsr_ida_start: body %d '%.40s': the forces along directions of its joint that move no "
        "mass do not balance at t = %g (%.2g of them is left): start where mbsr_dae_consistent "
        "leads",
        body, mbsr_body_name(ida->model, body), t, share);
}

/* In the recursive form nothing is done about stiff elements where ranks are deficient: differences
 * over coordinates, as careful steps take them, would change these. */
static void choose_care(mbsr_ida *ida)
{
    mbsri_stiff *s = mbsri_stiff_of(ida->nonlinear);
    const bool deficient = mbsr_total_rank(ida->model, ida->data) < mbsr_model_nu(ida->model);
    if (ida->opt.form != MBSR_DAE_RECURSIVE) return;
    s->test = deficient ? MBSRI_TEST_PLAIN : MBSRI_TEST_FILTERED;
    s->control.care = deficient ? MBSRI_CARE_NEVER : MBSRI_CARE_BY_SIGNS;
}

/* What the start itself says of the run: whether there can be one, tolerances of the momenta, the
 * ranks to watch. The inverse-dynamics form knows no ranks. */
static int prepare(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    const bool ranks = ida->opt.form != MBSR_DAE_INVERSE_DYNAMICS;
    ida->watch = 0;
    mbsri_ida_exchange_watch(ida);
    int status = ranks ? evaluate_residual(ida, t, y, yp) : MBSR_OK;
    if (!status) choose_care(ida);
    if (!status) status = check_balance(ida, t, y);
    if (!status) status = check_determined(ida, t, y, yp);
    if (!status && ranks && ida->tol.scales) status = mbsri_ida_scale_tolerances(ida);
    if (!status && mbsr_model_rows(ida->model) > 0) mbsri_ida_take_care(ida);
    if (!status && ranks && ida->opt.watch_ranks) mbsr_rank_watch(ida->model, ida->data, 1);
    mbsri_ida_exchange_watch(ida);
    return status;
}

int mbsr_ida_start(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!y || !yp)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_NULL, "mbsr_ida_start: %s is NULL",
                                !y ? "y" : "yp");
    int status = check_start(ida, t, y, yp);
    if (status) return status;
    ida->run.started = ida->run.failed =
        false; /* what fails here has lost the ranks of an earlier run */
    mbsri_ida_drift_start(ida, t, y);
    status = prepare(ida, t, y, yp);
    if (status) return status;
    const size_t bytes = (size_t)ida->size * sizeof *y;
    memmove(N_VGetArrayPointer(ida->y), y, bytes);
    memmove(N_VGetArrayPointer(ida->yp), yp, bytes);
    ida->failing.message[0] = '\0';
    ida->run.stepped = ida->run.event = false;
    ida->count.residuals = ida->count.events = ida->count.central_residuals = 0;
    ida->count.before = (mbsr_ida_stats){0};
    mbsri_ida_count_solver(ida, &ida->linear.newton_before);
    mbsri_ida_keep_start(ida);
    mbsri_stiff_of(ida->nonlinear)->info = (mbsr_sundials_stiff_info){0};
    mbsri_ida_report_anew(ida);
    mbsri_ida_forget_kinks(ida);
    ida->failing.wall = INFINITY;
    ida->run.present = ida->output.since = t;
    mbsri_ida_forget_output(ida);
    ida->output.raw = 0;
    int flag = IDAReInit(ida->memory, t, ida->y, ida->yp);
    if (flag >= 0) flag = identify(ida);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_start");
    ida->run.started = true;
    return MBSR_OK;
}
