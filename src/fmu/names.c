/* Names of variables: see names.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Grammar of the standard: names are separated by points; a name is an identifier, or any
 * characters of ASCII between quotes, in which ' and \ are written \' and \\; an array index
 * follows in brackets. */
#include "fmu/names.h"

#include "base/error.h"

#include <string.h>

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_decimal_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_identifier(const char *label)
{
    if (!is_letter(*label)) return false;
    while (is_letter(*label) || is_decimal_digit(*label)) ++label;
    return !*label;
}

/* Writes the label quoted; returns behind it. What is no printable character of ASCII becomes ?. */
static char *quote(const char *label, char *to)
{
    *to++ = '\'';
    for (; *label; ++label) {
        if (*label == '\'' || *label == '\\') *to++ = '\\';
        *to++ = *label >= ' ' && *label <= '~' && *label != '"' ? *label : '?';
    }
    *to++ = '\'';
    *to = '\0';
    return to;
}

char *mbsri_name(mbsri_arena *arena, const char *group, const char *label, const char *part,
                 int index)
{
    if (!label) return NULL;
    const size_t size = strlen(group) + 2 * strlen(label) + strlen(part) + 40;
    char *name = mbsri_arena_take(arena, size), *at = name;
    if (!name) return NULL;
    at += mbsri_print(at, size, "%s.", group);
    if (is_identifier(label))
        at += mbsri_print(at, size - (size_t)(at - name), "%s", label);
    else
        at = quote(label, at);
    if (*part) at += mbsri_print(at, size - (size_t)(at - name), ".%s", part);
    if (index > 0) mbsri_print(at, size - (size_t)(at - name), "[%d]", index);
    return name;
}

const char *mbsri_fmu_label(mbsri_arena *arena, const char *part, const char *name, int id)
{
    char text[40];
    if (name && *name) return name;
    mbsri_print(text, sizeof text, "%s%d", part, id);
    return mbsri_arena_text(arena, text, strlen(text));
}

char *mbsri_printable(mbsri_arena *arena, const char *label)
{
    char *made = mbsri_arena_text(arena, label, strlen(label));
    for (char *c = made; c && *c; ++c)
        if (*c < ' ' || *c > '~') *c = '?';
    return made;
}

char *mbsri_identifier(mbsri_arena *arena, const char *label)
{
    const size_t length = strlen(label);
    char *made = mbsri_arena_take(arena, length + 3);
    if (!made) return NULL;
    char *to = made;
    if (!is_letter(*label)) *to++ = 'm';
    for (size_t k = 0; k < length; ++k)
        *to++ = is_letter(label[k]) || is_decimal_digit(label[k]) ? label[k] : '_';
    *to = '\0';
    return made;
}
