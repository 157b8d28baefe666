/* Results of a study as columns of numbers: see study_data.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/study_data.h"

#include "program/hdf5.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool study_data_is(const char *path)
{
    char head[4] = "";
    if (names_hdf5(path)) return hdf5_is_study(path);
    FILE *file = fopen(path, "rb");
    const bool good = file && fread(head, 1, 4, file) == 4 && memcmp(head, "run,", 4) == 0;
    if (file) fclose(file);
    return good;
}

/* The columns before "outcome". */
static int read_names(const char *path, char *line, table *t)
{
    const int code = table_names(&line, "outcome", t);
    if (code) return code;
    return line ? DONE : complain(NOT_READ, "%s:1: there is no column outcome", path);
}

static int read_csv(const char *path, table *t)
{
    size_t size;
    int lines = 0, code = DONE;
    t->text = read_file(path, &size);
    if (!t->text) return complain_of_file(NOT_READ, path, "read");
    for (const char *s = t->text; *s; ++s) lines += *s == '\n';
    char *at = t->text, *line = table_line(&at);
    if (line) code = read_names(path, line, t);
    if (!code) t->value = malloc(((size_t)lines * (size_t)t->columns + 1) * sizeof *t->value);
    if (!code && !t->value) return complain(FAILED, "no memory");
    while (!code && t->lines < lines && (line = table_line(&at))) {
        for (int k = 0; k < t->columns && !code; ++k) {
            const char *cell = table_cell(&line);
            char *end = NULL;
            const double x = cell && *cell ? strtod(cell, &end) : NAN;
            if (end && *end)
                code =
                    complain(NOT_READ, "%s:%d: column %d is no number", path, t->lines + 2, k + 1);
            t->value[(long)t->lines * t->columns + k] = x;
        }
        ++t->lines;
    }
    return code;
}

int study_data_read(const char *path, study_data *d)
{
    *d = (study_data){.unit = NULL};
    return names_hdf5(path) ? hdf5_read_study(path, d) : read_csv(path, &d->t);
}

void study_data_free(study_data *d)
{
    table_free(&d->t);
    free(d->unit);
}

/* The last " at " of a name. */
static size_t series_name(const char *name)
{
    size_t length = 0;
    for (const char *s = name; (s = strstr(s, " at ")); ++s) length = (size_t)(s - name);
    return length;
}

int study_data_series(const study_data *d, int k, size_t *length)
{
    const char *name = d->t.name[k];
    int count = 1;
    *length = series_name(name);
    while (*length > 0 && k + count < d->t.columns) {
        const char *other = d->t.name[k + count];
        if (series_name(other) != *length || strncmp(name, other, *length) != 0) break;
        ++count;
    }
    return count;
}
