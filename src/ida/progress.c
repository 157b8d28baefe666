/* The word between two steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/progress.h"

#include "ida/error.h"

#include <math.h>
#include <time.h>

/* s since some day in the past. */
static double now(void)
{
    struct timespec time = {0};
    timespec_get(&time, TIME_UTC);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void mbsri_ida_report_anew(mbsr_ida *ida)
{
    ida->report.steps = 0;
    ida->report.stopped = false;
    ida->report.still = 0;
    if (ida->opt.progress && ida->opt.progress_interval > 0.0) ida->report.at = now();
}

/* A clock set back must not silence the function. */
static bool too_early(mbsr_ida *ida)
{
    if (!(ida->opt.progress_interval > 0.0)) return false;
    const double time = now(), since = time - ida->report.at;
    if (since >= 0.0 && since < ida->opt.progress_interval) return true;
    ida->report.at = time;
    return false;
}

/* The body whose rates are most beside their tolerances; MBSR_NONE: none moves. */
static int fastest_body(const mbsr_ida *ida, N_Vector y)
{
    const double *u = N_VGetArrayPointer(y), *atol = N_VGetArrayPointer(ida->tol.atol);
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model),
              from = ida->opt.form == MBSR_DAE_MOMENTUM ? nq + nu : nq;
    int fastest = MBSR_NONE;
    double most = 0.0;
    for (int i = 0; i < mbsr_model_bodies(ida->model); ++i) {
        int first, n;
        mbsr_body_coordinates(ida->model, i, NULL, NULL, &first, &n);
        for (int k = from + first; k < from + first + n; ++k) {
            if (fabs(u[k]) <= most * atol[k]) continue;
            most = fabs(u[k]) / atol[k];
            fastest = i;
        }
    }
    return fastest;
}

int mbsri_ida_watch_steps(mbsr_ida *ida, N_Vector y)
{
    enum { PATIENCE = 10000 };
    long steps = 0;
    double t = 0.0, step = 0.0;
    IDAGetNumSteps(ida->memory, &steps);
    IDAGetCurrentTime(ida->memory, &t);
    IDAGetLastStep(ida->memory, &step);
    ida->report.still = steps > 0 && t - step == t ? ida->report.still + 1 : 0;
    if (ida->report.still < PATIENCE) return MBSR_OK;
    const int body = fastest_body(ida, y);
    ida->failing.callback = MBSR_ERR_SOLVER;
    return mbsri_ida_fail(
        &ida->failing.failure, MBSR_ERR_SOLVER, body, MBSR_NONE,
        "%d steps in a row do not move the time, %.10g: nothing goes on there, as "
        "where a damper lets go of what has no mass; the rates of body %d are the "
        "largest beside their tolerances",
        PATIENCE, t, body);
}

int mbsri_ida_report(mbsr_ida *ida)
{
    if (!ida->opt.progress) return MBSR_OK;
    long steps = 0;
    IDAGetNumSteps(ida->memory, &steps);
    if (steps == 0) return MBSR_OK; /* IDA starts, or starts anew: it knows no last step */
    mbsr_ida_progress progress = {.steps = ida->count.before.steps + steps};
    if (progress.steps < ida->report.steps + ida->opt.progress_steps || too_early(ida))
        return MBSR_OK;
    ida->report.steps = progress.steps;
    IDAGetCurrentTime(ida->memory, &progress.t);
    IDAGetLastStep(ida->memory, &progress.step);
    IDAGetLastOrder(ida->memory, &progress.order);
    const int status = ida->opt.progress(ida->opt.progress_user, &progress);
    if (!status) return MBSR_OK;
    ida->report.stopped = true;
    ida->failing.callback = status;
    return mbsri_ida_refuse(&ida->failing.failure, status,
                            "the progress function at t = %.10g returned %d", progress.t, status);
}
