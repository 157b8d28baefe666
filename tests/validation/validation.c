/* Computes the rows of docs/validation.md and fails where one differs by more than is allowed.
 * SPDX-License-Identifier: BSD-3-Clause
 * Usage: validation [--table]   as tables in Markdown; else a line for each row */
#include "sheet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void sheet_check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error ? error->text : "");
    exit(2);
}

void sheet_start(mbsr_simulation *s, double tolerance, const double *q, const double *u)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    sheet_check(mbsr_simulation_start(s, &opt, 0.0, q, u), &s->error);
}

void sheet_run(mbsr_simulation *s, double t)
{
    sheet_check(mbsr_simulation_to(s, t), &s->error);
}

void sheet_problem(sheet *s, const char *problem, const char *source)
{
    s->problem = problem;
    s->source = source;
}

void sheet_add(sheet *s, const char *quantity, double theirs, double ours, double allowed)
{
    if (s->rows == SHEET_ROWS) exit(2);
    s->row[s->rows++] = (sheet_row){s->problem, s->source, quantity, theirs, ours, allowed};
    s->problem = s->source = NULL;
}

/* As many decimals as the difference allowed has. */
static int decimals(const sheet_row *r)
{
    const int places = (int)ceil(-log10(r->allowed) - 1e-9);
    return places > 0 ? places : 0;
}

static void print_table(const sheet *s)
{
    for (int k = 0; k < s->rows; ++k) {
        const sheet_row *r = s->row + k;
        if (r->problem) {
            printf("%s**%s.** %s\n\n", k > 0 ? "\n" : "", r->problem, r->source);
            printf("| | published | here | allowed |\n|---|---:|---:|---:|\n");
        }
        printf("| %s | %.*f | %.*f | %.0e |\n", r->quantity, decimals(r), r->theirs, decimals(r),
               r->ours, r->allowed);
    }
}

static int print_lines(const sheet *s)
{
    int wrong = 0;
    for (int k = 0; k < s->rows; ++k) {
        const sheet_row *r = s->row + k;
        const double off = fabs(r->ours - r->theirs);
        const int fits = off <= r->allowed; /* NaN does not */
        if (r->problem) printf("%s\n", r->problem);
        printf("    %-44s %18.12g %18.12g   %.1e of %.0e%s\n", r->quantity, r->theirs, r->ours, off,
               r->allowed, fits ? "" : "   DIFFERS");
        wrong += !fits;
    }
    printf("%d rows, %d differ\n", s->rows, wrong);
    return wrong;
}

int main(int count, char **argument)
{
    static sheet s;
    sheet_ivp(&s);
    sheet_linkages(&s);
    sheet_bodies(&s);
    sheet_adams(&s);
    sheet_modelica(&s);
    sheet_modelica_more(&s);
    sheet_exudyn(&s);
    sheet_flight(&s);
    sheet_bicycle(&s);
    sheet_iltis(&s);
    if (count == 2 && strcmp(argument[1], "--table") == 0) {
        print_table(&s);
        return 0;
    }
    return print_lines(&s) ? 1 : 0;
}
