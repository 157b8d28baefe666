/* Pictures of studies: envelopes, histograms, scatter over a parameter.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/plot.h"

#include "program/program.h"
#include "program/statistics.h"
#include "program/study_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PANELS = 8, MOST_BARS = 40 };

/* What is drawn in a panel: a column, or several that are one output at several times. */
typedef struct study_panel {
    int column, count;
    char name[256];
} study_panel;

typedef struct study_picture {
    const plot_options *options;
    study_data d;
    study_panel panel[MOST_PANELS];
    int panels, over; /* column of the parameter; -1: none */
    double *x;        /* numbers of a column */
} study_picture;

/* Outputs have a blank in their names. */
static bool is_output(const char *name)
{
    return strchr(name, ' ') != NULL;
}

static study_panel panel_at(const study_data *d, int k)
{
    size_t length;
    study_panel p = {.column = k, .count = study_data_series(d, k, &length)};
    snprintf(p.name, sizeof p.name, "%.*s", p.count > 1 ? (int)length : 255, d->t.name[k]);
    return p;
}

/* The output or parameter of that name: "damper max", "damper" at all its times, "damper at 0.5".
 */
static int add_panel(study_picture *p, const char *name)
{
    const table *t = &p->d.t;
    if (p->panels == MOST_PANELS)
        return complain(USAGE, "plot: a picture has at most %d panels", (int)MOST_PANELS);
    for (int k = 1; k < t->columns;) {
        study_panel one = panel_at(&p->d, k);
        const int exact = table_find(t, name, k);
        if (strcmp(one.name, name) == 0 || exact == k) {
            p->panel[p->panels++] = one;
            return DONE;
        }
        if (exact > k && exact < k + one.count) {
            one = (study_panel){.column = exact, .count = 1};
            snprintf(one.name, sizeof one.name, "%.255s", name);
            p->panel[p->panels++] = one;
            return DONE;
        }
        k += one.count;
    }
    return complain(USAGE, "%s has no column '%s'", p->options->run, name);
}

static int choose_panels(study_picture *p)
{
    const char *name = p->options->columns;
    int code = DONE;
    p->over = p->options->over ? table_find(&p->d.t, p->options->over, 0) : -1;
    if (p->options->over && p->over < 0)
        return complain(USAGE, "%s has no column '%s'", p->options->run, p->options->over);
    for (int k = 1; !name && k < p->d.t.columns && p->panels < MOST_PANELS;) {
        const study_panel one = panel_at(&p->d, k);
        if (is_output(p->d.t.name[k])) p->panel[p->panels++] = one;
        k += one.count;
    }
    while (name && !code) {
        char one[256];
        const size_t length = strcspn(name, ",:");
        snprintf(one, sizeof one, "%.*s", (int)(length < 255 ? length : 255), name);
        code = add_panel(p, one);
        name = name[length] ? name + length + 1 : NULL;
    }
    if (!code && p->panels == 0) code = complain(NOT_READ, "%s has no outputs", p->options->run);
    return code;
}

/* ---- what gnuplot is told ---- */

/* "name, unit". */
static void put_label(FILE *to, const study_picture *p, const char *name, int k)
{
    char label[300];
    const char *unit = p->d.unit && p->d.unit[k] ? p->d.unit[k] : "";
    snprintf(label, sizeof label, "%.200s%s%.40s", name, *unit ? ", " : "", unit);
    plot_text(to, label);
}

/* The finite numbers of a column; how many. */
static long numbers_of(const study_picture *p, int k)
{
    long count = 0;
    for (int run = 0; run < p->d.t.lines; ++run) {
        const double x = table_at(&p->d.t, run, k);
        if (isfinite(x)) p->x[count++] = x;
    }
    return count;
}

static void draw_envelope(FILE *to, const study_picture *p, const study_panel *one)
{
    fprintf(to, "$data << END_OF_STUDY\n");
    for (int k = one->column; k < one->column + one->count; ++k) {
        const study_statistics s = statistics_of(numbers_of(p, k), p->x);
        if (s.count == 0) continue;
        fprintf(to, "%s %.10g %.10g %.10g %.10g %.10g\n", strstr(p->d.t.name[k], " at ") + 4,
                s.least, s.low, s.median, s.high, s.most);
    }
    fputs("END_OF_STUDY\nset xlabel 't, s'\nset ylabel ", to);
    put_label(to, p, one->name, one->column);
    fputs("\nset style fill solid noborder\n"
          "plot $data using 1:2:6 with filledcurves lc rgb '#cfe0f0' title 'all', "
          "$data using 1:3:5 with filledcurves lc rgb '#8fb8de' title '5 to 95 %', "
          "$data using 1:4 with lines lc rgb '#1f4e79' lw 2 title 'median'\n",
          to);
}

static void draw_histogram(FILE *to, const study_picture *p, const study_panel *one)
{
    const long n = numbers_of(p, one->column);
    const study_statistics s = statistics_of(n, p->x);
    long bar[MOST_BARS] = {0};
    int bars = (int)ceil(sqrt((double)n));
    bars = bars > MOST_BARS ? MOST_BARS : bars < 1 ? 1 : bars;
    const double width = n > 0 && s.most > s.least ? (s.most - s.least) / bars : 1.0;
    for (long k = 0; k < n; ++k) {
        const int at = (int)((p->x[k] - s.least) / width);
        ++bar[at < bars ? at : bars - 1];
    }
    fputs("$data << END_OF_STUDY\n", to);
    for (int k = 0; k < bars && n > 0; ++k)
        fprintf(to, "%.10g %ld %.10g\n", s.least + (k + 0.5) * width, bar[k], width);
    fputs("END_OF_STUDY\nset ylabel 'runs'\nset yrange [0:*]\nset xlabel ", to);
    put_label(to, p, one->name, one->column);
    fputs("\nset style fill solid 0.9 border rgb 'white'\n"
          "plot $data using 1:2:3 with boxes lc rgb '#5b92c5' notitle\nset yrange [*:*]\n",
          to);
}

static void draw_scatter(FILE *to, const study_picture *p, const study_panel *one)
{
    fputs("$data << END_OF_STUDY\n", to);
    for (int run = 0; run < p->d.t.lines; ++run) {
        const double x = table_at(&p->d.t, run, p->over), y = table_at(&p->d.t, run, one->column);
        if (isfinite(x) && isfinite(y)) fprintf(to, "%.10g %.10g\n", x, y);
    }
    fputs("END_OF_STUDY\nset xlabel ", to);
    put_label(to, p, p->d.t.name[p->over], p->over);
    fputs("\nset ylabel ", to);
    put_label(to, p, p->d.t.name[one->column], one->column);
    fputs("\nplot $data using 1:2 with points pt 7 ps 0.5 lc rgb '#1f4e79' notitle\n", to);
}

static int draw_study(const study_picture *p)
{
    FILE *to = plot_begin(p->options, p->panels);
    if (!to) return FAILED;
    fputs("set key inside right top samplen 1\nset tics nomirror\n", to);
    for (int k = 0; k < p->panels; ++k) {
        const study_panel *one = p->panel + k;
        if (p->over >= 0)
            draw_scatter(to, p, one);
        else if (one->count > 1)
            draw_envelope(to, p, one);
        else
            draw_histogram(to, p, one);
    }
    return plot_end(p->options, to);
}

int plot_study(const plot_options *o)
{
    study_picture p = {.options = o};
    int code = study_data_read(o->run, &p.d);
    if (!code && p.d.t.lines == 0) code = complain(NOT_READ, "%s has no runs", o->run);
    if (!code && !(p.x = calloc((size_t)p.d.t.lines, sizeof *p.x)))
        code = complain(FAILED, "no memory");
    if (!code) code = choose_panels(&p);
    if (!code) code = draw_study(&p);
    free(p.x);
    study_data_free(&p.d);
    return code;
}
