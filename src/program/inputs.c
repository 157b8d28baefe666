/* Inputs from CSV: see inputs.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cuts the next cell off *line; NULL: none is left. */
static char *next_cell(char **line)
{
    char *cell = *line;
    if (!cell) return NULL;
    char *end = cell + strcspn(cell, ",");
    *line = *end ? end + 1 : NULL;
    *end = '\0';
    while (*cell == ' ' || *cell == '"') ++cell;
    for (end = cell + strlen(cell); end > cell && strchr(" \r\"", end[-1]);) *--end = '\0';
    return cell;
}

static char *next_line(char **text)
{
    char *line = *text;
    if (!line || !*line) return NULL;
    char *end = line + strcspn(line, "\n");
    *text = *end ? end + 1 : end;
    *end = '\0';
    return line;
}

static int read_head(const program_model *m, const char *path, char *line, inputs *in)
{
    const char *cell = next_cell(&line);
    if (!cell || strcmp(cell, "t") != 0)
        return complain(NOT_READ, "%s:1: the first column must be t", path);
    while ((cell = next_cell(&line))) {
        int *more = realloc(in->actuator, ((size_t)in->columns + 1) * sizeof *more);
        if (!more) return complain(FAILED, "no memory");
        in->actuator = more;
        more[in->columns] = mbsr_file_find_actuator(m->file, cell);
        if (more[in->columns++] < 0)
            return complain(NOT_READ, "%s:1: there is no actuator '%s'", path, cell);
    }
    return DONE;
}

static int read_line(const char *path, int number, char *line, inputs *in)
{
    const int width = in->columns + 1;
    double *more = realloc(in->value, (size_t)(in->lines + 1) * (size_t)width * sizeof *more);
    if (!more) return complain(FAILED, "no memory");
    in->value = more;
    double *row = more + (size_t)in->lines * (size_t)width;
    for (int k = 0; k < width; ++k) {
        const char *cell = next_cell(&line);
        char *end = NULL;
        row[k] = cell ? strtod(cell, &end) : NAN;
        if (!cell || !*cell || *end || !isfinite(row[k]))
            return complain(NOT_READ, "%s:%d: column %d is no number", path, number, k + 1);
    }
    if (line) return complain(NOT_READ, "%s:%d: there are too many columns", path, number);
    if (in->lines > 0 && !(row[0] > row[-width]))
        return complain(NOT_READ, "%s:%d: times must ascend", path, number);
    ++in->lines;
    return DONE;
}

int inputs_read(const program_model *m, const char *path, inputs *in)
{
    size_t size;
    char *text = read_file(path, &size), *at = text, *line = text ? next_line(&at) : NULL;
    *in = (inputs){.columns = 0};
    if (!text) return complain(NOT_READ, "%s cannot be read", path);
    int code = line ? read_head(m, path, line, in) : complain(NOT_READ, "%s is empty", path);
    for (int number = 2; !code && (line = next_line(&at)); ++number) {
        if (line[strspn(line, " \r")]) code = read_line(path, number, line, in);
    }
    free(text);
    return code;
}

void inputs_free(inputs *in)
{
    free(in->actuator);
    free(in->value);
}

void inputs_set(const inputs *in, int line, double *control)
{
    const double *row = in->value + (size_t)line * (size_t)(in->columns + 1);
    for (int k = 0; k < in->columns; ++k) control[in->actuator[k]] = row[k + 1];
}
