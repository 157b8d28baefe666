/* The data of a page: see page.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/page.h"

#include "program/bytes.h"

#include <stdlib.h>
#include <string.h>

/* ---- the run ---- */

/* False: no memory. */
static bool put_columns(FILE *to, const table *run)
{
    fputs(",\n\"columns\": [", to);
    float *values = run ? malloc((size_t)run->lines * sizeof *values) : NULL;
    bool good = values || !run;
    for (int k = 1; run && k < run->columns && good; ++k) {
        for (int l = 0; l < run->lines; ++l) values[l] = (float)table_at(run, l, k);
        fputs(k > 1 ? ",\n{\"name\": " : "\n{\"name\": ", to);
        put_json(to, run->name[k]);
        fputs(", \"values\": ", to);
        good = put_floats(to, (size_t)run->lines, values);
        fputc('}', to);
    }
    free(values);
    fputs("]", to);
    return good;
}

/* NULL as null. False: no memory. */
static bool put_series(FILE *to, const char *name, size_t count, const float *x)
{
    fprintf(to, ",\n\"%s\": ", name);
    if (x) return put_floats(to, count, x);
    fputs("null", to);
    return true;
}

static bool put_motion(FILE *to, const page *p)
{
    const motion *m = p->motion;
    const size_t samples = (size_t)m->samples, all = samples * (size_t)p->model->file->bodies,
                 nq = (size_t)mbsr_model_nq(p->model->model);
    fputs("\"times\": ", to);
    put_numbers(to, m->samples, m->time);
    fputs(",\n\"loops\": [", to);
    for (int k = 0; k < m->loops; ++k) {
        fputs(k > 0 ? ", {\"name\": " : "{\"name\": ", to);
        put_json(to, mbsr_closure_name(p->model->model, m->loop[k].closure));
        fprintf(to, ", \"body\": %d}", m->loop[k].body);
    }
    fprintf(to, "],\n\"contacts\": %d,\n\"without\": ", m->touches);
    put_json(to, m->without);
    return put_series(to, "coordinates", samples * nq, m->q) &&
           put_series(to, "poses", POSE_NUMBERS * all, m->pose) &&
           put_series(to, "reactions", REACTION_NUMBERS * all, m->reaction) &&
           put_series(to, "loopForces", LOOP_NUMBERS * samples * (size_t)m->loops, m->loop_force) &&
           put_series(to, "contactForces", TOUCH_NUMBERS * samples * (size_t)m->touches, m->touch);
}

static void put_findings(FILE *to, const mbsr_file *f)
{
    fputs(",\n\"findings\": [", to);
    for (int k = 0; k < f->findings; ++k) {
        fprintf(to, "%s{\"line\": %d, \"element\": ", k > 0 ? ",\n" : "\n", f->finding[k].line);
        put_json(to, f->finding[k].element);
        fputs(", \"text\": ", to);
        put_json(to, f->finding[k].text);
        fputc('}', to);
    }
    fputs("]", to);
}

int page_write(FILE *to, const page *p)
{
    const char *slash = strrchr(p->options->path, '/');
    const mbsr_file *f = p->model->file;
    fputs("{\"title\": ", to);
    put_json(to, f->name[0] ? f->name : slash ? slash + 1 : p->options->path);
    fputs(", \"file\": ", to);
    put_json(to, p->options->path);
    fprintf(to, ", \"version\": \"%s\",\n", mbsr_version());
    page_put_model(to, p);
    const bool good = put_motion(to, p) && put_columns(to, p->run);
    put_findings(to, f);
    fputs(",\n\"report\": ", to);
    if (report_write(to, p->model, p->q, p->u, true) > UNDETERMINED) fputs("null", to);
    fputs("}\n", to);
    return good ? DONE : complain(FAILED, "no memory");
}
