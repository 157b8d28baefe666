/* A call of a function in an expression of xacro: see xacro_call.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_call.h"

#include <string.h>

const mbsri_function *mbsri_function_find(const mbsri_function *table, size_t count, int where,
                                          const char *name)
{
    for (size_t k = 0; k < count; ++k) {
        if ((!where || (table[k].where & where)) && strcmp(table[k].name, name) == 0)
            return table + k;
    }
    return NULL;
}

bool mbsri_call_refuse(mbsri_xacro *x, const mbsri_macro_call *c, int k)
{
    return mbsri_xacro_refuse(x, "%s() is given %s", c->function->name,
                              mbsri_kind_name(c->argument + k));
}

bool mbsri_call_number(mbsri_xacro *x, const mbsri_macro_call *c, int k, double *number)
{
    return mbsri_is_number(c->argument + k, number) || mbsri_call_refuse(x, c, k);
}

bool mbsri_call_string(mbsri_xacro *x, const mbsri_macro_call *c, int k, const char **string)
{
    const bool good = c->argument[k].kind == MBSRI_STRING;
    *string = good ? c->argument[k].of.string : "";
    return good || mbsri_call_refuse(x, c, k);
}

bool mbsri_call_items(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const mbsri_value *v = c->argument;
    mbsri_list *list = mbsri_value_begin(x, MBSRI_LIST, out);
    if (!list) return false;
    if (v->kind == MBSRI_STRING) {
        for (const char *s = v->of.string; *s;) {
            size_t length = 1;
            while (((unsigned char)s[length] & 0xc0) == 0x80) ++length;
            const char *letter = mbsri_xacro_copy(x, s, length);
            const mbsri_value item = mbsri_value_string(letter);
            if (!letter || !mbsri_value_add(x, list, &item)) return false;
            s += length;
        }
        return true;
    }
    if (!mbsri_is_sequence(v) && v->kind != MBSRI_DICTIONARY) return mbsri_call_refuse(x, c, 0);
    for (int k = 0; k < v->of.list->count; k += v->kind == MBSRI_DICTIONARY ? 2 : 1) {
        if (!mbsri_value_add(x, list, mbsri_items(v) + k)) return false;
    }
    return true;
}
