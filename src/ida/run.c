/* Runs over output times, and the word between two steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "driver.h"

#include <math.h>
#include <string.h>
#include <time.h>

/* ---- between two steps ---- */

/* s since some day in the past. */
static double now(void)
{
    struct timespec time = {0};
    timespec_get(&time, TIME_UTC);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void mbsri_ida_report_anew(mbsr_ida *ida)
{
    ida->reported = 0;
    ida->stopped = false;
    if (ida->opt.progress && ida->opt.progress_interval > 0.0) ida->reported_at = now();
}

/* A clock set back must not silence the function. */
static bool too_early(mbsr_ida *ida)
{
    if (!(ida->opt.progress_interval > 0.0)) return false;
    const double time = now(), since = time - ida->reported_at;
    if (since >= 0.0 && since < ida->opt.progress_interval) return true;
    ida->reported_at = time;
    return false;
}

int mbsri_ida_report(mbsr_ida *ida)
{
    if (!ida->opt.progress) return MBSR_OK;
    long steps = 0;
    IDAGetNumSteps(ida->memory, &steps);
    if (steps == 0) return MBSR_OK; /* IDA starts, or starts anew: it knows no last step */
    mbsr_ida_progress progress = {.steps = ida->before.steps + steps};
    if (progress.steps < ida->reported + ida->opt.progress_steps || too_early(ida)) return MBSR_OK;
    ida->reported = progress.steps;
    IDAGetCurrentTime(ida->memory, &progress.t);
    IDAGetLastStep(ida->memory, &progress.step);
    IDAGetLastOrder(ida->memory, &progress.order);
    const int status = ida->opt.progress(ida->opt.progress_user, &progress);
    if (!status) return MBSR_OK;
    ida->stopped = true;
    ida->callback = status;
    return mbsri_ida_fail(&ida->failure, status, MBSR_NONE, MBSR_NONE,
                          "the progress function at t = %.10g returned %d", progress.t, status);
}

/* ---- over output times ---- */

static int refuse_times(mbsr_ida *ida, int k, double time, const char *why)
{
    return mbsri_ida_fail(&ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_ida_run: times[%d] is %.17g, %s", k, time, why);
}

static int check_times(mbsr_ida *ida, int count, const double *times, const int *next)
{
    if (*next < 0 || *next > count) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_run: next is %d of %d times", *next, count);
    }
    if (count > *next && !times) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_run: times is NULL");
    }
    double last = ida->present, direction = ida->stepped ? ida->direction : 0.0;
    for (int k = *next; k < count; ++k) {
        if (!isfinite(times[k])) return refuse_times(ida, k, times[k], "not finite");
        if (!mbsri_ida_same_time(times[k], last)) {
            const double way = times[k] > last ? 1.0 : -1.0;
            if (direction == 0.0) direction = way;
            if (way != direction) return refuse_times(ida, k, times[k], "behind the time before");
            last = times[k];
        }
    }
    return MBSR_OK;
}

int mbsr_ida_run(mbsr_ida *ida, int count, const double *times, int *next,
                 mbsr_ida_output_fn output, void *user)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!next || !output) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_run: %s is NULL", !next ? "next" : "output");
    }
    if (!ida->started) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_run: call mbsr_ida_start first");
    }
    int status = check_times(ida, count, times, next);
    while (!status && *next < count) {
        const int k = *next;
        if (!mbsri_ida_same_time(times[k], ida->present)) {
            status = mbsri_ida_advance(ida, times[k]);
            if (status) return status;
        }
        ++*next;
        status =
            output(user, k, ida->present, N_VGetArrayPointer(ida->y), N_VGetArrayPointer(ida->yp));
        if (!status) continue;
        mbsri_ida_fail(&ida->error, status, MBSR_NONE, MBSR_NONE,
                       "mbsr_ida_run: the output function at t = %.10g returned %d", ida->present,
                       status);
    }
    return status;
}

int mbsr_ida_state(mbsr_ida *ida, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!ida->started) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_state: call mbsr_ida_start first");
    }
    mbsri_ida_put(ida, t, y, yp);
    return MBSR_OK;
}
