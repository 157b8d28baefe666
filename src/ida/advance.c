/* Start and integration.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "driver.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Refuses a start that is not finite; names the first wrong entry. */
static int check_start(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    if (!isfinite(t)) {
        return mbsri_ida_fail(&ida->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_start: t is %g", t);
    }
    for (int k = 0; k < ida->size; ++k) {
        if (isfinite(y[k]) && isfinite(yp[k])) continue;
        const bool rate = isfinite(y[k]);
        return mbsri_ida_fail(&ida->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_start: %s[%d] is %g", rate ? "yp" : "y", k,
                              rate ? yp[k] : y[k]);
    }
    return MBSR_OK;
}

int mbsr_ida_start(mbsr_ida *ida, double t, const double *y, const double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!y || !yp) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_start: %s is NULL", !y ? "y" : "yp");
    }
    const int status = check_start(ida, t, y, yp);
    if (status) return status;
    const size_t bytes = (size_t)ida->size * sizeof *y;
    memmove(N_VGetArrayPointer(ida->y), y, bytes);
    memmove(N_VGetArrayPointer(ida->yp), yp, bytes);
    ida->message[0] = '\0';
    ida->started = ida->stepped = ida->event = false;
    ida->residuals = ida->events = 0;
    ida->wall = INFINITY;
    ida->blocked = 0;
    ida->present = t;
    const int flag = IDAReInit(ida->memory, t, ida->y, ida->yp);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_start");
    ida->started = true;
    return MBSR_OK;
}

/* First step when none is given: IDA's choice, half the tolerance over |y'|, but bounded by a fixed
 * time. IDA's bound, a thousandth of the way to the first t_end, would make the steps depend on
 * where output is asked for. */
static double first_step(const mbsr_ida *ida)
{
    static const double longest = 1e-3; /* s */
    if (ida->opt.initial_step > 0.0) return ida->opt.initial_step;
    const double *y = N_VGetArrayPointer(ida->y), *yp = N_VGetArrayPointer(ida->yp);
    const double *atol = N_VGetArrayPointer(ida->atol);
    double sum = 0.0;
    for (int k = 0; k < ida->size; ++k) {
        const double weight = 1.0 / (ida->opt.rtol * fabs(y[k]) + atol[k]);
        sum += (yp[k] * weight) * (yp[k] * weight);
    }
    const double norm = sqrt(sum / ida->size);
    return norm * longest > 0.5 ? 0.5 / norm : longest;
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

/* Whether two times differ by no more than rounding, as IDA sees it. */
static bool same_time(double a, double b)
{
    return fabs(a - b) <= 2.0 * DBL_EPSILON * (fabs(a) + fabs(b));
}

static void put(const mbsr_ida *ida, double *t, double *y, double *yp)
{
    const size_t bytes = (size_t)ida->size * sizeof *y;
    if (t) *t = ida->present;
    if (y) memcpy(y, N_VGetArrayPointer(ida->y), bytes);
    if (yp) memcpy(yp, N_VGetArrayPointer(ida->yp), bytes);
}

/* After a negative flag of IDASolve: the status of the residual or event function that caused it,
 * or MBSR_ERR_SOLVER. When max_steps was too small the integration may go on, otherwise it has to
 * be started anew. */
static int gave_up(mbsr_ida *ida, int flag)
{
    if (flag != IDA_TOO_MUCH_WORK) ida->started = false;
    if (ida->callback == 0) {
        return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_advance");
    }
    return mbsri_ida_fail(&ida->error, ida->callback, ida->failure.body, ida->failure.force,
                          "mbsr_ida_advance: %s", ida->failure.text);
}

/* Lets IDA integrate to t_end; y, yp and `present` of the driver are then the state reached. */
static int solve(mbsr_ida *ida, double t_end)
{
    double reached = ida->present;
    ida->message[0] = '\0';
    ida->callback = 0;
    const int flag = IDASolve(ida->memory, t_end, &reached, ida->y, ida->yp, IDA_NORMAL);
    if (flag >= 0 || flag == IDA_TOO_MUCH_WORK) ida->present = reached;
    if (flag < 0) return gave_up(ida, flag);
    if (flag != IDA_ROOT_RETURN) return MBSR_OK;
    const int info = IDAGetRootInfo(ida->memory, ida->rising);
    if (info < 0) return mbsri_ida_solver_failed(ida, &ida->error, info, "mbsr_ida_advance");
    ida->event = true;
    return MBSR_EVENT;
}

int mbsr_ida_advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp)
{
    if (!ida) return MBSR_ERR_NULL;
    int status = check_target(ida, t_end);
    if (status) return status;
    const bool arrived = same_time(t_end, ida->present);
    const double direction = t_end > ida->present ? 1.0 : -1.0;
    if (!ida->stepped) {
        if (arrived) {
            return mbsri_ida_fail(
                &ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                "mbsr_ida_advance: t_end is %.17g, too close to the start at %.17g", t_end,
                ida->present);
        }
        IDASetInitStep(ida->memory, direction * first_step(ida));
        ida->direction = direction;
        ida->stepped = true;
    } else if (!arrived && direction != ida->direction) {
        return mbsri_ida_fail(&ida->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_advance: t_end is %.17g, behind the present time %.17g",
                              t_end, ida->present);
    }
    ida->event = false;
    status = arrived ? MBSR_OK : solve(ida, t_end);
    if (status == MBSR_OK || ida->event) put(ida, t, y, yp);
    return status;
}
