/* What expressions of xacro may call: see xacro_functions.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_functions.h"

#include "files/xacro_arithmetic.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- conversions ---- */

static bool call_list(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    if (c->count == 0) return mbsri_value_begin(x, MBSRI_LIST, out) != NULL;
    return mbsri_call_items(x, c, out);
}

static bool call_tuple(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const bool good = call_list(x, c, out);
    out->kind = MBSRI_TUPLE;
    return good;
}

static bool call_dict(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    mbsri_list *list = mbsri_value_begin(x, MBSRI_DICTIONARY, out);
    for (int k = 0; list && k < c->count; ++k) {
        if (c->keyword[k]) {
            const mbsri_value key = mbsri_value_string(c->keyword[k]);
            mbsri_value *known;
            if (!mbsri_value_find(x, out, &key, &known)) return false;
            if (known) return mbsri_xacro_refuse(x, "dict() has '%.40s' twice", c->keyword[k]);
            if (!mbsri_value_add(x, list, &key) || !mbsri_value_add(x, list, c->argument + k))
                return false;
            continue;
        }
        if (k > 0 || c->argument->kind != MBSRI_DICTIONARY) return mbsri_call_refuse(x, c, k);
        for (int l = 0; l < c->argument->of.list->count; ++l) {
            if (!mbsri_value_add(x, list, mbsri_items(c->argument) + l)) return false;
        }
    }
    return list != NULL;
}

static bool call_str(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *text = c->count > 0 ? mbsri_value_text(x, c->argument) : "";
    *out = mbsri_value_string(text);
    return text != NULL;
}

static bool call_float(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const mbsri_value *v = c->argument;
    double real;
    if (v->kind == MBSRI_STRING) {
        if (!mbsri_text_real(v->of.string, &real))
            return mbsri_xacro_refuse(x, "float() is given '%.40s'", v->of.string);
    } else if (!mbsri_is_number(v, &real)) {
        return mbsri_call_refuse(x, c, 0);
    }
    *out = mbsri_value_real(real);
    return true;
}

static bool call_int(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const mbsri_value *v = c->argument;
    int64_t whole;
    if (v->kind == MBSRI_REAL) return mbsri_make_whole(x, v->of.real, trunc, out);
    if (v->kind == MBSRI_STRING) {
        if (!mbsri_text_whole(v->of.string, &whole))
            return mbsri_xacro_refuse(x, "int() is given '%.40s'", v->of.string);
    } else if (!mbsri_is_whole(v, &whole)) {
        return mbsri_call_refuse(x, c, 0);
    }
    *out = mbsri_value_whole(whole);
    return true;
}

/* ---- numbers ---- */

static bool call_len(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const mbsri_value *v = c->argument;
    int64_t length = 0;
    if (v->kind == MBSRI_STRING) {
        for (const char *s = v->of.string; *s; ++s) length += ((unsigned char)*s & 0xc0) != 0x80;
    } else if (mbsri_is_sequence(v) || v->kind == MBSRI_DICTIONARY) {
        length = v->of.list->count / (v->kind == MBSRI_DICTIONARY ? 2 : 1);
    } else {
        return mbsri_call_refuse(x, c, 0);
    }
    *out = mbsri_value_whole(length);
    return true;
}

static bool call_abs(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const mbsri_value zero = mbsri_value_whole(0), *v = c->argument;
    int64_t whole;
    double real;
    if (mbsri_is_whole(v, &whole)) {
        if (whole < 0) return mbsri_arithmetic(x, "-", &zero, v, out);
        *out = mbsri_value_whole(whole);
        return true;
    }
    if (!mbsri_is_number(v, &real)) return mbsri_call_refuse(x, c, 0);
    *out = mbsri_value_real(fabs(real));
    return true;
}

/* To digits behind the point, of which exactly halves go to even ones. */
static bool call_round(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    char text[360];
    int64_t digits;
    double real;
    if (!mbsri_is_number(c->argument, &real)) return mbsri_call_refuse(x, c, 0);
    if (c->argument->kind != MBSRI_REAL && c->count == 1) return call_int(x, c, out);
    if (c->count == 1) return mbsri_make_whole(x, real, rint, out);
    if (!mbsri_is_whole(c->argument + 1, &digits)) return mbsri_call_refuse(x, c, 1);
    if (digits < 0 || c->argument->kind != MBSRI_REAL)
        return mbsri_xacro_refuse(x, "round() is read for digits behind a point only");
    *out = *c->argument;
    if (digits > 22 || !isfinite(real)) return true;
    snprintf(text, sizeof text, "%.*f", (int)digits, real);
    *out = mbsri_value_real(strtod(text, NULL));
    return true;
}

static bool call_extreme(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const int sign = strcmp(c->function->name, "min") == 0 ? -1 : 1;
    mbsri_value all;
    const mbsri_value *item = c->argument;
    int count = c->count, order;
    if (count == 1) {
        if (!mbsri_call_items(x, c, &all)) return false;
        item = mbsri_items(&all);
        count = all.of.list->count;
    }
    if (count == 0) return mbsri_xacro_refuse(x, "%s() of nothing", c->function->name);
    *out = item[0];
    for (int k = 1; k < count; ++k) {
        if (!mbsri_value_compare(x, item + k, out, &order)) return false;
        if (order == sign) *out = item[k];
    }
    return true;
}

static bool call_sum(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    mbsri_value all;
    if (!mbsri_call_items(x, c, &all)) return false;
    *out = mbsri_value_whole(0);
    for (int k = 0; k < all.of.list->count; ++k) {
        const mbsri_value before = *out;
        if (!mbsri_arithmetic(x, "+", &before, mbsri_items(&all) + k, out)) return false;
    }
    return true;
}

static bool call_all(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const bool all = strcmp(c->function->name, "all") == 0;
    mbsri_value list;
    if (!mbsri_call_items(x, c, &list)) return false;
    bool result = all;
    for (int k = 0; k < list.of.list->count; ++k) {
        if (mbsri_value_true(mbsri_items(&list) + k) != all) result = !all;
    }
    *out = mbsri_value_truth(result);
    return true;
}

/* ---- lists ---- */

static bool call_range(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    int64_t given[3] = {0, 0, 1};
    mbsri_list *list = mbsri_value_begin(x, MBSRI_LIST, out);
    for (int k = 0; k < c->count; ++k) {
        int64_t *to = given + (c->count == 1 ? 1 : k);
        if (!mbsri_is_whole(c->argument + k, to)) return mbsri_call_refuse(x, c, k);
        if (*to > INT32_MAX || *to < INT32_MIN) return mbsri_xacro_refuse(x, "range() is too long");
    }
    if (given[2] == 0) return mbsri_xacro_refuse(x, "range() has steps of 0");
    for (int64_t at = given[0]; list && (given[2] > 0 ? at < given[1] : at > given[1]);
         at += given[2]) {
        const mbsri_value item = mbsri_value_whole(at);
        if (!mbsri_value_add(x, list, &item)) return false;
    }
    return list != NULL;
}

/* By insertion: what is sorted in a file of a robot is short. */
static bool call_sorted(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    if (!mbsri_call_items(x, c, out)) return false;
    mbsri_value *item = out->of.list->items;
    for (int k = 1; k < out->of.list->count; ++k) {
        const mbsri_value moved = item[k];
        int at = k, order;
        for (; at > 0; --at) {
            if (!mbsri_value_compare(x, item + at - 1, &moved, &order)) return false;
            if (order <= 0) break;
            item[at] = item[at - 1];
        }
        item[at] = moved;
    }
    return true;
}

/* ---- of xacro ---- */

static bool call_load_yaml(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *path;
    return mbsri_call_string(x, c, 0, &path) && x->load_yaml(x, path, out);
}

static bool call_arg(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *name;
    if (!mbsri_call_string(x, c, 0, &name)) return false;
    *out = mbsri_value_string(mbsri_xacro_argument(x, name));
    return out->of.string || mbsri_xacro_refuse(x, "the argument '%.40s' has no value", name);
}

static bool call_abs_filename(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *path;
    if (!mbsri_call_string(x, c, 0, &path)) return false;
    *out = mbsri_value_string(mbsri_xacro_beside(x, path));
    return out->of.string != NULL;
}

static bool call_dotify(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    *out = *c->argument;
    return out->kind == MBSRI_DICTIONARY || mbsri_call_refuse(x, c, 0);
}

/* message, warning, error: a finding. */
static bool call_message(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *text = mbsri_value_text(x, c->argument);
    *out = mbsri_value_string("");
    if (text) mbsri_file_find(x->s, x->at, "%.200s", text);
    return text != NULL;
}

static bool call_fatal(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    const char *text = mbsri_value_text(x, c->argument);
    *out = mbsri_value_string("");
    return text && mbsri_xacro_refuse(x, "%.90s", text);
}

/* ---- tables ---- */

enum { BOTH = MBSRI_EVERYWHERE | MBSRI_PYTHON, OURS = MBSRI_EVERYWHERE | MBSRI_XACRO };

static const mbsri_function functions[] = {
    {"list", BOTH, 0, 1, call_list, NULL, NULL},
    {"dict", BOTH, 0, 1000, call_dict, NULL, NULL},
    {"len", BOTH, 1, 1, call_len, NULL, NULL},
    {"str", BOTH, 0, 1, call_str, NULL, NULL},
    {"float", BOTH, 1, 1, call_float, NULL, NULL},
    {"int", BOTH, 1, 1, call_int, NULL, NULL},
    {"min", BOTH, 1, 1000, call_extreme, NULL, NULL},
    {"max", BOTH, 1, 1000, call_extreme, NULL, NULL},
    {"round", BOTH, 1, 2, call_round, NULL, NULL},
    {"sorted", BOTH, 1, 1, call_sorted, NULL, NULL},
    {"range", BOTH, 1, 3, call_range, NULL, NULL},
    {"abs", MBSRI_PYTHON, 1, 1, call_abs, NULL, NULL},
    {"all", MBSRI_PYTHON, 1, 1, call_all, NULL, NULL},
    {"any", MBSRI_PYTHON, 1, 1, call_all, NULL, NULL},
    {"sum", MBSRI_PYTHON, 1, 1, call_sum, NULL, NULL},
    {"tuple", MBSRI_PYTHON, 0, 1, call_tuple, NULL, NULL},
    {"load_yaml", OURS, 1, 1, call_load_yaml, NULL, NULL},
    {"abs_filename", OURS, 1, 1, call_abs_filename, NULL, NULL},
    {"dotify", OURS, 1, 1, call_dotify, NULL, NULL},
    {"arg", MBSRI_XACRO, 1, 1, call_arg, NULL, NULL},
    {"message", MBSRI_XACRO, 1, 1, call_message, NULL, NULL},
    {"warning", MBSRI_XACRO, 1, 1, call_message, NULL, NULL},
    {"error", MBSRI_XACRO, 1, 1, call_message, NULL, NULL},
    {"fatal", MBSRI_XACRO, 1, 1, call_fatal, NULL, NULL},
};

bool mbsri_module_find(int module, const char *name, mbsri_value *value)
{
    if ((module == MBSRI_MATH || module == MBSRI_EVERYWHERE) && mbsri_math_find(name, value))
        return true;
    const mbsri_function *found =
        mbsri_function_find(functions, sizeof functions / sizeof *functions, module, name);
    *value = (mbsri_value){.kind = MBSRI_FUNCTION, .of.function = found};
    return found != NULL;
}

bool mbsri_global_find(const char *name, mbsri_value *value)
{
    static const char *const names[] = {"math", "python", "xacro"};
    static const int modules[] = {MBSRI_MATH, MBSRI_PYTHON, MBSRI_XACRO};
    for (int k = 0; k < 3; ++k) {
        if (strcmp(names[k], name) != 0) continue;
        *value = (mbsri_value){.kind = MBSRI_MODULE, .of.module = modules[k]};
        return true;
    }
    return mbsri_module_find(MBSRI_EVERYWHERE, name, value);
}
