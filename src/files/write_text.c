/* A text of XML that grows: see write_text.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/write_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void mbsri_put(mbsri_text *t, const char *s, size_t length)
{
    if (t->room - t->size <= length) {
        const size_t room = 2 * (t->size + length) + 4096;
        char *larger = mbsri_arena_take(t->arena, room);
        if (!larger) return;
        if (t->size > 0) memcpy(larger, t->data, t->size);
        t->data = larger;
        t->room = room;
    }
    memcpy(t->data + t->size, s, length);
    t->size += length;
    t->data[t->size] = '\0';
}

static void puts_in(mbsri_text *t, const char *s)
{
    mbsri_put(t, s, strlen(s));
}

static void indent(mbsri_text *t)
{
    static const char spaces[] = "                                        ";
    const int most = (int)sizeof spaces - 1, depth = 2 * t->depth;
    mbsri_put(t, spaces, (size_t)(depth < most ? depth : most));
}

void mbsri_begin(mbsri_text *t, const char *element)
{
    indent(t);
    puts_in(t, "<");
    puts_in(t, element);
}

void mbsri_end(mbsri_text *t)
{
    puts_in(t, "/>\n");
}

void mbsri_into(mbsri_text *t)
{
    puts_in(t, ">\n");
    ++t->depth;
}

void mbsri_out(mbsri_text *t, const char *element)
{
    --t->depth;
    indent(t);
    puts_in(t, "</");
    puts_in(t, element);
    puts_in(t, ">\n");
}

static void open_attribute(mbsri_text *t, const char *name)
{
    puts_in(t, " ");
    puts_in(t, name);
    puts_in(t, "=\"");
}

void mbsri_set_attribute(mbsri_text *t, const char *name, const char *value)
{
    open_attribute(t, name);
    for (; *value; ++value) {
        switch (*value) {
        case '<': puts_in(t, "&lt;"); break;
        case '&': puts_in(t, "&amp;"); break;
        case '"': puts_in(t, "&quot;"); break;
        case '\n': puts_in(t, "&#10;"); break;
        case '\r': puts_in(t, "&#13;"); break;
        case '\t': puts_in(t, "&#9;"); break;
        default: mbsri_put(t, value, 1);
        }
    }
    puts_in(t, "\"");
}

void mbsri_set_text(mbsri_text *t, const char *name, const char *value)
{
    if (value && *value) mbsri_set_attribute(t, name, value);
}

void mbsri_set_numbers(mbsri_text *t, const char *name, int n, const double *values)
{
    open_attribute(t, name);
    for (int k = 0; k < n; ++k) {
        char number[40];
        snprintf(number, sizeof number, "%.15g", values[k]);
        const double back = strtod(number, NULL);
        if (back < values[k] || back > values[k])
            snprintf(number, sizeof number, "%.17g", values[k]);
        for (char *c = number; *c; ++c) /* the point of the locale */
            if (!strchr("+-0123456789e", *c)) *c = '.';
        if (k > 0) puts_in(t, " ");
        puts_in(t, number);
    }
    puts_in(t, "\"");
}

void mbsri_set_number(mbsri_text *t, const char *name, double value)
{
    mbsri_set_numbers(t, name, 1, &value);
}
