/* Options of the driver: defaults and checks.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/options.h"

#include "ida/error.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { COOKIE = 0x6d696461, MAX_ORDER = 5 };

mbsr_ida_opt mbsr_default_ida_opt(void)
{
    enum { CROWD = 64 };
    mbsr_newton_opt newton = mbsr_default_newton_opt();
    newton.together = CROWD;
    newton.pairs_error = 1e-3; /* Newton's method leaves more than that */
    return (mbsr_ida_opt){
        .cookie = COOKIE,
        .form = MBSR_DAE_MOMENTUM,
        .rtol = 1e-6,
        .atol = 1e-6,
        .suppress_algebraic = 1,
        .watch_ranks = 1,
        .renew_matrices = 1,
        .newton = newton,
        .krylov_size = 30,
        .progress_steps = 1,
        .max_order = MAX_ORDER,
        .max_steps = 1000000,
    };
}

static int wrong_value(mbsr_error *error, const char *field, double value, const char *rule)
{
    return mbsri_ida_refuse(error, MBSR_ERR_VALUE, "mbsr_ida_create: %s is %g, must be %s", field,
                            value, rule);
}

/* Those of one field, between least and most. */
static int check_numbers(const mbsr_ida_opt *opt, mbsr_error *error)
{
    static const char *const positive = "finite and positive", *const sign =
                                                                   "finite and not negative";
    const struct {
        const char *field;
        double value, least, most;
        const char *rule;
    } number[] = {
        {"rtol", opt->rtol, DBL_TRUE_MIN, DBL_MAX, positive},
        {"atol", opt->atol, 0.0, DBL_MAX, sign},
        {"atol_angle", opt->atol_angle, 0.0, DBL_MAX, sign},
        {"atol_length", opt->atol_length, 0.0, DBL_MAX, sign},
        {"atol_angular_velocity", opt->atol_angular_velocity, 0.0, DBL_MAX, sign},
        {"atol_velocity", opt->atol_velocity, 0.0, DBL_MAX, sign},
        {"initial_step", opt->initial_step, 0.0, DBL_MAX, sign},
        {"max_step", opt->max_step, 0.0, DBL_MAX, sign},
        {"max_order", opt->max_order, 1.0, MAX_ORDER, "1 .. 5"},
        {"max_steps", (double)opt->max_steps, 1.0, DBL_MAX, "positive"},
        {"krylov_size", opt->krylov_size, 1.0, DBL_MAX, "positive"},
        {"progress_steps", (double)opt->progress_steps, 1.0, DBL_MAX, "positive"},
        {"progress_interval", opt->progress_interval, 0.0, DBL_MAX, sign},
        {"events", opt->events, 0.0, DBL_MAX, "0 or more"},
    };
    for (size_t k = 0; k < sizeof number / sizeof number[0]; ++k) {
        const bool replaced = opt->atol_each && strncmp(number[k].field, "atol", 4) == 0;
        if (!replaced && !(number[k].value >= number[k].least && number[k].value <= number[k].most))
            return wrong_value(error, number[k].field, number[k].value, number[k].rule);
    }
    return MBSR_OK;
}

static int check_each(const mbsr_ida_opt *opt, int size, mbsr_error *error)
{
    for (int k = 0; opt->atol_each && k < size; ++k) {
        const double value = opt->atol_each[k];
        if (!isfinite(value) || value < 0.0)
            return mbsri_ida_refuse(
                error, MBSR_ERR_VALUE,
                "mbsr_ida_create: atol_each[%d] is %g, must be finite and not negative", k, value);
    }
    return MBSR_OK;
}

static int check_events(const mbsr_ida_opt *opt, mbsr_error *error)
{
    if (opt->events > 0 && !opt->event)
        return mbsri_ida_refuse(error, MBSR_ERR_NULL,
                                "mbsr_ida_create: events is %d but event is NULL", opt->events);
    if (opt->events == 0 && opt->event)
        return mbsri_ida_refuse(error, MBSR_ERR_VALUE,
                                "mbsr_ida_create: events is 0 but event is given");
    return MBSR_OK;
}

static int check_solver(const mbsr_ida_opt *opt, mbsr_error *error)
{
    static const char *const name[] = {"AUTO", "DENSE", "TREE", "KRYLOV"};
    const int solver = (int)opt->linear_solver;
    if (solver < MBSR_IDA_AUTO || solver > MBSR_IDA_KRYLOV) {
        return wrong_value(error, "linear_solver", solver, "AUTO, DENSE, TREE or KRYLOV");
    }
    if (solver > MBSR_IDA_DENSE && opt->form != MBSR_DAE_MOMENTUM)
        return mbsri_ida_refuse(
            error, MBSR_ERR_VALUE,
            "mbsr_ida_create: linear_solver is %s but form is %d: it solves the "
            "momentum form only",
            name[solver], (int)opt->form);
    return MBSR_OK;
}

int mbsri_ida_check(const mbsr_ida_opt *opt, int size, mbsr_error *error)
{
    int status = check_numbers(opt, error);
    if (!status) status = check_each(opt, size, error);
    if (!status) status = check_solver(opt, error);
    return status ? status : check_events(opt, error);
}
