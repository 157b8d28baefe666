/* Refusals and findings: see scene.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/scene.h"

#include "files/numbers.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* "joint 'elbow'" */
static void describe(const mbsri_element *e, char *text, size_t size)
{
    const char *name = mbsri_attribute(e, "name");
    if (!name && (mbsri_is(e, "link") || mbsri_is(e, "mimic"))) name = mbsri_attribute(e, "joint");
    if (name)
        snprintf(text, size, "%.30s '%.50s'", e->name, name);
    else
        snprintf(text, size, "%.30s", e->name);
}

bool mbsri_file_refuse(mbsri_scene *s, const mbsri_element *e, const char *format, ...)
{
    char element[96], reason[MBSR_TEXT_SIZE];
    if (s->message[0]) return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(reason, sizeof reason, format, arguments);
    va_end(arguments);
    describe(e, element, sizeof element);
    const size_t length = strlen(e->file), cut = length > 60 ? length - 60 : 0;
    snprintf(s->message, sizeof s->message, "%s:%d: %s: %.90s", e->file + cut, e->line, element,
             reason);
    return false;
}

void mbsri_file_find(mbsri_scene *s, const mbsri_element *e, const char *format, ...)
{
    char element[96], text[MBSR_TEXT_SIZE];
    mbsr_finding *f = mbsri_list_add(s->arena, &s->findings, sizeof *f);
    if (!f) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    describe(e, element, sizeof element);
    f->file = e->file;
    f->line = e->line;
    f->element = mbsri_arena_text(s->arena, element, strlen(element));
    f->text = mbsri_arena_text(s->arena, text, strlen(text));
}

bool mbsri_numbers(mbsri_scene *s, const mbsri_element *e, const char *attribute, const char *value,
                   int least, int most, double *to, int *count)
{
    double read[16];
    if (count) *count = 0;
    if (!value) return true;
    const int n = mbsri_read_numbers(value, least, most, read);
    if (n < 0) {
        return mbsri_file_refuse(s, e, "%s=\"%.40s\" is not %d number%s", attribute, value, most,
                                 most > 1 ? "s" : "");
    }
    memcpy(to, read, (size_t)n * sizeof *to);
    if (count) *count = n;
    return true;
}

const char *mbsri_file_why(int reason)
{
    return reason > 1 ? strerror(reason) : "";
}
