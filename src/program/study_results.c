/* What all runs of a study have given: see study_results.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/study_results.h"

#include "program/hdf5.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool take_room(study_results *r)
{
    const size_t runs = (size_t)r->runs, parameters = (size_t)r->work->study->parameters,
                 numbers = (size_t)r->work->study->numbers;
    r->outcome = calloc(runs, sizeof *r->outcome);
    r->status = calloc(runs, sizeof *r->status);
    r->steps = calloc(runs, sizeof *r->steps);
    r->parameter = calloc(runs * parameters, sizeof *r->parameter);
    r->value = calloc(runs * numbers, sizeof *r->value);
    return r->outcome && r->status && r->steps && r->parameter && r->value;
}

static bool add_failure(study_results *r, const mbsr_study_result *one)
{
    const size_t count = (size_t)r->failures;
    if ((count & (count - 1)) == 0) { /* powers of two */
        const size_t room = count > 0 ? 2 * count : 1;
        long *failed = realloc(r->failed, room * sizeof *failed);
        if (failed) r->failed = failed;
        char(*text)[MBSR_TEXT_SIZE] = realloc(r->text, room * sizeof *text);
        if (text) r->text = text;
        if (!failed || !text) return false;
    }
    r->failed[r->failures] = one->run;
    snprintf(r->text[r->failures++], MBSR_TEXT_SIZE, "%s", one->text);
    return true;
}

static int take_runs(study_work *w, mbsr_journal *j, study_results *r)
{
    mbsr_error error = {.text = ""};
    char text[MBSR_TEXT_SIZE];
    for (long run = 0; run < r->runs; ++run) {
        mbsr_study_result one;
        if (mbsr_journal_get(j, run, w->value, text, &one, &error))
            return complain(FAILED, "%s", error.text);
        if (mbsr_study_values(w->study, run, w->parameter))
            return complain(FAILED, "run %ld has no values", run);
        for (int k = 0; k < w->study->parameters; ++k)
            r->parameter[(long)k * r->runs + run] = w->parameter[k];
        for (int k = 0; k < w->study->numbers; ++k) r->value[(long)k * r->runs + run] = w->value[k];
        r->outcome[run] = (int)one.outcome;
        r->status[run] = one.status;
        r->steps[run] = (double)one.steps;
        ++r->outcomes[one.outcome];
        if (one.outcome != MBSR_RUN_DONE && one.outcome != MBSR_RUN_MISSING &&
            !add_failure(r, &one))
            return complain(FAILED, "no memory");
    }
    return DONE;
}

int results_collect(study_work *w, const char *folder, study_results *r)
{
    mbsr_journal *j;
    mbsr_error error = {.text = ""};
    mbsr_journal_opt opt = mbsr_default_journal_opt();
    *r = (study_results){.work = w, .runs = w->study->runs};
    if (!take_room(r)) return complain(FAILED, "no memory");
    opt.folder = folder;
    opt.key = w->key;
    opt.writer = -1;
    if (mbsr_journal_open(&opt, w->study, &j, &error)) return complain(FAILED, "%s", error.text);
    const int code = take_runs(w, j, r);
    mbsr_journal_close(j, 0);
    return code;
}

void results_free(study_results *r)
{
    free(r->outcome);
    free(r->status);
    free(r->steps);
    free(r->parameter);
    free(r->value);
    free(r->failed);
    free(r->text);
}

study_statistics results_statistics(const study_results *r, int k, double *scratch)
{
    const double *x = r->value + (long)k * r->runs;
    long count = 0;
    for (long run = 0; run < r->runs; ++run) {
        if (r->outcome[run] == MBSR_RUN_DONE && isfinite(x[run])) scratch[count++] = x[run];
    }
    return statistics_of(count, scratch);
}

/* ---- writing ---- */

void results_number_name(const study_results *r, int output, int k, char name[OUTPUT_NAME])
{
    const mbsr_study_output *o = r->work->study->output + output;
    study_output_name(r->work, output, name);
    const size_t length = strlen(name);
    if (o->times > 1) snprintf(name + length, OUTPUT_NAME - length, " %g", o->time[k]);
}

static const char *outcome_name(int outcome)
{
    static const char *const names[] = {
        [MBSR_RUN_DONE] = "done", [MBSR_RUN_FAILED] = "failed",   [MBSR_RUN_STEPS] = "steps",
        [MBSR_RUN_TIME] = "time", [MBSR_RUN_CRASHED] = "crashed", [MBSR_RUN_MISSING] = "missing"};
    return names[outcome];
}

static void put_cell(FILE *to, const char *text)
{
    fputs(",\"", to);
    for (; *text; ++text) fprintf(to, *text == '"' ? "\"\"" : "%c", *text);
    fputc('"', to);
}

static void write_csv(const study_results *r, FILE *to)
{
    const mbsr_study *s = r->work->study;
    long failure = 0;
    fputs("run", to);
    for (int k = 0; k < s->parameters; ++k) put_cell(to, s->parameter[k].name);
    for (int k = 0; k < s->outputs; ++k) {
        for (int l = 0; l < s->output[k].count; ++l) {
            char name[OUTPUT_NAME];
            results_number_name(r, k, l, name);
            put_cell(to, name);
        }
    }
    fputs(",outcome,status,steps,text\n", to);
    for (long run = 0; run < r->runs; ++run) {
        fprintf(to, "%ld", run);
        for (int k = 0; k < s->parameters; ++k)
            fprintf(to, ",%.17g", r->parameter[k * r->runs + run]);
        for (int k = 0; k < s->numbers; ++k) {
            const double x = r->value[k * r->runs + run];
            if (isfinite(x))
                fprintf(to, ",%.17g", x);
            else
                fputc(',', to);
        }
        fprintf(to, ",%s,%d,%.0f", outcome_name(r->outcome[run]), r->status[run], r->steps[run]);
        const bool failed = failure < r->failures && r->failed[failure] == run;
        put_cell(to, failed ? r->text[failure++] : "");
        fputc('\n', to);
    }
}

static int write_csv_file(const study_results *r, const char *path)
{
    FILE *to = fopen(path, "w");
    if (!to) return complain_of_file(FAILED, path, "written");
    write_csv(r, to);
    bool bad = fflush(to) != 0 || ferror(to) || fsync(fileno(to)) != 0;
    const int reason = errno;
    bad = fclose(to) != 0 || bad;
    errno = reason;
    return bad ? complain_of_file(FAILED, path, "written") : DONE;
}

int results_write(const study_results *r, const char *path)
{
    const size_t size = strlen(path) + 8;
    char *beside = malloc(size);
    if (!beside) return complain(FAILED, "no memory");
    snprintf(beside, size, "%s.new", path);
    int code = names_hdf5(path) ? hdf5_write_study(r, beside) : write_csv_file(r, beside);
    if (!code && rename(beside, path) != 0) code = complain_of_file(FAILED, path, "written");
    if (code) remove(beside);
    free(beside);
    return code;
}

/* ---- telling ---- */

static void tell_json(const study_results *r, double *scratch, FILE *to)
{
    const mbsr_study *s = r->work->study;
    fprintf(to, "{\"runs\": %ld, \"outcomes\": {", r->runs);
    for (int k = 0; k <= MBSR_RUN_MISSING; ++k)
        fprintf(to, "%s\"%s\": %ld", k > 0 ? ", " : "", outcome_name(k), r->outcomes[k]);
    fputs("}, \"outputs\": [", to);
    for (int k = 0; k < s->outputs; ++k) {
        for (int l = 0; l < s->output[k].count; ++l) {
            const int number = s->output[k].first + l;
            const study_statistics one = results_statistics(r, number, scratch);
            const double numbers[] = {one.mean,   one.deviation, one.least, one.low,
                                      one.median, one.high,      one.most};
            char name[OUTPUT_NAME];
            results_number_name(r, k, l, name);
            fputs(number > 0 ? ", {\"name\": " : "{\"name\": ", to);
            put_json(to, name);
            fputs(", \"unit\": ", to);
            put_json(to, study_output_unit(r->work, k));
            fprintf(to, ", \"count\": %ld, \"statistics\": ", one.count);
            put_numbers(to, 7, numbers);
            fputc('}', to);
        }
    }
    fputs("]}\n", to);
}

static void tell_table(const study_results *r, double *scratch, FILE *to)
{
    const mbsr_study *s = r->work->study;
    enum { MOST_LINES = 40, MOST_TIMES = 5 };
    int lines = 0;
    say(to, "%-30s %8s %6s %11s %11s %11s %11s %11s\n", "", "unit", "runs", "mean", "deviation",
        "5 %", "median", "95 %");
    for (int k = 0; k < s->outputs; ++k) {
        if (s->output[k].count > MOST_TIMES) continue;
        for (int l = 0; l < s->output[k].count && lines < MOST_LINES; ++l, ++lines) {
            const study_statistics one = results_statistics(r, s->output[k].first + l, scratch);
            char name[OUTPUT_NAME];
            results_number_name(r, k, l, name);
            say(to, "%-30s %8s %6ld %11.5g %11.5g %11.5g %11.5g %11.5g\n", name,
                study_output_unit(r->work, k), one.count, one.mean, one.deviation, one.low,
                one.median, one.high);
        }
    }
    if (s->numbers > lines) say(to, "and %d numbers at more times\n", s->numbers - lines);
}

int results_tell(const study_results *r, bool json, FILE *to)
{
    double *scratch = calloc((size_t)r->runs, sizeof *scratch);
    if (!scratch) return complain(FAILED, "no memory");
    (json ? tell_json : tell_table)(r, scratch, to);
    free(scratch);
    return DONE;
}
