/* mbsrank check: index and ranks at the start, and small masses.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"
#include "program/small.h"

#include <stdlib.h>
#include <string.h>

typedef struct check_options {
    program_options common;
    small_options small;
} check_options;

/* --small, --time, --tolerance at argv[*at]; false: it is another option. */
static bool small_option(int argc, char **argv, int *at, small_options *o, int *code)
{
    static const char *const names[] = {"--time", "--tolerance"};
    double *const number[] = {&o->time, &o->tolerance};
    if (strcmp(argv[*at], "--small") == 0) {
        o->wanted = true;
        return true;
    }
    for (int k = 0; k < 2; ++k) {
        const char *value = option_value(argc, argv, at, names[k]);
        if (!value && *at >= 0) continue;
        if (!value || !option_number(names[k], value, number[k])) *code = USAGE;
        o->wanted = true;
        return true;
    }
    return false;
}

static int read_check_options(int argc, char **argv, check_options *o)
{
    int code = DONE;
    for (int at = 0; at < argc && at >= 0 && !code; ++at) {
        if (small_option(argc, argv, &at, &o->small, &code)) continue;
        if (!common_option(argc, argv, &at, &o->common, &code))
            code = complain(USAGE, "check: there is no option %s", argv[at]);
        if (at < 0) break;
    }
    return code;
}

/* What is computed stands before anything is written. Where the report on small masses fails, the
 * other one is written all the same, as it may say why. */
static int report_on_start(const check_options *o, const program_model *m, const double *q,
                           const double *u)
{
    mbsr_small_masses *small = NULL;
    const bool json = o->common.json;
    const int made = o->small.wanted ? small_make(m, &o->small, q, u, &small) : DONE,
              code = report_begin(stdout, m, q, u, json);
    if (code <= UNDETERMINED) {
        if (json && o->small.wanted) fputs(", \"small_masses\": ", stdout);
        if (o->small.wanted) small_write(stdout, m, small, json);
        if (json) puts("}");
    }
    mbsr_small_masses_destroy(small);
    return code == DONE ? made : code;
}

int run_check(int argc, char **argv)
{
    check_options o = {.small = {.time = 1.0, .tolerance = 1e-3}};
    program_model m;
    const double *q, *given;
    int code = read_check_options(argc, argv, &o);
    if (code) return code;
    code = open_model(&o.common, false, &m);
    if (!code) code = start_state(&o.common, &m, &q, &given);
    if (!code) {
        const int n = mbsr_model_nu(m.model);
        double *u = calloc((size_t)n + 1, sizeof *u);
        for (int k = 0; u && given && k < n; ++k) u[k] = given[k];
        code = u ? report_on_start(&o, &m, q, u) : complain(FAILED, "no memory");
        free(u);
    }
    close_model(&m);
    return code;
}
