/* Statistics, dense output, events, access to IDA's memory.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/count.h"
#include "ida/shift.h"
#include "ida/error.h"
#include "ida/linear.h"
#include "ida/stiff.h"

#include <ida/ida_ls.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

int mbsr_ida_event_info(const mbsr_ida *ida, int *direction)
{
    if (!ida || !direction) return MBSR_ERR_NULL;
    if (!ida->run.event) return MBSR_ERR_SEQUENCE;
    memcpy(direction, ida->rising, (size_t)ida->opt.events * sizeof *direction);
    return MBSR_OK;
}

int mbsr_ida_dense(mbsr_ida *ida, double t, int k, double *dky)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!dky) return mbsri_ida_refuse(&ida->error, MBSR_ERR_NULL, "mbsr_ida_dense: dky is NULL");
    long steps = 0;
    int order = 0;
    IDAGetNumSteps(ida->memory, &steps);
    IDAGetLastOrder(ida->memory, &order);
    if (steps == 0)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_SEQUENCE,
                                "mbsr_ida_dense: no step was taken yet");
    if (k < 0 || k > order)
        return mbsri_ida_refuse(
            &ida->error, MBSR_ERR_VALUE,
            "mbsr_ida_dense: k is %d, must be 0 .. %d, the order of the last step", k, order);
    ida->failing.message[0] = '\0';
    /* IDA itself refuses times before the last step, and extrapolates beyond it */
    sunrealtype reached = 0.0, last = 0.0;
    IDAGetCurrentTime(ida->memory, &reached);
    IDAGetLastStep(ida->memory, &last);
    const double fuzz = 100.0 * DBL_EPSILON * (fabs(reached) + fabs(last));
    const bool beyond = (last < 0.0 ? reached - t : t - reached) > fuzz;
    const int flag = isfinite(t) && !beyond ? IDAGetDky(ida->memory, t, k, ida->work) : IDA_BAD_T;
    if (flag == IDA_BAD_T)
        return mbsri_ida_refuse(&ida->error, MBSR_ERR_VALUE,
                                "mbsr_ida_dense: t is %.17g, not within the last step. %s", t,
                                ida->failing.message);
    if (flag < 0) return mbsri_ida_solver_failed(ida, &ida->error, flag, "mbsr_ida_dense");
    mbsri_ida_add_shift(ida, t, k, ida->work);
    memcpy(dky, N_VGetArrayPointer(ida->work), (size_t)ida->size * sizeof *dky);
    return MBSR_OK;
}

/* With a dense matrix IDA factors each Jacobian and solves once in each Newton iteration. */
static void count_solver(const mbsr_ida *ida, mbsr_ida_stats *stats)
{
    mbsr_newton_info now;
    mbsri_ida_count_solver(ida, &now);
    const bool dense = ida->opt.linear_solver == MBSR_IDA_DENSE;
    stats->factorisations =
        dense ? stats->jacobians : now.factorisations - ida->linear.newton_before.factorisations;
    stats->solves = dense ? stats->newton_iterations + stats->filter_solves
                          : now.solves - ida->linear.newton_before.solves;
}

static void count_stiff(const mbsr_ida *ida, mbsr_ida_stats *stats)
{
    const mbsr_sundials_stiff_info *info = &mbsri_stiff_of(ida->nonlinear)->info;
    stats->stiff_tests = info->stiff_tests;
    stats->stiff_iterations = info->stiff_iterations;
    stats->careful_attempts = info->careful_attempts;
    stats->careful_failures = info->careful_failures;
    stats->filter_solves = info->filter_solves;
    stats->renewals = info->renewals;
}

/* IDA counts the residuals of its Newton iterations and those of the difference quotients apart;
 * the driver counts all. The counters of the linear solver are cleared by the first step, not by
 * mbsr_ida_start. */
int mbsr_ida_get_stats(const mbsr_ida *ida, mbsr_ida_stats *stats)
{
    if (!ida || !stats) return MBSR_ERR_NULL;
    *stats = ida->count.before;
    stats->linear_solver = ida->opt.linear_solver;
    stats->residuals = ida->count.residuals;
    stats->events = ida->count.events;
    stats->raw_states = ida->output.raw;
    if (ida->count.residuals == 0) return MBSR_OK;
    mbsri_ida_count(ida, stats);
    stats->jacobian_residuals += ida->count.central_residuals;
    count_stiff(ida, stats);
    count_solver(ida, stats);
    IDAGetLastOrder(ida->memory, &stats->last_order);
    IDAGetLastStep(ida->memory, &stats->last_step);
    return MBSR_OK;
}

void *mbsr_ida_memory(const mbsr_ida *ida)
{
    return ida ? ida->memory : NULL;
}
