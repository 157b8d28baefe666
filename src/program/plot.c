/* mbsrank plot: columns of a run as a picture, by gnuplot.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L
#include "program/plot.h"

#include "program/program.h"
#include "program/read_table.h"
#include "program/study_data.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

/* A column to be drawn, and the panel it is in. */
typedef struct curve {
    int column, panel;
} curve;

typedef struct curves {
    curve *list;
    int count, panels;
} curves;

static int read_plot_options(int argc, char **argv, plot_options *o)
{
    static const char *const names[] = {"-o", "--columns", "--title", "--over"};
    const char **const values[] = {&o->file, &o->columns, &o->title, &o->over};
    for (int at = 0; at < argc; ++at) {
        bool taken = false;
        for (int k = 0; k < 4 && !taken; ++k) {
            const char *value = option_value(argc, argv, &at, names[k]);
            if (at < 0) return USAGE;
            if (value) *values[k] = value, taken = true;
        }
        if (taken) continue;
        if (argv[at][0] == '-' && argv[at][1])
            return complain(USAGE, "plot: there is no option %s", argv[at]);
        if (o->run) return complain(USAGE, "one file at a time: '%s' is a second one", argv[at]);
        o->run = argv[at];
    }
    if (!o->run) return complain(USAGE, "there is no file; mbsrank plot --help");
    if (!o->file) return complain(USAGE, "plot: -o is missing");
    if (ends_in(o->file, ".png"))
        o->terminal = "pngcairo";
    else if (ends_in(o->file, ".svg"))
        o->terminal = "svg background 'white'";
    else
        return complain(USAGE, "plot: '%s' ends in neither .png nor .svg", o->file);
    return DONE;
}

static bool add_curve(curves *c, int column, int panel)
{
    curve *list = realloc(c->list, ((size_t)c->count + 1) * sizeof *list);
    if (!list) return false;
    c->list = list;
    list[c->count++] = (curve){column, panel};
    return true;
}

/* Whether a column is part of what `--output energy` writes. */
static bool is_energy(const char *column, const char *name, size_t length)
{
    return length == 6 && strncmp(name, "energy", length) == 0 &&
           (strcmp(column, "kinetic") == 0 || strcmp(column, "potential") == 0);
}

/* The column of that name, else all whose names go on with a point behind it, or both of the
 * energy. */
static int choose_columns(const table *t, const plot_options *o, const char *name, size_t length,
                          curves *c)
{
    const int before = c->count;
    bool good = true;
    for (int exact = 1; exact >= 0 && c->count == before; --exact) {
        for (int k = 1; k < t->columns && good; ++k) {
            const bool alike = strncmp(t->name[k], name, length) == 0;
            if ((alike && t->name[k][length] == (exact ? '\0' : '.')) ||
                (!exact && is_energy(t->name[k], name, length)))
                good = add_curve(c, k, c->panels - 1);
        }
    }
    if (!good) return complain(FAILED, "no memory");
    if (c->count > before) return DONE;
    return complain(USAGE, "%s has no column '%.*s'", o->run, (int)length, name);
}

/* All in one panel, or those named, where a colon begins another one. */
static int choose_all(const table *t, const plot_options *o, curves *c)
{
    const char *name = o->columns;
    int code = DONE;
    c->panels = 1;
    for (int k = 1; !name && k < t->columns; ++k) {
        if (!add_curve(c, k, 0)) return complain(FAILED, "no memory");
    }
    while (name && !code) {
        const size_t length = strcspn(name, ",:");
        code = choose_columns(t, o, name, length, c);
        c->panels += name[length] == ':';
        name = name[length] ? name + length + 1 : NULL;
    }
    if (!code && c->count == 0) return complain(NOT_READ, "%s has no columns but t", o->run);
    return code;
}

/* ---- what gnuplot is told ---- */

void plot_text(FILE *to, const char *text)
{
    fputc('\'', to);
    for (; *text; ++text) {
        if (*text == '\'') fputc('\'', to);
        fputc((unsigned char)*text < 0x20 ? ' ' : *text, to);
    }
    fputc('\'', to);
}

static void put_data(FILE *to, const table *t, const curves *c)
{
    fputs("$run << END_OF_RUN\n", to);
    for (int line = 0; line < t->lines; ++line) {
        fprintf(to, "%.10g", table_at(t, line, 0));
        for (int k = 0; k < c->count; ++k)
            fprintf(to, " %.10g", table_at(t, line, c->list[k].column));
        fputc('\n', to);
    }
    fputs("END_OF_RUN\n", to);
}

static void put_panels(FILE *to, const table *t, const curves *c)
{
    fputs("set key outside right top\n"
          "set lmargin at screen 0.08\nset rmargin at screen 0.8\n",
          to);
    for (int panel = 0; panel < c->panels; ++panel) {
        const char *before = "plot ";
        if (panel + 1 == c->panels) fputs("set xlabel 't, s'\n", to);
        for (int k = 0; k < c->count; ++k) {
            if (c->list[k].panel != panel) continue;
            fprintf(to, "%s$run using 1:%d with lines linewidth 1.5 title ", before, k + 2);
            plot_text(to, t->name[c->list[k].column]);
            before = ", ";
        }
        fputc('\n', to);
    }
}

FILE *plot_begin(const plot_options *o, int panels)
{
    signal(SIGPIPE, SIG_IGN); /* where it ends early */
    FILE *to = popen("gnuplot -", "w");
    if (!to) {
        complain(FAILED, "plot: gnuplot cannot be run");
        return NULL;
    }
    fprintf(to, "set terminal %s noenhanced size 1000,%d\nset output ", o->terminal,
            120 + (panels > 1 ? 260 : 400) * panels);
    plot_text(to, o->file);
    fprintf(to, "\nset multiplot layout %d,1", panels);
    if (o->title) fputs(" title ", to), plot_text(to, o->title);
    fputs("\nset grid\n", to);
    return to;
}

int plot_end(const plot_options *o, FILE *to)
{
    fputs("unset multiplot\n", to);
    const int status = pclose(to);
    if (status == 0) return DONE;
    if (status > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 127)
        return complain(FAILED, "plot: gnuplot is missing; it draws the picture");
    return complain(FAILED, "plot: gnuplot has not drawn %s", o->file);
}

static int draw_run(const table *t, const plot_options *o, const curves *c)
{
    FILE *to = plot_begin(o, c->panels);
    if (!to) return FAILED;
    put_data(to, t, c);
    put_panels(to, t, c);
    return plot_end(o, to);
}

int run_plot(int argc, char **argv)
{
    plot_options o = {.run = NULL};
    table t = {.text = NULL};
    curves c = {.list = NULL};
    int code = read_plot_options(argc, argv, &o);
    if (code) return code;
    if (study_data_is(o.run)) return plot_study(&o);
    if (o.over) return complain(USAGE, "plot: --over is for results of a study");
    code = table_read(o.run, &t);
    if (!code && t.lines == 0) code = complain(NOT_READ, "%s has no lines of numbers", o.run);
    if (!code) code = choose_all(&t, &o, &c);
    if (!code) code = draw_run(&t, &o, &c);
    free(c.list);
    table_free(&t);
    return code;
}
