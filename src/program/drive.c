/* A run from output to output and from input to input: see drive.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/drive.h"

#include <math.h>
#include <string.h>

/* No run that somebody waits for has more. */
static const double MOST_LINES = 1e8;

double drive_step(const run_options *o)
{
    return o->step > 0.0 ? o->step : 0.01 * o->t_end;
}

int drive_options(const char *command, int argc, char **argv, run_options *o)
{
    static const char *const numbers[] = {"--t-end", "--rtol", "--atol", "--step"},
                             *const texts[] = {"--inputs", "--output", "-o", "--form"};
    double *const number[] = {&o->t_end, &o->rtol, &o->atol, &o->step};
    const char **const text[] = {&o->inputs, &o->outputs, &o->file, &o->form};
    int code = DONE;
    for (int at = 0; at < argc && !code; ++at) {
        bool taken = false;
        for (int k = 0; k < 4 && !taken && at >= 0; ++k) {
            const char *value = option_value(argc, argv, &at, numbers[k]);
            if (value && !option_number(numbers[k], value, number[k])) return USAGE;
            taken = value != NULL;
            if (!taken && at >= 0 && (value = option_value(argc, argv, &at, texts[k])))
                *text[k] = value, taken = true;
        }
        if (at < 0) return USAGE;
        if (strcmp(argv[at], "--quiet") == 0) o->quiet = taken = true;
        if (!taken && !common_option(argc, argv, &at, &o->common, &code))
            return complain(USAGE, "%s: there is no option %s", command, argv[at]);
        if (at < 0) return USAGE;
    }
    if (!code && !(o->t_end > 0.0)) return complain(USAGE, "%s: --t-end is missing", command);
    if (!code && o->t_end > MOST_LINES * drive_step(o))
        return complain(USAGE, "%s: --step %g makes more than %.0g lines up to --t-end %g", command,
                        o->step, MOST_LINES, o->t_end);
    return code;
}

int drive_integrator(const run_options *o, mbsr_ida_opt *opt)
{
    *opt = mbsr_default_ida_opt();
    if (o->form && strcmp(o->form, "index1") == 0)
        opt->form = MBSR_DAE_INDEX1;
    else if (o->form && strcmp(o->form, "momentum") != 0)
        return complain(USAGE, "--form: '%s' is neither momentum nor index1", o->form);
    if (o->rtol > 0.0) opt->rtol = o->rtol;
    if (o->atol > 0.0) opt->atol = o->atol;
    return DONE;
}

static int fail_drive(char text[MBSR_TEXT_SIZE], const mbsr_error *error)
{
    memcpy(text, error->text, MBSR_TEXT_SIZE);
    return FAILED;
}

int drive(const run_options *o, const program_model *m, mbsr_simulation *s, inputs *in,
          const drive_taker *taker, char text[MBSR_TEXT_SIZE])
{
    int code = taker->take(taker->user, s, false);
    while (!code) {
        double t = fmin(taker->next(taker->user), o->t_end);
        const bool input = inputs_next(in) <= t;
        if (input) t = inputs_next(in);
        const int status = (input ? mbsr_simulation_sample : mbsr_simulation_to)(s, t);
        if (status && status != MBSR_EVENT) return fail_drive(text, &s->error);
        if (input && !status) {
            inputs_set(in, t, m->file->control);
            if (mbsr_ida_jump(s->ida)) return fail_drive(text, mbsr_ida_error(s->ida));
            continue;
        }
        code = taker->take(taker->user, s, status == MBSR_EVENT);
        if (!status && t >= o->t_end) break;
    }
    return code;
}
