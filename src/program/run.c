/* mbsrank run: integrates a model and writes CSV or HDF5.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/drive.h"
#include "program/output.h"
#include "program/progress.h"
#include "program/touching.h"

#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

static volatile sig_atomic_t interrupted;

static void interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

static int stop(void *user, const mbsr_ida_progress *now)
{
    progress_show(user, now->t);
    return interrupted ? 1 : 0;
}

/* States go to the output, at multiples of the step. */
typedef struct lines {
    output *to;
    double step;
    long next; /* which multiple */
} lines;

static double next_multiple(void *user)
{
    const lines *l = user;
    return (double)l->next * l->step;
}

static int take_line(void *user, const mbsr_simulation *s, bool event)
{
    lines *l = user;
    (void)event;
    ++l->next;
    return output_state(l->to, s->model, s->data, s->t, s->q, s->u);
}

static int go(const run_options *o, const program_model *m, mbsr_simulation *s, inputs *in,
              output *to)
{
    char text[MBSR_TEXT_SIZE];
    lines all = {.to = to, .step = drive_step(o)};
    const drive_taker taker = {next_multiple, take_line, &all};
    const int code = drive(o, m, s, in, &taker, text);
    return code && s->status && !interrupted ? complain(FAILED, "%s", text) : code;
}

/* ---- what is told of a run beside its lines ---- */

static void tell_beginning(const run_options *o, const program_model *m, const mbsr_ida_opt *opt,
                           output *to)
{
    char hash[MODEL_HASH];
    model_hash(m, hash);
    output_text(to, "model", o->common.path);
    output_text(to, "model_hash", hash);
    output_text(to, "start", o->common.start ? o->common.start : "");
    output_text(to, "inputs", o->inputs ? o->inputs : "");
    output_text(to, "form", opt->form == MBSR_DAE_INDEX1 ? "index1" : "momentum");
    output_number(to, "rtol", opt->rtol);
    output_number(to, "atol", opt->atol);
}

static void tell_end(const run_options *o, const mbsr_simulation *s, int code, output *to)
{
    mbsr_ida_stats cost;
    mbsr_simulation_get_stats(s, &cost);
    const struct {
        const char *name;
        long count;
    } counts[] = {{"lines", to->lines},
                  {"steps", cost.steps},
                  {"residuals", cost.residuals},
                  {"newton_iterations", cost.newton_iterations},
                  {"newton_failures", cost.newton_failures},
                  {"error_test_failures", cost.error_test_failures},
                  {"factorisations", cost.factorisations},
                  {"solves", cost.solves}};
    const char *end = interrupted        ? "interrupted"
                      : s->error.text[0] ? s->error.text
                      : code             ? "failed"
                                         : "done";
    output_text(to, "end", end);
    if (o->common.json) {
        printf("{\"end\": "), put_json(stdout, end);
        printf(", \"t\": %.17g", s->t);
    }
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        output_number(to, counts[k].name, (double)counts[k].count);
        if (o->common.json) printf(", \"%s\": %ld", counts[k].name, counts[k].count);
    }
    if (o->common.json) puts("}");
}

/* What limits and dry friction of joints are in the model. */
static void tell_joints(const program_model *m)
{
    const mbsr_file *f = m->file;
    double stiff[2] = {INFINITY, 0.0}, slip[2] = {INFINITY, 0.0};
    int stops = 0, rubs = 0;
    for (int k = 0; k < f->joints; ++k) {
        const mbsr_file_joint *j = f->joint + k;
        stops += j->stop_stiffness > 0.0;
        rubs += j->slip > 0.0;
        if (j->stop_stiffness > 0.0) stiff[0] = fmin(stiff[0], j->stop_stiffness);
        if (j->slip > 0.0) slip[0] = fmin(slip[0], j->slip);
        stiff[1] = fmax(stiff[1], j->stop_stiffness);
        slip[1] = fmax(slip[1], j->slip);
    }
    if (stops > 0)
        say(stderr,
            "limits of %d joints are stops of %.3g to %.3g N/m or N m/rad; not so: --no-limits\n",
            stops, stiff[0], stiff[1]);
    if (rubs > 0)
        say(stderr,
            "dry friction of %d joints is smooth below %.3g to %.3g m/s or rad/s; none: "
            "--no-friction\n",
            rubs, slip[0], slip[1]);
}

/* ---- all of it ---- */

static int simulate(const run_options *o, program_model *m, inputs *in, touching *contacts,
                    output *to)
{
    const double *q, *u;
    progress shown = progress_begin("run", o->t_end, o->quiet);
    mbsr_ida_opt opt;
    int code = start_state(&o->common, m, &q, &u);
    if (!code) code = drive_integrator(o, &opt);
    opt.progress = stop;
    opt.progress_user = &shown;
    opt.progress_interval = 0.1;
    const double step = drive_step(o);
    if (!code) code = output_open(o->file, to->columns, ceil(o->t_end / step) + 1.0, to);
    if (code) return code;
    inputs_set(in, 0.0, m->file->control);
    tell_beginning(o, m, &opt, to);
    code = touching_make(m, q, o->common.contacts, o->quiet, contacts);
    if (!code && !contacts->model && columns_have_contacts(to->columns))
        code = complain(USAGE, "--output: nothing touches");
    if (code) return code;
    mbsr_simulation s =
        mbsr_simulation_of(contacts->model ? contacts->model : mbsr_file_take_model(m->file));
    mbsr_data_destroy(m->data);
    m->data = NULL;
    signal(SIGINT, interrupt);
    if (mbsr_simulation_start(&s, &opt, 0.0, q, u))
        code = complain(FAILED, "%s: no start: %s", o->common.path, s.error.text);
    if (!code) code = go(o, m, &s, in, to);
    progress_end(&shown);
    if (interrupted) complain(FAILED, "stopped at t = %g; what was computed is kept", s.t);
    tell_end(o, &s, code, to);
    mbsr_simulation_end(&s);
    touching_free(contacts);
    return interrupted ? FAILED : code;
}

int run_run(int argc, char **argv)
{
    run_options o = {.common = {.limits = true, .friction = true, .contacts = true}};
    program_model m = {.text = NULL};
    touching contacts = {.contacts = NULL};
    columns c = {.list = NULL};
    output to = {.columns = &c};
    inputs in = {.actuator = NULL};
    int code = drive_options("run", argc, argv, &o);
    if (!code && o.common.json && !o.file)
        code = complain(USAGE, "run: --json goes to standard output, so the run needs -o FILE");
    if (code) return code;
    code = open_model(&o.common, o.quiet, &m);
    if (!code && !o.quiet) tell_joints(&m);
    if (!code) code = columns_make(&m, o.outputs, &c);
    c.touching = &contacts;
    if (!code && o.inputs) code = inputs_read(&m, o.inputs, &in);
    if (!code) code = simulate(&o, &m, &in, &contacts, &to);
    const int closing = output_close(&to);
    if (!code) code = closing;
    free(c.list);
    inputs_free(&in);
    close_model(&m);
    return code;
}
