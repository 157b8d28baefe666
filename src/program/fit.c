/* mbsrank fit: parameters of a model from measured data.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/progress.h"
#include "program/read_table.h"
#include "program/study_slopes.h"

#include <mbsrank/fit.h>

#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FITTED = 64, ROUNDS = 3 };

/* What is asked for; texts point into the arguments. */
typedef struct fit_options {
    run_options run;
    const char *data, *file;
    int fitted, noises;
    char name[MOST_FITTED][200]; /* of parameters */
    double low[MOST_FITTED], high[MOST_FITTED];
    const char *column[MOST_FITTED]; /* with noise that is known, */
    double noise[MOST_FITTED];
    bool json;
} fit_options;

typedef struct fit_work {
    const fit_options *o;
    table data; /* t and columns of the run */
    mbsr_study study;
    mbsr_study_parameter *parameter;
    mbsr_study_output *output;
    double *time;
    study_work work;
    double *noise; /* of each column */
    bool known;    /* noise of all columns is given */
    bool differs;  /* there are no sensitivities: runs are differenced */
    progress shown;
} fit_work;

static volatile sig_atomic_t interrupted;

static void interrupt_fit(int number)
{
    (void)number;
    interrupted = 1;
}

/* ---- options ---- */

/* "NAME", "NAME=LOW:HIGH". */
static int add_fitted(fit_options *o, const char *text)
{
    const char *equals = strrchr(text, '=');
    const size_t length = equals ? (size_t)(equals - text) : strlen(text);
    const int k = o->fitted;
    char *end = NULL;
    if (k == MOST_FITTED) return complain(USAGE, "fit: at most %d parameters", (int)MOST_FITTED);
    if (length == 0 || length >= sizeof o->name[k])
        return complain(USAGE, "--vary: '%s' is no parameter", text);
    memcpy(o->name[k], text, length);
    o->name[k][length] = '\0';
    o->low[k] = -INFINITY;
    o->high[k] = INFINITY;
    for (int l = 0; l < k; ++l)
        if (strcmp(o->name[l], o->name[k]) == 0)
            return complain(USAGE, "--vary: %s comes twice", o->name[k]);
    if (equals) {
        o->low[k] = strtod(equals + 1, &end);
        const bool first = end > equals + 1 && *end == ':';
        const char *from = first ? end + 1 : end;
        if (first) o->high[k] = strtod(from, &end);
        if (!first || end == from || *end || !(o->low[k] < o->high[k]))
            return complain(USAGE, "--vary: '%s' is not NAME=LOW:HIGH", text);
    }
    ++o->fitted;
    return DONE;
}

/* "COLUMN=DEVIATION". */
static int add_noise(fit_options *o, char *text)
{
    char *equals = strrchr(text, '=');
    if (!equals || equals == text || o->noises == MOST_FITTED)
        return complain(USAGE, "--noise: '%s' is not COLUMN=DEVIATION", text);
    *equals = '\0';
    o->column[o->noises] = text;
    return option_number("--noise", equals + 1, o->noise + o->noises++) ? DONE : USAGE;
}

/* Takes the options of a fit out of the arguments; the rest, *left of them, is that of a run. */
static int take_options(int argc, char **argv, fit_options *o, int *left)
{
    static const char *const names[] = {"--data", "--vary", "--noise", "-o"};
    int code = DONE;
    *left = 0;
    for (int at = 0; at < argc && !code; ++at) {
        const char *value = NULL;
        int k = -1;
        while (!value && at >= 0 && ++k < 4) value = option_value(argc, argv, &at, names[k]);
        if (at < 0) return USAGE;
        char *text = value ? argv[at] + (strlen(argv[at]) - strlen(value)) : NULL;
        if (!value && strcmp(argv[at], "--json") == 0)
            o->json = true;
        else if (!value)
            argv[(*left)++] = argv[at];
        else if (k == 0)
            o->data = value;
        else if (k == 3)
            o->file = value;
        else
            code = k == 1 ? add_fitted(o, value) : add_noise(o, text);
    }
    if (!code && !o->data) return complain(USAGE, "fit: --data is missing");
    if (!code && o->fitted == 0) return complain(USAGE, "fit: nothing is fitted: --vary NAME");
    return code;
}

/* ---- the runs ---- */

/* A study of one run after the other: columns of the data at their times. */
static int make_fit_study(fit_work *w)
{
    const fit_options *o = w->o;
    const int columns_there = w->data.columns - 1;
    w->parameter = calloc((size_t)o->fitted, sizeof *w->parameter);
    w->output = calloc((size_t)columns_there + 1, sizeof *w->output);
    w->time = calloc((size_t)w->data.lines + 1, sizeof *w->time);
    w->noise = calloc((size_t)columns_there + 1, sizeof *w->noise);
    if (!w->parameter || !w->output || !w->time || !w->noise) return complain(FAILED, "no memory");
    for (int k = 0; k < w->data.lines; ++k) w->time[k] = table_at(&w->data, k, 0);
    for (int k = 0; k < o->fitted; ++k)
        w->parameter[k] = (mbsr_study_parameter){.name = o->name[k], .unit = ""};
    for (int k = 0; k < columns_there; ++k)
        w->output[k] = (mbsr_study_output){.column = w->data.name[k + 1],
                                           .unit = "",
                                           .line = 1,
                                           .kind = MBSR_KEEP_AT,
                                           .times = w->data.lines,
                                           .time = w->time,
                                           .first = k * w->data.lines,
                                           .count = w->data.lines};
    w->study = (mbsr_study){.name = o->data,
                            .parameters = o->fitted,
                            .parameter = w->parameter,
                            .outputs = columns_there,
                            .output = w->output,
                            .numbers = columns_there * w->data.lines};
    return DONE;
}

/* What runs know of a column: their tolerance. No noise is less, or a column of rounding alone
 * would count for more than all others. */
static double least_noise(const fit_work *w, int k)
{
    double most = 0.0;
    for (int i = 0; i < w->data.lines; ++i) most = fmax(most, fabs(table_at(&w->data, i, k + 1)));
    return w->o->run.atol + w->o->run.rtol * most;
}

/* Noise that is given, and of other columns their own deviation at first. */
static int weigh_columns(fit_work *w)
{
    const int lines = w->data.lines;
    w->known = true;
    for (int k = 0; k < w->study.outputs; ++k) {
        double mean = 0.0, square = 0.0;
        for (int i = 0; i < lines; ++i) mean += table_at(&w->data, i, k + 1) / lines;
        for (int i = 0; i < lines; ++i)
            square += (table_at(&w->data, i, k + 1) - mean) * (table_at(&w->data, i, k + 1) - mean);
        w->noise[k] = square > 0.0 ? fmax(sqrt(square / lines), least_noise(w, k)) : 1.0;
        bool given = false;
        for (int l = 0; l < w->o->noises; ++l) {
            if (strcmp(w->o->column[l], w->data.name[k + 1]) != 0) continue;
            w->noise[k] = w->o->noise[l];
            given = true;
        }
        w->known = w->known && given;
    }
    for (int l = 0; l < w->o->noises; ++l)
        if (table_find(&w->data, w->o->column[l], 0) < 1)
            return complain(USAGE, "--noise: %s has no column '%s'", w->o->data, w->o->column[l]);
    return DONE;
}

static int compute_residuals(void *user, const double *p, double *r)
{
    fit_work *w = user;
    study_work *work = &w->work;
    mbsr_study_result result;
    if (interrupted) return -1;
    memcpy(work->parameter, p, (size_t)w->study.parameters * sizeof *p);
    study_try(work, &result);
    if (result.outcome != MBSR_RUN_DONE) return 1;
    for (int k = 0; k < w->study.outputs; ++k) {
        for (int i = 0; i < w->data.lines; ++i) {
            const int at = k * w->data.lines + i;
            r[at] = (work->value[at] - table_at(&w->data, i, k + 1)) / w->noise[k];
        }
    }
    return 0;
}

static int show_iteration(void *user, const mbsr_fit_progress *now)
{
    fit_work *w = user;
    progress_show(&w->shown, (double)now->iteration);
    return 0;
}

/* Noise of a column from its residuals. */
static double noise_of(const fit_work *w, const mbsr_fit *f, int k)
{
    const int lines = w->data.lines;
    const double share = (double)f->residuals / f->freedoms;
    double square = 0.0;
    for (int i = 0; i < lines; ++i)
        square += f->residual[k * lines + i] * f->residual[k * lines + i];
    return w->noise[k] * sqrt(share * square / lines);
}

/* Noise of each column anew; false: it is as it was. */
static bool reweigh(fit_work *w, const mbsr_fit *f)
{
    bool changed = false;
    for (int k = 0; k < w->study.outputs; ++k) {
        const double found = noise_of(w, f, k), noise = fmax(found, least_noise(w, k));
        changed = changed || !(fabs(noise / w->noise[k] - 1.0) < 0.01);
        if (found > 0.0) w->noise[k] = noise;
    }
    return changed;
}

/* By sensitivities of one run, as long as there are any. */
static int compute_slopes(void *user, const double *p, double *J)
{
    fit_work *w = user;
    if (interrupted) return -1;
    if (w->differs) return 1;
    memcpy(w->work.parameter, p, (size_t)w->study.parameters * sizeof *p);
    w->differs = study_slopes(&w->work, J) != 0;
    for (int k = 0; k < w->study.parameters && !w->differs; ++k)
        for (int l = 0; l < w->study.numbers; ++l)
            J[k * w->study.numbers + l] /= w->noise[l / w->data.lines];
    return w->differs;
}

static int fit_once(fit_work *w, const double *start, mbsr_fit **f)
{
    mbsr_error error = {.text = ""};
    mbsr_fit_opt opt = mbsr_default_fit_opt();
    opt.parameters = w->study.parameters;
    opt.residuals = w->study.numbers;
    opt.start = start;
    opt.low = w->o->low;
    opt.high = w->o->high;
    opt.residual = compute_residuals;
    opt.slopes = compute_slopes;
    opt.user = w;
    opt.tolerance = 1e-5;
    opt.known_noise = w->known;
    opt.noise_freedoms = (w->study.numbers - w->study.parameters) / w->study.outputs;
    opt.progress = show_iteration;
    opt.progress_user = w;
    if (!mbsr_fit_create(&opt, f, &error)) return DONE;
    if (interrupted) return complain(FAILED, "stopped");
    const char *why = w->work.text;
    return complain(FAILED, "fit: %s%s%s", error.text, *why ? ": " : "", why);
}

/* With noise that follows from the residuals as long as it changes; a code. */
static int fit_all(fit_work *w, mbsr_fit **f)
{
    double start[MOST_FITTED];
    for (int k = 0; k < w->study.parameters; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(w->work.list, w->work.which[k], &p);
        start[k] = p.value;
        if (!(p.value >= w->o->low[k] && p.value <= w->o->high[k]))
            return complain(USAGE, "--vary: %s begins at %g, which is not in %g .. %g; --set",
                            p.name, p.value, w->o->low[k], w->o->high[k]);
    }
    int code = fit_once(w, start, f);
    for (int round = 1; round < ROUNDS && !code && !w->known && reweigh(w, *f); ++round) {
        memcpy(start, (*f)->value, (size_t)w->study.parameters * sizeof *start);
        mbsr_fit_destroy(*f);
        code = fit_once(w, start, f);
    }
    return code;
}

/* ---- what is told ---- */

static const char *fitted_unit(const fit_work *w, int k)
{
    mbsr_parameter p;
    mbsr_parameter_get(w->work.list, w->work.which[k], &p);
    return p.unit;
}

/* Whether a direction is known to a half, or that of a parameter that a bound holds. */
static bool is_told(const mbsr_fit *f, int k)
{
    bool held = false;
    for (int l = 0; l < f->parameters; ++l)
        held = held || (f->at_bound[l] && f->direction[k * f->parameters + l] == 1.0);
    return held || f->direction_deviation[k] < 0.5;
}

static void tell_direction(const fit_work *w, const mbsr_fit *f, int k)
{
    if (isfinite(f->direction_deviation[k]))
        printf("the data do not tell %.3g times", f->direction_deviation[k]);
    else
        fputs("the data do not tell", stdout);
    for (int l = 0; l < f->parameters; ++l) {
        const double part = f->direction[k * f->parameters + l];
        if (fabs(part) > 0.1) say(stdout, " %+.2f %s", part, w->o->name[l]);
    }
    fputs(", relative\n", stdout);
}

/* Of a column that is met exactly nothing is known, and it counts as if it were. */
static void tell_noise(const fit_work *w, const mbsr_fit *f, int k)
{
    bool met = !w->known;
    for (int i = 0; i < w->data.lines && met; ++i)
        met = fabs(f->residual[k * w->data.lines + i]) < 1e-6; /* of what runs know at least */
    if (met)
        say(stdout,
            "%s is met exactly: without that column the other noises and intervals are larger\n",
            w->output[k].column);
    else
        say(stdout, "noise of %-27s %12.6g\n", w->output[k].column,
            w->known ? w->noise[k] : noise_of(w, f, k));
}

static void tell_fit_text(const fit_work *w, const mbsr_fit *f)
{
    static const char *const bounds[] = {"  at its lower bound", "", "  at its upper bound"};
    say(stdout, "%-36s %12s %12s   %-28s\n", "", "", "deviation", "95 %");
    for (int k = 0; k < f->parameters; ++k)
        say(stdout, "%-36s %12.6g %12.3g   %.6g .. %.6g %s%s\n", w->o->name[k], f->value[k],
            f->deviation[k], f->low[k], f->high[k], fitted_unit(w, k), bounds[1 + f->at_bound[k]]);
    for (int k = 0; k < w->study.outputs; ++k) tell_noise(w, f, k);
    if (w->known) say(stdout, "residuals are %.3g times the noise that is given\n", f->noise);
    for (int k = 0; k < f->parameters; ++k) {
        if (!is_told(f, k)) tell_direction(w, f, k);
    }
    say(stdout, "%d iterations, %d runs in the last round\n", f->iterations, f->evaluations);
}

static void tell_fit_json(const fit_work *w, const mbsr_fit *f)
{
    fputs("{\"parameters\": [", stdout);
    for (int k = 0; k < f->parameters; ++k) {
        fputs(k > 0 ? ", {\"name\": " : "{\"name\": ", stdout);
        put_json(stdout, w->o->name[k]);
        fputs(", \"unit\": ", stdout);
        put_json(stdout, fitted_unit(w, k));
        fputs(", \"value\": ", stdout);
        put_number(stdout, f->value[k]);
        fputs(", \"deviation\": ", stdout);
        put_number(stdout, f->deviation[k]);
        fputs(", \"interval\": ", stdout);
        put_numbers(stdout, 2, (const double[]){f->low[k], f->high[k]});
        printf(", \"at_bound\": %d}", f->at_bound[k]);
    }
    fputs("], \"noise\": ", stdout);
    put_numbers(stdout, w->study.outputs, w->noise);
    fputs(", \"residuals\": ", stdout);
    put_number(stdout, f->noise);
    fputs(", \"directions\": [", stdout);
    for (int k = 0; k < f->parameters; ++k) {
        fputs(k > 0 ? ", {\"deviation\": " : "{\"deviation\": ", stdout);
        put_number(stdout, f->direction_deviation[k]);
        fputs(", \"direction\": ", stdout);
        put_numbers(stdout, f->parameters, f->direction + k * f->parameters);
        fputc('}', stdout);
    }
    printf("], \"iterations\": %d, \"runs\": %d}\n", f->iterations, f->evaluations);
}

/* Data and what the model gives beside them, as CSV. */
static int write_fitted(const fit_work *w, const mbsr_fit *f)
{
    FILE *to = fopen(w->o->file, "w");
    if (!to) return complain_of_file(FAILED, w->o->file, "written");
    fputs("t", to);
    for (int k = 0; k < w->study.outputs; ++k)
        fprintf(to, ",\"%s.measured\",\"%s.fitted\"", w->output[k].column, w->output[k].column);
    fputc('\n', to);
    for (int i = 0; i < w->data.lines; ++i) {
        fprintf(to, "%.17g", w->time[i]);
        for (int k = 0; k < w->study.outputs; ++k) {
            const double measured = table_at(&w->data, i, k + 1);
            fprintf(to, ",%.17g,%.17g", measured,
                    measured + f->residual[k * w->data.lines + i] * w->noise[k]);
        }
        fputc('\n', to);
    }
    const bool bad = fflush(to) != 0 || ferror(to);
    return fclose(to) != 0 || bad ? complain_of_file(FAILED, w->o->file, "written") : DONE;
}

/* ---- all of it ---- */

static int open_fit(fit_options *o, int argc, char **argv, fit_work *w)
{
    int code = table_read(o->data, &w->data);
    if (!code && (w->data.lines < 2 || w->data.columns < 2))
        code = complain(NOT_READ, "%s has no columns, or less than two lines", o->data);
    if (!code && table_at(&w->data, 0, 0) < 0.0)
        code = complain(NOT_READ, "%s:2: the first time is before the start, 0", o->data);
    if (code) return code;
    o->run.t_end = table_at(&w->data, w->data.lines - 1, 0);
    code = drive_options("fit", argc, argv, &o->run);
    if (!code && o->run.outputs) code = complain(USAGE, "fit takes no --output");
    if (!code) code = make_fit_study(w);
    if (!code) code = study_open_given(&w->study, &o->run, &w->work);
    if (!code && w->study.numbers <= w->study.parameters)
        code = complain(USAGE, "fit: %d numbers are too few for %d parameters", w->study.numbers,
                        w->study.parameters);
    if (!code) code = weigh_columns(w);
    return code;
}

int run_fit(int argc, char **argv)
{
    fit_options o = {.run = {.rtol = 1e-8, .atol = 1e-9}};
    o.run.common = (program_options){.limits = true, .friction = true, .contacts = true};
    fit_work w = {.o = &o};
    mbsr_fit *f = NULL;
    int left, code = take_options(argc, argv, &o, &left);
    if (code) return code;
    code = open_fit(&o, left, argv, &w);
    signal(SIGINT, interrupt_fit);
    w.shown = progress_begin("fit: iteration", 100.0, o.run.quiet);
    if (!code) code = fit_all(&w, &f);
    progress_end(&w.shown);
    if (!code) (o.json ? tell_fit_json : tell_fit_text)(&w, f);
    if (!code && o.file) code = write_fitted(&w, f);
    mbsr_fit_destroy(f);
    study_close(&w.work);
    free(w.parameter);
    free(w.output);
    free(w.time);
    free(w.noise);
    table_free(&w.data);
    return code;
}
