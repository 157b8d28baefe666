/* What is determined at a state, for a reader or as JSON.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <stdlib.h>
#include <string.h>

static const char *const kinds[] = {"undetermined", "elastic", "damped"};

static const char *kind_name(mbsr_direction_kind kind)
{
    return kind == MBSR_DIRECTION_DAMPED    ? kinds[2]
           : kind == MBSR_DIRECTION_ELASTIC ? kinds[1]
                                            : kinds[0];
}

static void print_direction(FILE *to, const program_model *m, const mbsr_direction *d, bool json)
{
    const char *before = "";
    fprintf(to, json ? "{\"kind\": \"%s\", \"rates\": [" : "%s:", kind_name(d->kind));
    for (int k = 0; k < d->terms; ++k) {
        const mbsr_direction_term *t = d->term + k;
        if (json) {
            fprintf(to, "%s{\"body\": ", before);
            put_json(to, m->file->body_name[t->body]);
            fprintf(to, ", \"coordinate\": %d, \"weight\": %.17g}", t->coordinate, t->weight);
            before = ", ";
        } else {
            say(to, " %+.3g %s[%d]", t->weight, m->file->body_name[t->body], t->coordinate);
        }
    }
    fputs(json ? "]}" : "\n", to);
}

/* All directions that are counted, and what is said of those undetermined. */
static void print_directions(FILE *to, const program_model *m, const mbsr_index_report *r,
                             bool json)
{
    for (int k = 0; k < r->directions; ++k) {
        if (json && k > 0) fputs(", ", to);
        print_direction(to, m, r->direction + k, json);
    }
    if (json) fputs("]", to);
    for (const char *line = json ? "" : r->text; *line;) {
        const int length = (int)strcspn(line, "\n");
        say(to, "%.*s\n", length, line);
        line += length + (line[length] != '\0');
    }
}

static void print_report(FILE *to, const program_model *m, const mbsr_index_report *r, bool json)
{
    if (json)
        fprintf(to,
                "{\"index\": %d, \"dynamic\": %d, \"damped\": %d, \"elastic\": %d, "
                "\"undetermined\": %d, \"directions\": [",
                r->index, r->dynamic, r->damped, r->elastic, r->undetermined);
    else
        fprintf(to, "%d directions with mass, %d damped, %d elastic, %d undetermined; index %d\n",
                r->dynamic, r->damped, r->elastic, r->undetermined, r->index);
    print_directions(to, m, r, json);
}

/* ---- models with closures: what their rows hold, and whether a start is determined ---- */

static void print_loops(FILE *to, const program_model *m, const mbsr_closure_report *r,
                        const int *redundant, bool json, bool determined)
{
    if (json)
        fprintf(to,
                "{\"rows\": %d, \"independent\": %d, \"mobility\": %d, \"massless\": %d, "
                "\"unheld\": %d, \"gap\": %.17g, \"determined\": %s, \"redundant\": [",
                r->rows, r->independent, r->mobility, r->massless, r->undetermined, r->gap,
                determined ? "true" : "false");
    else
        fprintf(to,
                "%d rows of closures, %d independent; mobility %d; %d directions without mass, of "
                "which no loop holds %d; largest gap as drawn %.3g\n",
                r->rows, r->independent, r->mobility, r->massless, r->undetermined, r->gap);
    const char *before = "";
    for (int k = 0; k < r->rows; ++k) {
        int closure, own;
        const char *name;
        if (!redundant[k] || mbsr_closure_of_row(m->model, k, &closure, &own, &name)) continue;
        if (json) {
            fprintf(to, "%s{\"closure\": ", before);
            put_json(to, mbsr_closure_name(m->model, closure));
            fprintf(to, ", \"number\": %d, \"row\": %d}", closure, own);
            before = ", ";
        } else {
            say(to, "redundant: closure %d '%s', row %d %s\n", closure,
                mbsr_closure_name(m->model, closure), own, name);
        }
    }
    if (json) fputs("]", to);
}

/* The directions without mass that no loop holds, in closed positions, near which a start is;
 * without, as drawn. */
static void print_open_directions(FILE *to, const program_model *m, const double *q,
                                  const double *u, bool json)
{
    mbsr_index_report *report;
    const int nq = mbsr_model_nq(m->model);
    double *closed = calloc((size_t)nq + 1, sizeof *closed);
    const bool assembled = closed && !mbsr_assemble(m->model, m->data, 0.0, q, NULL, closed, NULL);
    const int status =
        mbsr_index_report_create(m->model, m->data, 0.0, assembled ? closed : q, u, &report);
    if (json) fputs(", \"directions\": [", to);
    if (!status) print_directions(to, m, report, json);
    if (status && json) fputc(']', to);
    if (!status) mbsr_index_report_destroy(m->model, report);
    free(closed);
}

/* UNDETERMINED where no consistent start is, DONE where one is; a code. */
static int try_start(const program_model *m, const double *q, const double *u)
{
    const int size = mbsr_dae_size(m->model, MBSR_DAE_MOMENTUM);
    double *y = calloc(2 * (size_t)size + 1, sizeof *y);
    if (!y) return complain(FAILED, "no memory");
    int status = mbsr_dae_pack(m->model, m->data, MBSR_DAE_MOMENTUM, 0.0, q, u, y);
    if (!status)
        status =
            mbsr_dae_consistent(m->model, m->data, MBSR_DAE_MOMENTUM, 0.0, y, y + size, NULL, NULL);
    free(y);
    if (!status) return DONE;
    return complain(status == MBSR_UNDETERMINED ? UNDETERMINED : FAILED, "%s",
                    mbsr_data_error(m->data)->text);
}

static int check_loops(FILE *to, const program_model *m, const double *q, const double *u,
                       bool json)
{
    mbsr_closure_report report;
    int *redundant = calloc((size_t)mbsr_model_rows(m->model) + 1, sizeof *redundant);
    if (!redundant) return complain(FAILED, "no memory");
    int code = DONE;
    if (mbsr_closures_report(m->model, m->data, 0.0, q, &report, redundant, NULL))
        code = complain(FAILED, "%s", mbsr_data_error(m->data)->text);
    if (!code) {
        code = try_start(m, q, u);
        if (code <= UNDETERMINED || !json)
            print_loops(to, m, &report, redundant, json, code == DONE);
        if ((code <= UNDETERMINED || !json) && report.undetermined > 0)
            print_open_directions(to, m, q, u, json);
    }
    free(redundant);
    return code;
}

static int check_tree(FILE *to, const program_model *m, const double *q, const double *u, bool json)
{
    mbsr_index_report *report;
    if (mbsr_index_report_create(m->model, m->data, 0.0, q, u, &report))
        return complain(FAILED, "%s", mbsr_data_error(m->data)->text);
    print_report(to, m, report, json);
    const int code = report->undetermined > 0 ? UNDETERMINED : DONE;
    mbsr_index_report_destroy(m->model, report);
    return code;
}

int report_begin(FILE *to, const program_model *m, const double *q, const double *u, bool json)
{
    return (mbsr_model_rows(m->model) > 0 ? check_loops : check_tree)(to, m, q, u, json);
}

int report_write(FILE *to, const program_model *m, const double *q, const double *u, bool json)
{
    const int code = report_begin(to, m, q, u, json);
    if (json && code <= UNDETERMINED) fputc('}', to);
    return code;
}
