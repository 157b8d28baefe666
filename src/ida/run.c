/* Runs over output times.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/advance.h"
#include "ida/error.h"
#include "ida/first_step.h"
#include "ida/outputs.h"

#include <time.h>

#include <math.h>

static int refuse_times(mbsr_ida *ida, int k, double time, const char *why)
{
    return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE, "mbsr_ida_run: times[%d] is %.17g, %s", k,
                            time, why);
}

static int check_times(mbsr_ida *ida, int count, const double *times, const int *next)
{
    if (*next < 0 || *next > count)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE, "mbsr_ida_run: next is %d of %d times",
                                *next, count);
    if (count > *next && !times)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_NULL, "mbsr_ida_run: times is NULL");
    double last = ida->run.present, direction = ida->run.stepped ? ida->run.direction : 0.0;
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
    if (!next || !output)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_NULL, "mbsr_ida_run: %s is NULL",
                                !next ? "next" : "output");
    if (!ida->run.started)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_SEQUENCE,
                                "mbsr_ida_run: call mbsr_ida_start first");
    int status = check_times(ida, count, times, next);
    while (!status && *next < count) {
        const int k = *next;
        if (!mbsri_ida_same_time(times[k], ida->run.present)) {
            status = mbsri_ida_advance(ida, times[k]);
            if (status) return status;
        }
        mbsri_ida_complete(ida);
        ++*next;
        status = output(user, k, ida->run.present, N_VGetArrayPointer(mbsri_ida_output_y(ida)),
                        N_VGetArrayPointer(mbsri_ida_output_yp(ida)));
        if (!status) continue;
        mbsri_ida_refuse(&ida->error, status,
                         "mbsr_ida_run: the output function at t = %.10g returned %d",
                         ida->run.present, status);
    }
    return status;
}

int mbsr_ida_state(mbsr_ida *ida, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!ida->run.started && !ida->run.failed)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_SEQUENCE,
                                "mbsr_ida_state: call mbsr_ida_start first");
    mbsri_ida_put(ida, t, y, yp);
    return MBSR_OK;
}
