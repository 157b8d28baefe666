/* Integration.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/advance.h"

#include "ida/count.h"
#include "ida/error.h"
#include "ida/loops.h"
#include "ida/tolerances.h"
#include "ida/watch.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* y' for the residual of first_step: zero, but for the loop forces, which are rates. */
static N_Vector at_rest(mbsr_ida *ida, bool on)
{
    const int first = mbsri_ida_loops(ida);
    double *zero = N_VGetArrayPointer(ida->zero);
    const double *yp = N_VGetArrayPointer(ida->yp);
    for (int k = first; k < ida->size; ++k) zero[k] = on ? yp[k] : 0.0;
    return ida->zero;
}

/* First step h when none is given, at most 1e-3 s: with the norm of the error test, which is 1 at
 * the tolerance, and a short time s,
 *
 *   |h^2 y'' / 2| = 1/2,    y'' = (y'(t + s) - y'(t)) / s
 *
 * for q and p, whose y'(t + s) = -F of the residual there with y' = 0. IDA's own choice goes with
 * the first order, h y', and with the way to the first t_end: far smaller at tight tolerances, too
 * small for directions that only springs determine, and it would make the steps depend on where
 * output is asked for. */
static double first_step(mbsr_ida *ida, double direction)
{
    static const double longest = 1e-3; /* s */
    if (ida->opt.initial_step > 0.0) return ida->opt.initial_step;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const int n = ida->opt.form == MBSR_DAE_MOMENTUM ? nq + nu : nq;
    const double *yp = N_VGetArrayPointer(ida->yp);
    double *moved = N_VGetArrayPointer(ida->moved), *rate = N_VGetArrayPointer(ida->work);
    const double slope = mbsri_ida_norm(ida, mbsri_ida_loops(ida), yp);
    const double little = slope * longest > 0.5 ? 0.5 / slope : longest;
    N_VLinearSum(1.0, ida->y, direction * little, ida->yp, ida->moved);
    ++ida->residuals;
    const int failed =
        mbsr_dae_residual(ida->model, ida->data, ida->opt.form, ida->present + direction * little,
                          moved, N_VGetArrayPointer(at_rest(ida, true)), rate);
    at_rest(ida, false);
    if (failed) return little;
    for (int k = 0; k < n; ++k) rate[k] = (-rate[k] - yp[k]) / little;
    const double bend = mbsri_ida_norm(ida, n, rate);
    return bend * longest * longest > 1.0 ? 1.0 / sqrt(bend) : longest;
}

static int check_target(mbsr_ida *ida, double t_end)
{
    if (!isfinite(t_end)) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_advance: t_end is %g", t_end);
    }
    if (!ida->started) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_advance: call mbsr_ida_start first");
    }
    return MBSR_OK;
}

bool mbsri_ida_same_time(double a, double b)
{
    return fabs(a - b) <= 2.0 * DBL_EPSILON * (fabs(a) + fabs(b));
}

void mbsri_ida_put(const mbsr_ida *ida, double *t, double *y, double *yp)
{
    const size_t bytes = (size_t)ida->size * sizeof *y;
    if (t) *t = ida->present;
    if (y) memcpy(y, N_VGetArrayPointer(ida->y), bytes);
    if (yp) memcpy(yp, N_VGetArrayPointer(ida->yp), bytes);
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
    ida->started = false;
    IDAGetNumSteps(memory, &steps);
    if (steps == 0) {
        N_VScale(1.0, ida->first_y, ida->y);
        N_VScale(1.0, ida->first_yp, ida->yp);
        ida->failed = true;
        return;
    }
    double t = 0.0;
    int flag = IDAGetCurrentTime(memory, &t);
    if (flag >= 0) flag = IDAGetDky(memory, t, 0, ida->y);
    if (flag >= 0) flag = IDAGetDky(memory, t, 1, ida->yp);
    ida->failed = flag >= 0 && finite_state(ida, ida->y, ida->yp);
    ida->present = t;
}

/* After a negative flag of IDASolve: the status of the callback that caused it, or MBSR_ERR_SOLVER.
 * After a stop, and when max_steps was too small, the integration may go on, otherwise it has to be
 * started anew. */
static int gave_up(mbsr_ida *ida, int flag)
{
    if (flag != IDA_TOO_MUCH_WORK && !ida->stopped) keep_last(ida);
    if (ida->callback == 0) {
        const int status = mbsri_ida_blame_loops(ida);
        if (status) return status;
        return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
    }
    return mbsri_ida_fail(&ida->error, ida->callback, ida->failure.body, ida->failure.force,
                          "mbsr_ida_advance: %s", ida->failure.text);
}

/* The present state becomes the reference of the index-1 form. Where that makes derivatives jump,
 * IDA starts anew from here. */
static int renew(mbsr_ida *ida)
{
    int restart = 0;
    const int status =
        mbsr_index1_renew(ida->model, ida->data, ida->present, N_VGetArrayPointer(ida->y),
                          N_VGetArrayPointer(ida->yp), &restart);
    if (status) {
        const mbsr_error *error = mbsr_data_error(ida->data);
        return mbsri_ida_fail(&ida->error, status, error->body, error->force,
                              "mbsr_ida_advance: %s", error->text);
    }
    if (!restart) return MBSR_OK;
    mbsri_ida_keep_start(ida);
    mbsri_ida_count(ida, &ida->before);
    const int flag = IDAReInit(ida->memory, ida->present, ida->y, ida->yp);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
    IDASetInitStep(ida->memory, ida->direction * first_step(ida, ida->direction));
    return MBSR_OK;
}

/* After a root: an event of the caller's, or the reference's. */
static int at_root(mbsr_ida *ida, bool *again)
{
    const int info = IDAGetRootInfo(ida->memory, ida->rising);
    if (info < 0) return mbsri_ida_solver_failed(ida, &ida->error, info, "mbsr_ida_advance");
    for (int k = 0; k < ida->opt.events; ++k) ida->event = ida->event || ida->rising[k] != 0;
    *again = !ida->event;
    if (ida->turns && ida->rising[ida->opt.events] != 0) {
        const int status = renew(ida);
        if (status) return status;
    }
    return ida->event ? MBSR_EVENT : MBSR_OK;
}

/* Lets IDA integrate to t_end; y, yp and `present` of the driver are then the state reached. */
static int solve(mbsr_ida *ida, double t_end)
{
    bool again = true;
    int status = MBSR_OK;
    while (again && !status) {
        double reached = ida->present;
        again = false;
        ida->message[0] = '\0';
        ida->callback = 0;
        ida->stopped = false;
        const int flag = IDASolve(ida->memory, t_end, &reached, ida->y, ida->yp, IDA_NORMAL);
        if (flag >= 0 || flag == IDA_TOO_MUCH_WORK || ida->stopped) ida->present = reached;
        if (flag < 0) return gave_up(ida, flag);
        if (flag == IDA_ROOT_RETURN) status = at_root(ida, &again);
    }
    return status;
}

int mbsri_ida_advance(mbsr_ida *ida, double t_end)
{
    const bool arrived = mbsri_ida_same_time(t_end, ida->present);
    const double direction = t_end > ida->present ? 1.0 : -1.0;
    if (!arrived && ida->stepped && direction != ida->direction) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_advance: t_end is %.17g, behind the present time %.17g",
                              t_end, ida->present);
    }
    ida->event = false;
    if (arrived) return MBSR_OK;
    mbsri_ida_exchange_watch(ida);
    if (!ida->stepped) {
        IDASetInitStep(ida->memory, direction * first_step(ida, direction));
        ida->direction = direction;
        ida->stepped = true;
    }
    int status = solve(ida, t_end);
    if (!status) status = mbsri_ida_check_dropped(ida);
    mbsri_ida_exchange_watch(ida);
    return status;
}

int mbsr_ida_advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    int status = check_target(ida, t_end);
    if (status) return status;
    status = mbsri_ida_advance(ida, t_end);
    if (status == MBSR_OK || ida->event || ida->stopped) mbsri_ida_put(ida, t, y, yp);
    return status;
}
