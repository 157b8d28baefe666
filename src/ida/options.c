/* Options of the driver: defaults and checks.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/options.h"

#include "ida/error.h"

#include <math.h>

enum { COOKIE = 0x6d696461, MAX_ORDER = 5 };

mbsr_ida_opt mbsr_default_ida_opt(void)
{
    return (mbsr_ida_opt){
        .cookie = COOKIE,
        .form = MBSR_DAE_MOMENTUM,
        .rtol = 1e-6,
        .atol = 1e-6,
        .suppress_algebraic = 1,
        .watch_ranks = 1,
        .renew_matrices = 1,
        .newton = mbsr_default_newton_opt(),
        .krylov_size = 30,
        .progress_steps = 1,
        .max_order = MAX_ORDER,
        .max_steps = 1000000,
    };
}

static int wrong_value(mbsr_error *error, const char *field, double value, const char *rule)
{
    return mbsri_ida_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_ida_create: %s is %g, must be %s", field, value, rule);
}

static int check_tolerances(const mbsr_ida_opt *opt, int size, mbsr_error *error)
{
    if (!isfinite(opt->rtol) || opt->rtol <= 0.0) {
        return wrong_value(error, "rtol", opt->rtol, "finite and positive");
    }
    if (!opt->atol_each && (!isfinite(opt->atol) || opt->atol < 0.0)) {
        return wrong_value(error, "atol", opt->atol, "finite and not negative");
    }
    const struct {
        const char *field;
        double value;
    } by_kind[] = {{"atol_angle", opt->atol_angle},
                   {"atol_length", opt->atol_length},
                   {"atol_angular_velocity", opt->atol_angular_velocity},
                   {"atol_velocity", opt->atol_velocity}};
    for (int k = 0; !opt->atol_each && k < 4; ++k) {
        const double value = by_kind[k].value;
        if (!isfinite(value) || value < 0.0) {
            return wrong_value(error, by_kind[k].field, value, "finite and not negative");
        }
    }
    for (int k = 0; opt->atol_each && k < size; ++k) {
        const double value = opt->atol_each[k];
        if (!isfinite(value) || value < 0.0) {
            return mbsri_ida_fail(
                error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                "mbsr_ida_create: atol_each[%d] is %g, must be finite and not negative", k, value);
        }
    }
    return MBSR_OK;
}

static int check_steps(const mbsr_ida_opt *opt, mbsr_error *error)
{
    if (!isfinite(opt->initial_step) || opt->initial_step < 0.0) {
        return wrong_value(error, "initial_step", opt->initial_step, "finite and not negative");
    }
    if (!isfinite(opt->max_step) || opt->max_step < 0.0) {
        return wrong_value(error, "max_step", opt->max_step, "finite and not negative");
    }
    if (opt->max_order < 1 || opt->max_order > MAX_ORDER) {
        return wrong_value(error, "max_order", opt->max_order, "1 .. 5");
    }
    if (opt->max_steps < 1) {
        return wrong_value(error, "max_steps", (double)opt->max_steps, "positive");
    }
    return MBSR_OK;
}

static int check_events(const mbsr_ida_opt *opt, mbsr_error *error)
{
    if (opt->events < 0) return wrong_value(error, "events", opt->events, "0 or more");
    if (opt->events > 0 && !opt->event) {
        return mbsri_ida_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_create: events is %d but event is NULL", opt->events);
    }
    if (opt->events == 0 && opt->event) {
        return mbsri_ida_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_create: events is 0 but event is given");
    }
    return MBSR_OK;
}

static int check_solver(const mbsr_ida_opt *opt, mbsr_error *error)
{
    static const char *const name[] = {"AUTO", "DENSE", "TREE", "KRYLOV"};
    const int solver = (int)opt->linear_solver;
    if (solver < MBSR_IDA_AUTO || solver > MBSR_IDA_KRYLOV) {
        return wrong_value(error, "linear_solver", solver, "AUTO, DENSE, TREE or KRYLOV");
    }
    if (solver > MBSR_IDA_DENSE && opt->form != MBSR_DAE_MOMENTUM) {
        return mbsri_ida_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "mbsr_ida_create: linear_solver is %s but form is %d: it solves the "
                              "momentum form only",
                              name[solver], (int)opt->form);
    }
    if (opt->krylov_size < 1) {
        return wrong_value(error, "krylov_size", opt->krylov_size, "positive");
    }
    return MBSR_OK;
}

static int check_progress(const mbsr_ida_opt *opt, mbsr_error *error)
{
    if (opt->progress_steps < 1) {
        return wrong_value(error, "progress_steps", (double)opt->progress_steps, "positive");
    }
    if (!isfinite(opt->progress_interval) || opt->progress_interval < 0.0) {
        return wrong_value(error, "progress_interval", opt->progress_interval,
                           "finite and not negative");
    }
    return MBSR_OK;
}

int mbsri_ida_check(const mbsr_ida_opt *opt, int size, mbsr_error *error)
{
    int status = check_tolerances(opt, size, error);
    if (!status) status = check_steps(opt, error);
    if (!status) status = check_solver(opt, error);
    if (!status) status = check_progress(opt, error);
    return status ? status : check_events(opt, error);
}
