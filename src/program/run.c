/* mbsrank run: integrates a model and writes CSV.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/columns.h"
#include "program/inputs.h"

#include <mbsrank/simulation.h>

#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static volatile sig_atomic_t interrupted;

static void interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

typedef struct run_options {
    program_options common;
    const char *inputs, *outputs, *file, *form;
    double t_end, rtol, atol, step; /* step 0: a hundredth of t_end */
    bool quiet;
} run_options;

static int read_options(int argc, char **argv, run_options *o)
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
            return complain(USAGE, "run: there is no option %s", argv[at]);
        if (at < 0) return USAGE;
    }
    if (!code && !(o->t_end > 0.0)) return complain(USAGE, "run: --t-end is missing");
    return code;
}

static int stop(void *user, const mbsr_ida_progress *now)
{
    const double *t_end = user;
    if (*t_end > 0.0) fprintf(stderr, "\rt = %-12.6g %3.0f %%", now->t, 100.0 * now->t / *t_end);
    return interrupted ? 1 : 0;
}

static int integrator(const run_options *o, double *shown, mbsr_ida_opt *opt)
{
    *opt = mbsr_default_ida_opt();
    if (o->form && strcmp(o->form, "index1") == 0)
        opt->form = MBSR_DAE_INDEX1;
    else if (o->form && strcmp(o->form, "momentum") != 0)
        return complain(USAGE, "--form: '%s' is neither momentum nor index1", o->form);
    if (o->rtol > 0.0) opt->rtol = o->rtol;
    if (o->atol > 0.0) opt->atol = o->atol;
    opt->progress = stop;
    opt->progress_user = shown;
    opt->progress_interval = 0.1;
    return DONE;
}

/* From output to output and from input to input. */
static int go(const run_options *o, const program_model *m, mbsr_simulation *s, const columns *c,
              inputs *in, FILE *to)
{
    const double step = o->step > 0.0 ? o->step : 0.01 * o->t_end;
    columns_head(c, to);
    int code = columns_write(c, s->model, s->data, s->t, s->q, s->u, to);
    for (long k = 1; !code && !interrupted;) {
        double t = fmin((double)k * step, o->t_end);
        const bool input = inputs_next(in) <= t;
        if (input) t = inputs_next(in);
        if ((input ? mbsr_simulation_sample : mbsr_simulation_to)(s, t)) break;
        if (input) {
            inputs_set(in, t, m->file->control);
            if (mbsr_ida_jump(s->ida)) return complain(FAILED, "%s", mbsr_ida_error(s->ida)->text);
            continue;
        }
        code = columns_write(c, s->model, s->data, s->t, s->q, s->u, to);
        if (t >= o->t_end) break;
        ++k;
    }
    if (!code && s->status && !interrupted) code = complain(FAILED, "%s", s->error.text);
    return code;
}

static int simulate(const run_options *o, program_model *m, const columns *c, inputs *in)
{
    const double *q, *u;
    double shown = !o->quiet && isatty(2) ? o->t_end : 0.0;
    mbsr_ida_opt opt;
    int code = start_state(&o->common, m, &q, &u);
    if (!code) code = integrator(o, &shown, &opt);
    if (code) return code;
    inputs_set(in, 0.0, m->file->control);
    FILE *to = o->file ? fopen(o->file, "w") : stdout;
    if (!to) return complain(FAILED, "%s cannot be written", o->file);
    mbsr_simulation s = mbsr_simulation_of(mbsr_file_take_model(m->file));
    mbsr_data_destroy(m->data);
    m->data = NULL;
    signal(SIGINT, interrupt);
    if (mbsr_simulation_start(&s, &opt, 0.0, q, u))
        code = complain(FAILED, "%s: no start: %s", o->common.path, s.error.text);
    if (!code) code = go(o, m, &s, c, in, to);
    if (shown > 0.0) fputc('\n', stderr);
    if (interrupted) complain(FAILED, "stopped at t = %g; what was computed is kept", s.t);
    mbsr_simulation_end(&s);
    const bool bad = fflush(to) != 0 || ferror(to);
    if (to != stdout) fclose(to);
    if (bad) return complain(FAILED, "%s cannot be written", o->file ? o->file : "the output");
    return interrupted ? FAILED : code;
}

int run_run(int argc, char **argv)
{
    run_options o = {.t_end = 0.0};
    program_model m = {.text = NULL};
    columns c = {.list = NULL};
    inputs in = {.actuator = NULL};
    int code = read_options(argc, argv, &o);
    if (code) return code;
    code = open_model(&o.common, o.quiet, &m);
    if (!code) code = columns_make(&m, o.outputs, &c);
    if (!code && o.inputs) code = inputs_read(&m, o.inputs, &in);
    if (!code) code = simulate(&o, &m, &c, &in);
    free(c.list);
    inputs_free(&in);
    close_model(&m);
    return code;
}
