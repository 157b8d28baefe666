/* The word between two steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/progress.h"

#include "ida/error.h"

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
