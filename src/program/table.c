/* Numbers by name over time: see table.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

char *table_cell(char **line)
{
    char *from = *line, *to, *cell;
    if (!from) return NULL;
    while (*from == ' ') ++from;
    cell = to = from;
    if (*from == '"') {
        for (++from; *from && (*from != '"' || from[1] == '"'); ++from)
            *to++ = *from == '"' ? *from++ : *from;
        from += strcspn(from, ",");
    } else {
        from += strcspn(from, ",");
        to = from;
    }
    *line = *from ? from + 1 : NULL;
    while (to > cell && (to[-1] == ' ' || to[-1] == '\r')) --to;
    *to = '\0';
    return cell;
}

char *table_line(char **text)
{
    char *line = *text;
    if (!line || !*line) return NULL;
    char *end = line + strcspn(line, "\n");
    *text = *end ? end + 1 : end;
    *end = '\0';
    return line;
}

int table_names(char **line, const char *stop, table *t)
{
    int room = 1;
    for (const char *s = *line; *s; ++s) room += *s == ',';
    t->name = malloc((size_t)room * sizeof *t->name);
    if (!t->name) return complain(FAILED, "no memory");
    for (char *cell; (cell = table_cell(line)) && !(stop && strcmp(cell, stop) == 0);)
        t->name[t->columns++] = cell;
    return DONE;
}

static int read_head(const char *path, char *line, table *t)
{
    const int code = table_names(&line, NULL, t);
    if (code) return code;
    if (t->columns == 0 || strcmp(t->name[0], "t") != 0)
        return complain(NOT_READ, "%s:1: the first column must be t", path);
    return DONE;
}

static int read_line(const char *path, int number, char *line, double *row, const table *t)
{
    for (int k = 0; k < t->columns; ++k) {
        const char *cell = table_cell(&line);
        char *end = NULL;
        row[k] = cell ? strtod(cell, &end) : NAN;
        if (!cell || !*cell || *end || !isfinite(row[k]))
            return complain(NOT_READ, "%s:%d: column %d is no number", path, number, k + 1);
    }
    if (line) return complain(NOT_READ, "%s:%d: there are too many columns", path, number);
    if (t->lines > 0 && !(row[0] > row[-t->columns]))
        return complain(NOT_READ, "%s:%d: times must ascend", path, number);
    return DONE;
}

int table_read_csv(const char *path, table *t)
{
    size_t size, room = 0;
    *t = (table){.text = read_file(path, &size)};
    char *at = t->text, *line = at ? table_line(&at) : NULL;
    if (!t->text) return complain_of_file(NOT_READ, path, "read");
    int code = line ? read_head(path, line, t) : complain(NOT_READ, "%s is empty", path);
    for (int number = 2; !code && (line = table_line(&at)); ++number) {
        if (!line[strspn(line, " \r")]) continue;
        const size_t width = (size_t)t->columns, place = (size_t)t->lines * width;
        if (place + width > room) {
            room = 2 * (place + width);
            double *larger = realloc(t->value, room * sizeof *larger);
            if (!larger) return complain(FAILED, "no memory");
            t->value = larger;
        }
        code = read_line(path, number, line, t->value + place, t);
        if (!code) ++t->lines;
    }
    return code;
}

void table_free(table *t)
{
    free(t->text);
    free(t->name);
    free(t->value);
}

int table_find(const table *t, const char *name, int from)
{
    for (int k = 0; k < t->columns; ++k) {
        const int at = (from + k) % t->columns;
        if (strcmp(t->name[at], name) == 0) return at;
    }
    return -1;
}
