/* Elements of XML that are made: see xml_make.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xml_make.h"

#include <stdio.h>
#include <string.h>

mbsri_element *mbsri_element_like(mbsri_arena *arena, const mbsri_element *e, const char *name)
{
    mbsri_element *to = mbsri_arena_take(arena, sizeof *to);
    const char **none = mbsri_arena_take(arena, sizeof *none);
    if (!to || !none) return NULL;
    *to = (mbsri_element){
        .name = name, .file = e->file, .line = e->line, .model = e->model, .attribute = none};
    return to;
}

bool mbsri_element_set(mbsri_arena *arena, mbsri_element *e, const char *name, const char *value)
{
    size_t count = 0;
    for (; e->attribute[count]; count += 2) {
        if (strcmp(e->attribute[count], name) != 0) continue;
        e->attribute[count + 1] = value;
        return value != NULL;
    }
    const char **list = mbsri_arena_take(arena, (count + 3) * sizeof *list);
    if (!list || !value) return false;
    if (count > 0) memcpy(list, e->attribute, count * sizeof *list);
    list[count] = name;
    list[count + 1] = value;
    e->attribute = list;
    return true;
}

bool mbsri_element_set_numbers(mbsri_arena *arena, mbsri_element *e, const char *name, int count,
                               const double *x)
{
    enum { DIGITS = 32 };
    char *text = mbsri_arena_take(arena, (size_t)count * DIGITS + 1);
    if (!text) return false;
    for (int k = 0, at = 0; k < count; ++k)
        at += snprintf(text + at, DIGITS, k ? " %.17g" : "%.17g", x[k]);
    for (char *c = text; *c; ++c) /* the point of the locale */
        if (!strchr("+-0123456789e ", *c)) *c = '.';
    return mbsri_element_set(arena, e, name, text);
}

void mbsri_append(mbsri_element *parent, mbsri_element *e)
{
    e->parent = parent;
    e->next = NULL;
    if (parent->last)
        parent->last->next = e;
    else
        parent->child = e;
    parent->last = e;
}

mbsri_element *mbsri_put_in_place(mbsri_element *parent, mbsri_element *before, mbsri_element *old,
                                  mbsri_element *list)
{
    for (mbsri_element *e = list->child; e; e = e->next) e->parent = parent;
    list->last->next = old->next;
    if (before)
        before->next = list->child;
    else
        parent->child = list->child;
    if (parent->last == old) parent->last = list->last;
    return list->last;
}
