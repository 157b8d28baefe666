/* mbsrank check: index and ranks at the start.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <stdlib.h>

int run_check(int argc, char **argv)
{
    program_options o = {.path = NULL};
    program_model m;
    const double *q, *given;
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        if (!common_option(argc, argv, &at, &o, &code))
            code = complain(USAGE, "check: there is no option %s", argv[at]);
        if (at < 0) break;
    }
    if (code) return code;
    code = open_model(&o, false, &m);
    if (!code) code = start_state(&o, &m, &q, &given);
    if (!code) {
        const int n = mbsr_model_nu(m.model);
        double *u = calloc((size_t)n + 1, sizeof *u);
        for (int k = 0; u && given && k < n; ++k) u[k] = given[k];
        if (!u)
            code = complain(FAILED, "no memory");
        else
            code = report_write(stdout, &m, q, u, o.json);
        if (o.json && code <= UNDETERMINED) putchar('\n');
        free(u);
    }
    close_model(&m);
    return code;
}
