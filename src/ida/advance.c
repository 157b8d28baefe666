/* Integration.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/advance.h"

#include "ida/shift.h"
#include "ida/count.h"
#include "ida/drift.h"
#include "ida/error.h"
#include "ida/first_step.h"
#include "ida/kinks.h"
#include "ida/loops.h"
#include "ida/outputs.h"
#include "ida/stiffest.h"
#include "ida/tolerances.h"
#include "ida/watch.h"

#include <mbsrank/driver.h>

#include <float.h>
#include <math.h>
#include <string.h>

static int check_target(mbsr_ida *ida, double t_end, const char *function)
{
    if (!isfinite(t_end))
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE, "%s: t_end is %g", function, t_end);
    if (!ida->run.started)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_SEQUENCE, "%s: call mbsr_ida_start first",
                                function);
    return MBSR_OK;
}

void mbsri_ida_put(mbsr_ida *ida, double *t, double *y, double *yp)
{
    if (y || yp) mbsri_ida_complete(ida);
    const size_t bytes = (size_t)ida->size * sizeof *y;
    if (t) *t = ida->run.present;
    if (y) memcpy(y, N_VGetArrayPointer(mbsri_ida_output_y(ida)), bytes);
    if (yp) memcpy(yp, N_VGetArrayPointer(mbsri_ida_output_yp(ida)), bytes);
}

static bool finite_state(const mbsr_ida *ida, N_Vector y, N_Vector yp)
{
    const double *a = N_VGetArrayPointer(y), *b = N_VGetArrayPointer(yp);
    int k = 0;
    while (k < ida->size && isfinite(a[k]) && isfinite(b[k])) ++k;
    return k == ida->size;
}

/* The last state that was good, the end of the last step or else the start, becomes that of the
 * driver, for mbsr_ida_state. */
static void keep_last(mbsr_ida *ida)
{
    void *const memory = ida->memory;
    long steps = 0;
    ida->run.started = false;
    IDAGetNumSteps(memory, &steps);
    if (steps == 0) {
        N_VScale(1.0, ida->run.first_y, ida->y);
        N_VScale(1.0, ida->run.first_yp, ida->yp);
        ida->run.failed = true;
        return;
    }
    double t = 0.0;
    int flag = IDAGetCurrentTime(memory, &t);
    if (flag >= 0) flag = IDAGetDky(memory, t, 0, ida->y);
    if (flag >= 0) flag = IDAGetDky(memory, t, 1, ida->yp);
    mbsri_ida_add_shift(ida, t, 0, ida->y);
    mbsri_ida_add_shift(ida, t, 1, ida->yp);
    ida->run.failed = flag >= 0 && finite_state(ida, ida->y, ida->yp);
    ida->run.present = t;
}

/* After a negative flag of IDASolve: the status of the callback that caused it, or MBSR_ERR_SOLVER.
 * After a stop, and when max_steps was too small, the integration may go on, otherwise it has to be
 * started anew. */
static int gave_up(mbsr_ida *ida, int flag)
{
    if (flag != IDA_TOO_MUCH_WORK && !ida->report.stopped) keep_last(ida);
    /* singular Newton equations have their cause in the positions, too */
    const bool singular =
        ida->failing.callback == MBSR_SINGULAR_BLOCK || ida->failing.callback == MBSR_LOOP_SINGULAR;
    if (ida->failing.callback == 0 || singular) {
        const int status = mbsri_ida_blame_loops(ida);
        if (status) return status;
    }
    if (ida->failing.callback == 0) {
        const int failed = mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
        mbsri_ida_blame_stiff(ida, flag);
        return failed;
    }
    return mbsri_ida_fail(&ida->error, ida->failing.callback, ida->failing.failure.body,
                          ida->failing.failure.force, "mbsr_ida_advance: %s",
                          ida->failing.failure.text);
}

/* The present state becomes the reference of the index-1 form. Where that makes derivatives jump,
 * IDA starts anew from here. */
static int renew(mbsr_ida *ida)
{
    int restart = 0;
    const int status =
        mbsr_index1_renew(ida->model, ida->data, ida->run.present, N_VGetArrayPointer(ida->y),
                          N_VGetArrayPointer(ida->yp), &restart);
    if (status)
        return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(ida->data),
                                 "mbsr_ida_advance");
    if (!restart) return MBSR_OK;
    mbsri_ida_keep_start(ida);
    mbsri_ida_count(ida, &ida->count.before);
    mbsri_ida_end_shift(ida);
    const int flag = IDAReInit(ida->memory, ida->run.present, ida->y, ida->yp);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
    const double longest = mbsri_ida_longest_first_step(ida);
    IDASetInitStep(ida->memory,
                   ida->run.direction * mbsri_ida_first_step(ida, ida->run.direction, longest));
    return MBSR_OK;
}

/* After a root: an event of the caller's, or the reference's. */
static int at_root(mbsr_ida *ida, bool *again)
{
    const int info = IDAGetRootInfo(ida->memory, ida->rising);
    if (info < 0) return mbsri_ida_solver_failed(ida, &ida->error, info, "mbsr_ida_advance");
    for (int k = 0; k < ida->opt.events; ++k)
        ida->run.event = ida->run.event || ida->rising[k] != 0;
    *again = !ida->run.event;
    if (ida->turns && ida->rising[ida->opt.events] != 0) {
        const int status = renew(ida);
        if (status) return status;
    }
    return ida->run.event ? MBSR_EVENT : MBSR_OK;
}

/* Lets IDA integrate to t_end; y, yp and `present` of the driver are then the state reached. */
static int integrate_to(mbsr_ida *ida, double t_end)
{
    bool again = true;
    int status = MBSR_OK;
    while (again && !status) {
        double reached = ida->run.present;
        again = false;
        status = mbsri_ida_leave_kink(ida);
        if (status) return status;
        ida->failing.message[0] = '\0';
        ida->failing.callback = 0;
        ida->report.stopped = false;
        const int flag = IDASolve(ida->memory, t_end, &reached, ida->y, ida->yp, IDA_NORMAL);
        if (flag >= 0 || flag == IDA_TOO_MUCH_WORK || ida->report.stopped) {
            ida->run.present = reached;
            mbsri_ida_add_shift(ida, reached, 0, ida->y);
            mbsri_ida_add_shift(ida, reached, 1, ida->yp);
        }
        if (flag < 0) return gave_up(ida, flag);
        if (flag == IDA_TSTOP_RETURN) {
            mbsri_ida_arrive(ida);
            again = (t_end - ida->run.present) * ida->run.direction > 0.0 &&
                    !mbsri_ida_same_time(t_end, ida->run.present);
            if (!again) ida->run.present = t_end; /* the same but for rounding */
        }
        if (flag == IDA_ROOT_RETURN) status = at_root(ida, &again);
    }
    return status;
}

int mbsri_ida_advance(mbsr_ida *ida, double t_end)
{
    const bool arrived = mbsri_ida_same_time(t_end, ida->run.present);
    const double direction = t_end > ida->run.present ? 1.0 : -1.0;
    if (!arrived && ida->run.stepped && direction != ida->run.direction)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE,
                                "mbsr_ida_advance: t_end is %.17g, behind the present time %.17g",
                                t_end, ida->run.present);
    ida->run.event = false;
    if (arrived) return MBSR_OK;
    mbsri_ida_forget_output(ida);
    mbsri_ida_exchange_watch(ida);
    if (!ida->run.stepped) {
        const double longest = mbsri_ida_longest_first_step(ida);
        IDASetInitStep(ida->memory, direction * mbsri_ida_first_step(ida, direction, longest));
        ida->run.direction = direction;
        ida->run.stepped = true;
    }
    int status = integrate_to(ida, t_end);
    if (!status) status = mbsri_ida_check_dropped(ida);
    if (!status || ida->run.event) mbsri_ida_drift_note(ida);
    mbsri_ida_exchange_watch(ida);
    return status;
}

static int advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp)
{
    const int status = mbsri_ida_advance(ida, t_end);
    if (status == MBSR_OK || ida->run.event || ida->report.stopped) mbsri_ida_put(ida, t, y, yp);
    return status;
}

int mbsr_ida_advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    const int status = check_target(ida, t_end, "mbsr_ida_advance");
    return status ? status : advance(ida, t_end, t, y, yp);
}

int mbsr_ida_jump(mbsr_ida *ida)
{
    if (!ida) return MBSR_ERR_NULL;
    const int status = check_target(ida, ida->run.present, "mbsr_ida_jump");
    if (status) return status;
    ida->kinks.requested = true;
    ida->kinks.known = false;
    return MBSR_OK;
}

int mbsr_ida_sample(mbsr_ida *ida, double t_end, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    int status = check_target(ida, t_end, "mbsr_ida_sample");
    if (status) return status;
    ida->kinks.end = t_end;
    ida->kinks.sampled = ida->kinks.requested = true;
    ida->kinks.known = false;
    status = advance(ida, t_end, t, y, yp);
    ida->kinks.sampled = false;
    return status;
}
