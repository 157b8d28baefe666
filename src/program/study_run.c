/* A study with its model: see study_run.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/study_run.h"

#include "program/touching.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- opening ---- */

static char *copy_text(const char *text)
{
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* The path of the model, which is that of the study's folder. */
static char *model_path(const char *study, const char *model)
{
    const char *slash = strrchr(study, '/');
    const int folder = slash && model[0] != '/' ? (int)(slash + 1 - study) : 0;
    const size_t size = (size_t)folder + strlen(model) + 1;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%.*s%s", folder, study, model);
    return path;
}

static int read_options(study_work *w)
{
    const mbsr_study *s = w->study;
    char command[300];
    run_options *o = &w->options;
    if (!s->model_line) return complain(NOT_READ, "%s: there is no line of model", s->name);
    if (!s->run_line) return complain(NOT_READ, "%s: there is no line of run", s->name);
    w->word = calloc((size_t)s->words + 1, sizeof *w->word);
    w->path = model_path(s->name, s->model);
    bool good = w->word && w->path;
    for (int k = 0; k < s->words && good; ++k) good = (w->word[k] = copy_text(s->word[k])) != NULL;
    if (!good) return complain(FAILED, "no memory");
    snprintf(command, sizeof command, "%.200s:%d: run", s->name, s->run_line);
    *o = (run_options){.common = {.limits = true, .friction = true, .contacts = true}};
    const int code = drive_options(command, s->words, w->word, o);
    if (code) return code;
    if (o->common.path || o->common.json || o->file || o->outputs)
        return complain(USAGE, "%s takes no file, --json, --output and -o", command);
    o->common.path = w->path;
    return DONE;
}

static int find_parameter(const study_work *w, const mbsr_study_parameter *p, int *which)
{
    mbsr_parameter known;
    *which = mbsr_parameters_find(w->list, p->name);
    if (*which == MBSR_NONE && p->line == 0)
        return complain(USAGE, "--vary: there is no parameter %s; mbsrank info --parameters",
                        p->name);
    if (*which == MBSR_NONE)
        return complain(USAGE, "%s:%d: there is no parameter %s; mbsrank info --parameters",
                        w->study->name, p->line, p->name);
    mbsr_parameter_get(w->list, *which, &known);
    if (*p->unit && strcmp(p->unit, known.unit) != 0)
        return complain(USAGE, "%s:%d: %s has the unit '%s', not '%s'", w->study->name, p->line,
                        p->name, known.unit, p->unit);
    return DONE;
}

static int find_parameters(study_work *w)
{
    mbsr_error error = {.text = ""};
    int code = DONE;
    if (mbsr_parameters_create(w->m.model, &w->list, &error))
        return complain(FAILED, "%s", error.text);
    w->which = calloc((size_t)w->study->parameters + 1, sizeof *w->which);
    if (!w->which) return complain(FAILED, "no memory");
    for (int k = 0; k < w->study->parameters && !code; ++k)
        code = find_parameter(w, w->study->parameter + k, w->which + k);
    return code;
}

bool study_needs_no_forces(const study_work *w, const column *c)
{
    if (c->kind != COLUMN_SENSOR) return true;
    const mbsr_file_sensor_kind kind = w->m.file->sensor[c->at].kind;
    return kind != MBSR_SENSOR_ACCELERATION && kind != MBSR_SENSOR_SPIN_RATE &&
           kind != MBSR_SENSOR_FORCE && kind != MBSR_SENSOR_TORQUE;
}

static int check_output(study_work *w, const mbsr_study_output *o, const column *c)
{
    const char *name = w->study->name;
    const bool crosses = o->kind == MBSR_KEEP_RISES || o->kind == MBSR_KEEP_FALLS;
    const char *unit = crosses ? "s" : c->unit;
    if (*o->unit && strcmp(o->unit, unit) != 0)
        return complain(USAGE, "%s:%d: '%s' has the unit '%s', not '%s'", name, o->line, o->column,
                        unit, o->unit);
    if (o->times > 0 && o->time[o->times - 1] > w->options.t_end * (1.0 + 1e-12))
        return complain(USAGE, "%s:%d: time %g of '%s' is behind --t-end %g", name, o->line,
                        o->time[o->times - 1], o->column, w->options.t_end);
    if (crosses && !study_needs_no_forces(w, c))
        return complain(USAGE, "%s:%d: crossings are of positions and velocities, not of '%s'",
                        name, o->line, o->column);
    w->crossings += crosses;
    w->scanned = w->scanned || o->kind == MBSR_KEEP_MAX || o->kind == MBSR_KEEP_MIN ||
                 o->kind == MBSR_KEEP_MEAN;
    return DONE;
}

static int choose_columns_of(study_work *w)
{
    const mbsr_study *s = w->study;
    columns all = {.count = 0};
    int code = columns_all(&w->m, &all);
    w->c = (columns){.file = w->m.file, .count = s->outputs};
    w->c.list = calloc((size_t)s->outputs + 1, sizeof *w->c.list);
    if (!code && !w->c.list) code = complain(FAILED, "no memory");
    for (int k = 0; k < s->outputs && !code; ++k) {
        const mbsr_study_output *o = s->output + k;
        int at = 0;
        while (at < all.count && strcmp(all.list[at].name, o->column) != 0) ++at;
        if (at == all.count)
            code = complain(USAGE, "%s:%d: there is no column '%s'", s->name, o->line, o->column);
        else
            code = check_output(w, o, all.list + at);
        if (!code) w->c.list[k] = all.list[at];
    }
    free(all.list);
    return code;
}

static uint64_t hash_more(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    for (size_t k = 0; k < size; ++k) hash = (hash ^ at[k]) * UINT64_C(1099511628211);
    return hash;
}

/* Of the texts of study and model, of all numbers of the model, and of the inputs. */
static void make_key(study_work *w, const char *text, size_t size)
{
    uint64_t key = hash_more(UINT64_C(14695981039346656037), text, size);
    key = hash_more(key, w->m.text, w->m.size);
    for (int k = 0; k < mbsr_parameters_count(w->list); ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(w->list, k, &p);
        key = hash_more(key, p.name, strlen(p.name) + 1);
        key = hash_more(key, &p.value, sizeof p.value);
    }
    const table *t = &w->in.table;
    if (t->lines > 0)
        key = hash_more(key, t->value, (size_t)t->lines * (size_t)t->columns * sizeof *t->value);
    w->key = hash_more(key, mbsr_version(), strlen(mbsr_version()));
}

/* Of what is known from study and options. */
static int open_work(study_work *w, bool quiet)
{
    const mbsr_study *s = w->study;
    const double *q, *u;
    int code = drive_integrator(&w->options, &w->opt);
    if (!code) code = open_model(&w->options.common, quiet || w->options.quiet, &w->m);
    if (!code) code = start_state(&w->options.common, &w->m, &q, &u);
    if (!code && w->options.inputs) code = inputs_read(&w->m, w->options.inputs, &w->in);
    if (!code) code = find_parameters(w);
    if (!code) code = choose_columns_of(w);
    if (code) return code;
    w->parameter = calloc((size_t)s->parameters + 1, sizeof(double));
    w->row = calloc((size_t)s->outputs + 1, sizeof(double));
    w->value = calloc((size_t)s->numbers + 1, sizeof(double));
    return w->parameter && w->row && w->value ? DONE : complain(FAILED, "no memory");
}

int study_open_given(const mbsr_study *study, const run_options *options, study_work *w)
{
    *w = (study_work){.study = study, .options = *options};
    return open_work(w, false);
}

int study_open(const char *path, bool quiet, study_work *w)
{
    mbsr_error error = {.text = ""};
    size_t size;
    *w = (study_work){.study = NULL};
    char *text = read_file(path, &size);
    if (!text) return complain_of_file(NOT_READ, path, "read");
    int code = DONE;
    if (mbsr_study_read(text, size, path, NULL, &w->read, &error))
        code = complain(NOT_READ, "%s", error.text);
    w->study = w->read;
    if (!code) code = read_options(w);
    if (!code) code = open_work(w, quiet);
    if (!code) make_key(w, text, size);
    free(text);
    return code;
}

void study_close(study_work *w)
{
    free(w->parameter);
    free(w->row);
    free(w->value);
    free(w->c.list);
    free(w->which);
    mbsr_parameters_destroy(w->list);
    inputs_free(&w->in);
    close_model(&w->m);
    for (int k = 0; w->word && k < w->study->words; ++k) free(w->word[k]);
    free(w->word);
    free(w->path);
    mbsr_study_destroy(w->read);
}

/* ---- what a run gives ---- */

/* A run as it goes. */
typedef struct watch {
    study_work *w;
    mbsr_simulation *s;
    int *at;        /* outputs: the next time of each; 1 behind a crossing that was found */
    double *before; /* outputs: value at the last scanned state */
    long scans;     /* scanned states, at multiples of the step and at the end */
    double scanned; /* time of the last one */
    /* of crossings: */
    mbsr_data *data;
    double *q, *u;
    int *direction;  /* crossings */
    double deadline; /* real time; infinite: none */
} watch;

enum { STOP_STEPS = 1, STOP_TIME = 2 };

static double real_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Between two steps. */
static int hold_limits(void *user, const mbsr_ida_progress *now)
{
    const watch *run = user;
    const long most = run->w->study->max_steps;
    if (most > 0 && now->steps > most) return STOP_STEPS;
    return real_time() > run->deadline ? STOP_TIME : 0;
}

static bool is_crossing(const mbsr_study_output *o)
{
    return o->kind == MBSR_KEEP_RISES || o->kind == MBSR_KEEP_FALLS;
}

/* Distances to the levels of crossings. */
static int cross(void *user, double t, const double *y, const double *yp, double *value)
{
    watch *run = user;
    const study_work *w = run->w;
    const mbsr_model *model = run->s->model;
    (void)yp;
    int status = mbsr_dae_unpack(model, run->data, w->opt.form, t, y, run->q, run->u);
    if (!status) status = mbsr_stage_positions(model, run->data, t, run->q);
    if (!status) status = mbsr_stage_velocities(model, run->data, run->u);
    for (int k = 0; k < w->study->outputs && !status; ++k) {
        const mbsr_study_output *o = w->study->output + k;
        const columns one = {.file = w->c.file, .list = w->c.list + k, .count = 1};
        if (!is_crossing(o)) continue;
        status = columns_values(&one, model, run->data, t, run->q, run->u, value);
        *value++ -= o->level;
    }
    return status;
}

static double next_wanted(void *user)
{
    const watch *run = user;
    const study_work *w = run->w;
    double next = w->scanned ? (double)run->scans * drive_step(&w->options) : INFINITY;
    for (int k = 0; k < w->study->outputs; ++k) {
        const mbsr_study_output *o = w->study->output + k;
        if (run->at[k] < o->times) next = fmin(next, o->time[run->at[k]]);
    }
    return next;
}

/* The first crossing in its direction. */
static int take_crossings(watch *run)
{
    const study_work *w = run->w;
    const int *direction = run->direction;
    if (mbsr_ida_event_info(run->s->ida, run->direction)) return FAILED;
    for (int k = 0; k < w->study->outputs; ++k) {
        const mbsr_study_output *o = w->study->output + k;
        if (!is_crossing(o)) continue;
        const int wanted = o->kind == MBSR_KEEP_RISES ? 1 : -1;
        if (*direction++ != wanted || run->at[k]) continue;
        run->at[k] = 1;
        w->value[o->first] = run->s->t;
    }
    return DONE;
}

static void scan(watch *run, int k, double x)
{
    const mbsr_study_output *o = run->w->study->output + k;
    double *value = run->w->value + o->first;
    const bool first = run->scans == 0;
    if (o->kind == MBSR_KEEP_MAX) *value = first ? x : fmax(*value, x);
    if (o->kind == MBSR_KEEP_MIN) *value = first ? x : fmin(*value, x);
    if (o->kind == MBSR_KEEP_MEAN)
        *value = first ? 0.0
                       : *value + 0.5 * (x + run->before[k]) * (run->s->t - run->scanned) /
                                      run->w->options.t_end;
    run->before[k] = x;
}

static int take_kept(void *user, const mbsr_simulation *s, bool event)
{
    watch *run = user;
    study_work *w = run->w;
    if (event) return take_crossings(run);
    const double late = s->t * (1.0 + 1e-12), step = drive_step(&w->options);
    const bool scanned =
        w->scanned && (late >= (double)run->scans * step || s->t >= w->options.t_end);
    if (columns_values(&w->c, s->model, s->data, s->t, s->q, s->u, w->row)) {
        snprintf(w->text, sizeof w->text, "%s", mbsr_data_error(s->data)->text);
        return FAILED;
    }
    for (int k = 0; k < w->study->outputs; ++k) {
        const mbsr_study_output *o = w->study->output + k;
        for (int *at = run->at + k; *at < o->times && o->time[*at] <= late; ++*at)
            w->value[o->first + *at] = w->row[k];
        if (scanned) scan(run, k, w->row[k]);
    }
    if (scanned) {
        ++run->scans;
        run->scanned = s->t;
    }
    return DONE;
}

/* ---- a run ---- */

static int prepare_crossings(watch *run, mbsr_ida_opt *opt)
{
    mbsr_error error = {.text = ""};
    const mbsr_model *model = run->s->model;
    const int crossings = run->w->crossings;
    if (crossings == 0) return DONE;
    run->q = calloc((size_t)mbsr_model_nq(model) + 1, sizeof *run->q);
    run->u = calloc((size_t)mbsr_model_nu(model) + 1, sizeof *run->u);
    run->direction = calloc((size_t)crossings, sizeof *run->direction);
    if (!run->q || !run->u || !run->direction || mbsr_data_create(model, &run->data, &error))
        return FAILED;
    opt->events = crossings;
    opt->event = cross;
    opt->event_user = run;
    return DONE;
}

/* From start to end; a code, and the reason in w->text. */
static int go_through(watch *run, const double *q, const double *u)
{
    study_work *w = run->w;
    const drive_taker taker = {next_wanted, take_kept, run};
    mbsr_ida_opt opt = w->opt;
    opt.progress = hold_limits;
    opt.progress_user = run;
    run->at = calloc((size_t)w->study->outputs + 1, sizeof *run->at);
    run->before = calloc((size_t)w->study->outputs + 1, sizeof *run->before);
    if (!run->at || !run->before || prepare_crossings(run, &opt)) {
        snprintf(w->text, sizeof w->text, "no memory");
        return FAILED;
    }
    for (int k = 0; k < w->study->numbers; ++k) w->value[k] = NAN;
    if (mbsr_simulation_start(run->s, &opt, 0.0, q, u)) {
        snprintf(w->text, sizeof w->text, "no start: %.240s", run->s->error.text);
        return FAILED;
    }
    return drive(&w->options, &w->m, run->s, &w->in, &taker, w->text);
}

static void end_run(watch *run, int code, mbsr_study_result *result)
{
    mbsr_ida_stats cost = {0};
    const int status = run->s->status;
    mbsr_simulation_get_stats(run->s, &cost);
    result->steps = cost.steps;
    if (!code) return;
    result->outcome = status == STOP_STEPS  ? MBSR_RUN_STEPS
                      : status == STOP_TIME ? MBSR_RUN_TIME
                                            : MBSR_RUN_FAILED;
    result->status = status ? status : MBSR_ERR_VALUE;
    if (result->outcome == MBSR_RUN_STEPS)
        snprintf(run->w->text, sizeof run->w->text, "more than %ld steps at t = %.6g",
                 run->w->study->max_steps, run->s->t);
    if (result->outcome == MBSR_RUN_TIME)
        snprintf(run->w->text, sizeof run->w->text, "more than %g s of real time",
                 run->w->study->max_time);
}

void study_try(study_work *w, mbsr_study_result *result)
{
    const mbsr_study *study = w->study;
    const double *q, *u;
    mbsr_error error = {.text = ""};
    mbsr_model *model;
    touching contacts = {.contacts = NULL};
    result->outcome = MBSR_RUN_DONE;
    result->status = MBSR_OK;
    result->steps = 0;
    result->value = w->value;
    result->text = w->text;
    w->text[0] = '\0';
    const int refused =
        mbsr_parameters_model(w->list, study->parameters, w->which, w->parameter, &model, &error);
    if (refused) {
        snprintf(w->text, sizeof w->text, "%s", error.text);
        result->outcome = MBSR_RUN_FAILED;
        result->status = refused;
        return;
    }
    program_model one = w->m;
    one.model = model;
    if (!one.read) one.read = w->m.model;
    for (int k = 0; k < one.file->actuators; ++k) one.file->control[k] = 0.0;
    int code = start_state(&w->options.common, &one, &q, &u);
    w->in.next = 0;
    inputs_set(&w->in, 0.0, one.file->control);
    if (!code) code = touching_make(&one, q, w->options.common.contacts, true, &contacts);
    if (code) snprintf(w->text, sizeof w->text, "no start, or no contacts can be made");
    mbsr_simulation s = mbsr_simulation_of(contacts.model ? contacts.model : model);
    watch run = {.w = w, .s = &s, .deadline = INFINITY};
    if (study->max_time > 0.0) run.deadline = real_time() + study->max_time;
    if (!code) code = go_through(&run, q, u);
    end_run(&run, code, result);
    mbsr_simulation_end(&s);
    mbsr_data_destroy(run.data);
    free(run.direction);
    free(run.q);
    free(run.u);
    free(run.at);
    free(run.before);
    if (contacts.model) mbsr_model_destroy(model);
    touching_free(&contacts);
}

void study_do(study_work *w, long run, mbsr_study_result *result)
{
    const int refused = mbsr_study_values(w->study, run, w->parameter);
    if (refused) {
        snprintf(w->text, sizeof w->text, "it has no values");
        *result = (mbsr_study_result){
            .outcome = MBSR_RUN_FAILED, .status = refused, .value = w->value, .text = w->text};
    } else {
        study_try(w, result);
    }
    result->run = run;
}

/* ---- names ---- */

void study_output_name(const study_work *w, int k, char name[OUTPUT_NAME])
{
    static const char *const kinds[] = {
        [MBSR_KEEP_AT] = "at",     [MBSR_KEEP_MAX] = "max",     [MBSR_KEEP_MIN] = "min",
        [MBSR_KEEP_MEAN] = "mean", [MBSR_KEEP_RISES] = "rises", [MBSR_KEEP_FALLS] = "falls"};
    const mbsr_study_output *o = w->study->output + k;
    char level[40] = "";
    if (is_crossing(o)) snprintf(level, sizeof level, " %g", o->level);
    if (o->times == 1) snprintf(level, sizeof level, " %g", o->time[0]);
    snprintf(name, OUTPUT_NAME, "%.190s %s%s", o->column, kinds[o->kind], level);
}

const char *study_output_unit(const study_work *w, int k)
{
    return is_crossing(w->study->output + k) ? "s" : w->c.list[k].unit;
}
