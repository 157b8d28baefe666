/* Methods of strings and dictionaries: see xacro_methods.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_methods.h"

#include "files/xacro_arithmetic.h"

#include <string.h>

/* ---- dictionaries ---- */

static bool call_get(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    mbsri_value *found;
    if (!mbsri_value_find(x, c->self, c->argument, &found)) return false;
    *out = found ? *found : c->count > 1 ? c->argument[1] : (mbsri_value){.kind = MBSRI_NOTHING};
    return true;
}

/* keys, values, items as lists. */
static bool call_items(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char what = c->function->name[0];
    mbsri_list *list = mbsri_value_begin(x, MBSRI_LIST, out);
    for (int k = 0; list && k < c->self->of.list->count; k += 2) {
        const mbsri_value *pair = mbsri_items(c->self) + k;
        mbsri_value both = pair[what == 'v'];
        if (what == 'i') {
            mbsri_list *two = mbsri_value_begin(x, MBSRI_TUPLE, &both);
            if (!two || !mbsri_value_add(x, two, pair) || !mbsri_value_add(x, two, pair + 1))
                return false;
        }
        if (!mbsri_value_add(x, list, &both)) return false;
    }
    return list != NULL;
}

/* ---- strings ---- */

static const char space[] = " \t\n\r\f\v";

static bool call_case(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char from = c->function->name[0] == 'l' ? 'A' : 'a', to = (char)('A' + 'a' - from);
    char *text = mbsri_xacro_copy(x, c->self->of.string, strlen(c->self->of.string));
    for (char *s = text; s && *s; ++s) {
        if (*s >= from && *s < from + 26) *s = (char)(*s - from + to);
    }
    *out = mbsri_value_string(text);
    return text != NULL;
}

static bool call_ends(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *part, *whole = c->self->of.string;
    if (!mbsri_call_string(x, c, 0, &part)) return false;
    const size_t length = strlen(part), all = strlen(whole);
    if (c->function->name[0] == 'e' && length <= all) whole += all - length;
    *out = mbsri_value_truth(length <= all && strncmp(whole, part, length) == 0);
    return true;
}

static bool call_strip(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *from = c->self->of.string + strspn(c->self->of.string, space);
    size_t length = strlen(from);
    while (length > 0 && strchr(space, from[length - 1])) --length;
    *out = mbsri_value_string(mbsri_xacro_copy(x, from, length));
    return out->of.string != NULL;
}

/* At a separator, or without one at white space. */
static bool call_split(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *mark = NULL, *at = c->self->of.string;
    mbsri_list *list = mbsri_value_begin(x, MBSRI_LIST, out);
    if (c->count > 0 && !mbsri_call_string(x, c, 0, &mark)) return false;
    if (mark && !*mark) return mbsri_xacro_refuse(x, "split() at nothing");
    if (!mark) at += strspn(at, space);
    for (const char *end = at; list && (mark || *at); at = end) {
        end = mark ? strstr(at, mark) : at + strcspn(at, space);
        const char *piece = mbsri_xacro_copy(x, at, end ? (size_t)(end - at) : strlen(at));
        const mbsri_value item = mbsri_value_string(piece);
        if (!piece || !mbsri_value_add(x, list, &item)) return false;
        if (!end) break;
        end += mark ? strlen(mark) : strspn(end, space);
    }
    return list != NULL;
}

static bool call_join(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    mbsri_value all;
    if (!mbsri_call_items(x, c, &all)) return false;
    *out = mbsri_value_string("");
    for (int k = 0; k < all.of.list->count; ++k) {
        const mbsri_value *item = mbsri_items(&all) + k;
        mbsri_value before = *out;
        if (item->kind != MBSRI_STRING)
            return mbsri_xacro_refuse(x, "join() is given %s", mbsri_kind_name(item));
        if (k > 0 && !mbsri_arithmetic(x, "+", out, c->self, &before)) return false;
        if (!mbsri_arithmetic(x, "+", &before, item, out)) return false;
    }
    return true;
}

static bool call_replace(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    mbsri_value pieces;
    const mbsri_macro_call cut = {c->function, c->self, c->argument, c->keyword, 1},
                           glue = {c->function, c->argument + 1, &pieces, c->keyword, 1};
    const char *with;
    return mbsri_call_string(x, c, 1, &with) && call_split(x, &cut, &pieces) &&
           call_join(x, &glue, out);
}

/* ---- tables ---- */

static const mbsri_function of_dictionaries[] = {
    {"get", 0, 1, 2, call_get, NULL, NULL},
    {"keys", 0, 0, 0, call_items, NULL, NULL},
    {"values", 0, 0, 0, call_items, NULL, NULL},
    {"items", 0, 0, 0, call_items, NULL, NULL},
};

static const mbsri_function of_strings[] = {
    {"lower", 0, 0, 0, call_case, NULL, NULL},      {"upper", 0, 0, 0, call_case, NULL, NULL},
    {"startswith", 0, 1, 1, call_ends, NULL, NULL}, {"endswith", 0, 1, 1, call_ends, NULL, NULL},
    {"strip", 0, 0, 0, call_strip, NULL, NULL},     {"split", 0, 0, 1, call_split, NULL, NULL},
    {"join", 0, 1, 1, call_join, NULL, NULL},       {"replace", 0, 2, 2, call_replace, NULL, NULL},
};

bool mbsri_method_find(const mbsri_value *self, const char *name, mbsri_value *value)
{
    const mbsri_function *found = NULL;
    if (self->kind == MBSRI_DICTIONARY)
        found = mbsri_function_find(of_dictionaries,
                                    sizeof of_dictionaries / sizeof *of_dictionaries, 0, name);
    else if (self->kind == MBSRI_STRING)
        found = mbsri_function_find(of_strings, sizeof of_strings / sizeof *of_strings, 0, name);
    *value = (mbsri_value){.kind = MBSRI_FUNCTION, .of.function = found, .self = self};
    return found != NULL;
}
