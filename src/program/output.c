/* Where a run goes: see output.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/output.h"

#include "program/hdf5.h"

#include <stdlib.h>

int output_open(const char *path, const columns *c, double lines, output *o)
{
    *o = (output){.path = path, .columns = c};
    o->row = malloc(((size_t)c->count + 1) * sizeof *o->row);
    if (!o->row) return complain(FAILED, "no memory");
    if (path && names_hdf5(path)) return hdf5_create(path, c, lines, &o->run);
    o->text = path ? fopen(path, "w") : stdout;
    if (!o->text) return complain_of_file(FAILED, path, "written");
    columns_head(c, o->text);
    return DONE;
}

static void write_line(FILE *to, int n, const double *row)
{
    for (int k = 0; k < n; ++k) fprintf(to, k > 0 ? ",%.17g" : "%.17g", row[k]);
    fputc('\n', to);
}

int output_state(output *o, const mbsr_model *model, mbsr_data *data, double t, const double *q,
                 const double *u)
{
    o->row[0] = t;
    int code = DONE;
    if (columns_values(o->columns, model, data, t, q, u, o->row + 1))
        return complain(FAILED, "%s", mbsr_data_error(data)->text);
    if (o->run) code = hdf5_line(o->run, o->row);
    if (o->text) write_line(o->text, o->columns->count + 1, o->row);
    ++o->lines;
    return code;
}

void output_text(output *o, const char *name, const char *text)
{
    if (o->run) hdf5_text(o->run, name, text);
}

void output_number(output *o, const char *name, double number)
{
    if (o->run) hdf5_number(o->run, name, number);
}

int output_close(output *o)
{
    int code = DONE;
    if (o->run) code = hdf5_close(o->run);
    if (o->text) {
        const bool bad = fflush(o->text) != 0 || ferror(o->text);
        if (o->text != stdout) fclose(o->text);
        if (bad) code = complain(FAILED, "%s cannot be written", o->path ? o->path : "the output");
    }
    free(o->row);
    *o = (output){.path = NULL};
    return code;
}
