/* Small masses of a model, for a reader or as JSON.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/small.h"

#if defined(MBSR_WITH_IDA)
#include "program/progress.h"

#include <mbsrank/ida.h>
#endif

#if defined(MBSR_WITH_IDA)
static int show(void *user, const mbsr_ida_progress *now)
{
    progress_show(user, now->t);
    return 0;
}

static int run_reduced(const small_options *o, mbsr_small_masses *small, mbsr_error *error)
{
    progress shown = progress_begin("small masses", o->time, false);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.progress = show;
    opt.progress_user = &shown;
    const int status = mbsr_small_masses_run(small, &opt, o->time, NULL, error);
    progress_end(&shown);
    return status;
}
#endif

/* Along a run where there is an integrator, else at the start. */
static int look_along(const small_options *o, mbsr_small_masses *small, const double *q,
                      const double *u)
{
    mbsr_error error = {0};
    int status = mbsr_small_masses_start(small, 0.0, q, u);
    if (status) error = *mbsr_small_masses_error(small);
#if defined(MBSR_WITH_IDA)
    if (!status) status = run_reduced(o, small, &error);
#else
    (void)o;
#endif
    return status ? complain(FAILED, "--small: %s", error.text) : DONE;
}

int small_make(const program_model *m, const small_options *o, const double *q, const double *u,
               mbsr_small_masses **small)
{
    mbsr_error error = {.text = ""};
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    opt.duration = o->time;
    opt.tolerance = o->tolerance;
    if (mbsr_small_masses_create(m->model, &opt, small, &error))
        return complain(FAILED, "--small: %s", error.text);
    const int code = look_along(o, *small, q, u);
    if (!code) return code;
    mbsr_small_masses_destroy(*small);
    *small = NULL;
    return code;
}

/* ---- JSON ---- */

static void put_direction(FILE *to, const program_model *m, const mbsr_small_direction *x)
{
    fputs("{\"body\": ", to);
    put_json(to, m->file->body_name[x->body]);
    fprintf(to,
            ", \"coordinate\": %d, \"inertia\": %.17g, \"stiffness\": %.17g, \"damping\": %.17g, "
            "\"frequency\": %.17g, \"damping_ratio\": %.17g, \"fastness\": %.17g, "
            "\"amplitude\": %.17g}",
            x->coordinate, x->inertia, x->stiffness, x->damping, x->frequency, x->damping_ratio,
            x->fastness, x->amplitude);
}

static void put_mass(FILE *to, const program_model *m, const mbsr_small_masses_report *r,
                     const mbsr_small_mass *x)
{
    static const char *const parts[] = {"", "mass", "moment", "both"};
    fputs("{\"body\": ", to);
    put_json(to, m->file->body_name[x->body]);
    fprintf(to,
            ", \"parts\": \"%s\", \"ratio\": %.17g, \"error\": %.17g, \"output\": %d, "
            "\"time\": %.17g, \"share\": %.17g, \"swing\": %.17g, \"steps\": %.17g, "
            "\"verdict\": \"%s\", \"direction\": ",
            parts[x->parts & 3], x->ratio, x->error, x->output, x->time, x->share, x->amplitude,
            x->steps, mbsr_small_verdict_text(x->verdict));
    if (x->direction == MBSR_NONE)
        fputs("null", to);
    else
        put_direction(to, m, r->direction + x->direction);
    fputc('}', to);
}

static void put_report(FILE *to, const program_model *m, const mbsr_small_masses_report *r)
{
    fprintf(to,
            "{\"from\": %.17g, \"to\": %.17g, \"error\": %.17g, \"output\": %d, \"time\": %.17g, "
            "\"share\": %.17g, \"swing\": %.17g, \"steps\": %.17g, \"masses\": [",
            r->from, r->to, r->error, r->output, r->time, r->share, r->amplitude, r->steps);
    for (int k = 0; k < r->masses; ++k) {
        if (k > 0) fputs(", ", to);
        put_mass(to, m, r, r->mass + k);
    }
    fputs("]}", to);
}

void small_write(FILE *to, const program_model *m, mbsr_small_masses *small, bool json)
{
    mbsr_small_masses_report report;
    if (!small || mbsr_small_masses_get_report(small, &report)) {
        fputs(json ? "null" : "", to);
    } else if (json) {
        put_report(to, m, &report);
    } else if (report.masses == 0) {
        fputs("no mass is below a tenth of its neighbours'\n", to);
    } else {
        fputs(report.text, to);
    }
}
