/* Values of expressions of xacro: see xacro_value.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_value.h"

#include "files/numbers.h"

#include <math.h>
#include <string.h>

bool mbsri_is_whole(const mbsri_value *v, int64_t *whole)
{
    if (v->kind != MBSRI_WHOLE && v->kind != MBSRI_TRUTH) return false;
    *whole = v->kind == MBSRI_WHOLE ? v->of.whole : v->of.truth;
    return true;
}

bool mbsri_is_number(const mbsri_value *v, double *number)
{
    int64_t whole = 0;
    if (v->kind != MBSRI_REAL && !mbsri_is_whole(v, &whole)) return false;
    *number = v->kind == MBSRI_REAL ? v->of.real : (double)whole;
    return true;
}

mbsri_list *mbsri_value_begin(mbsri_xacro *x, mbsri_value_kind kind, mbsri_value *value)
{
    mbsri_list *list = mbsri_xacro_take(x, sizeof *list);
    *value = (mbsri_value){.kind = kind, .of.list = list};
    return list;
}

bool mbsri_value_add(mbsri_xacro *x, mbsri_list *list, const mbsri_value *item)
{
    if (!mbsri_xacro_spend(x, 2 * sizeof *item)) return false;
    mbsri_value *place = mbsri_list_add(x->s->arena, list, sizeof *place);
    if (place) *place = *item;
    return place != NULL;
}

const char *mbsri_kind_name(const mbsri_value *v)
{
    static const char *const names[] = {
        "None",    "a truth value", "a number",   "a number", "a string",    "a list",
        "a tuple", "a dictionary",  "a function", "a module", "a namespace", "a block"};
    return names[v->kind];
}

bool mbsri_value_true(const mbsri_value *v)
{
    switch (v->kind) {
    case MBSRI_NOTHING: return false;
    case MBSRI_TRUTH: return v->of.truth;
    case MBSRI_WHOLE: return v->of.whole != 0;
    case MBSRI_REAL: return !(v->of.real >= 0.0 && v->of.real <= 0.0);
    case MBSRI_STRING: return v->of.string[0] != '\0';
    case MBSRI_LIST:
    case MBSRI_TUPLE:
    case MBSRI_DICTIONARY: return v->of.list->count > 0;
    default: return true;
    }
}

/* ---- comparing ---- */

static int order_of(double a, double b)
{
    return a < b ? -1 : a > b ? 1 : 0;
}

/* Of numbers; false: one is none. NaN is refused where order counts: it cannot come up by
 * arithmetic. */
static bool compare_numbers(const mbsri_value *a, const mbsri_value *b, int *order)
{
    int64_t i, j;
    double u, v;
    if (mbsri_is_whole(a, &i) && mbsri_is_whole(b, &j)) {
        *order = i < j ? -1 : i > j;
        return true;
    }
    if (!mbsri_is_number(a, &u) || !mbsri_is_number(b, &v)) return false;
    *order = isnan(u) || isnan(v) ? 2 : order_of(u, v);
    return true;
}

/* Whether a and b are equal as keys of a dictionary: numbers, strings, truth values, None. */
static bool same_key(const mbsri_value *a, const mbsri_value *b)
{
    int order;
    if (compare_numbers(a, b, &order)) return order == 0;
    if (a->kind != b->kind) return false;
    return a->kind == MBSRI_NOTHING ||
           (a->kind == MBSRI_STRING && strcmp(a->of.string, b->of.string) == 0);
}

bool mbsri_value_find(mbsri_xacro *x, const mbsri_value *dictionary, const mbsri_value *key,
                      mbsri_value **found)
{
    const mbsri_list *list = dictionary->of.list;
    mbsri_value *item = list->items;
    int k = 0;
    *found = NULL;
    while (k < list->count && !same_key(item + k, key)) k += 2;
    if (k < list->count) *found = item + k + 1;
    return mbsri_xacro_spend(x, (size_t)(4 * k));
}

/* Both have the same values, in a dictionary under the same keys. */
static bool equal_items(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, bool *equal)
{
    const int count = a->of.list->count;
    const bool keys = a->kind == MBSRI_DICTIONARY;
    *equal = count == b->of.list->count;
    if (!mbsri_xacro_enter(x)) return false;
    for (int k = keys ? 1 : 0; k < count && *equal; k += keys ? 2 : 1) {
        const mbsri_value *mine = mbsri_items(a) + k;
        mbsri_value *other = keys ? NULL : (mbsri_value *)b->of.list->items + k;
        if (keys && !mbsri_value_find(x, b, mine - 1, &other)) return false;
        if (!other)
            *equal = false;
        else if (!mbsri_value_equal(x, mine, other, equal))
            return false;
    }
    mbsri_xacro_leave(x);
    return true;
}

bool mbsri_value_equal(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, bool *equal)
{
    int order;
    if (!mbsri_xacro_spend(x, 16)) return false;
    if (compare_numbers(a, b, &order)) {
        *equal = order == 0;
        return true;
    }
    *equal = a->kind == b->kind;
    if (!*equal) return true;
    switch (a->kind) {
    case MBSRI_NOTHING: return true;
    case MBSRI_STRING:
        *equal = strcmp(a->of.string, b->of.string) == 0;
        return mbsri_xacro_spend(x, strlen(a->of.string));
    case MBSRI_LIST:
    case MBSRI_TUPLE:
    case MBSRI_DICTIONARY: return equal_items(x, a, b, equal);
    default: return mbsri_xacro_refuse(x, "%s cannot be compared", mbsri_kind_name(a));
    }
}

static bool compare_items(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, int *order)
{
    const int m = a->of.list->count, n = b->of.list->count;
    *order = 0;
    if (!mbsri_xacro_enter(x)) return false;
    for (int k = 0; k < m && k < n && *order == 0; ++k) {
        bool equal;
        if (!mbsri_value_equal(x, mbsri_items(a) + k, mbsri_items(b) + k, &equal)) return false;
        if (!equal && !mbsri_value_compare(x, mbsri_items(a) + k, mbsri_items(b) + k, order))
            return false;
    }
    mbsri_xacro_leave(x);
    if (*order == 0) *order = m < n ? -1 : m > n;
    return true;
}

bool mbsri_value_compare(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, int *order)
{
    if (!mbsri_xacro_spend(x, 16)) return false;
    if (compare_numbers(a, b, order)) {
        return *order <= 1 || mbsri_xacro_refuse(x, "nan has no order");
    }
    if (a->kind == MBSRI_STRING && b->kind == MBSRI_STRING) {
        const int sign = strcmp(a->of.string, b->of.string);
        *order = sign < 0 ? -1 : sign > 0;
        return mbsri_xacro_spend(x, strlen(a->of.string));
    }
    if (mbsri_is_sequence(a) && a->kind == b->kind) return compare_items(x, a, b, order);
    return mbsri_xacro_refuse(x, "%s and %s have no order", mbsri_kind_name(a), mbsri_kind_name(b));
}

/* ---- from texts ---- */

static const char *skip_space(const char *s)
{
    while (*s == ' ' || (*s >= '\t' && *s <= '\r')) ++s;
    return s;
}

/* Digits with single underscores between. */
bool mbsri_text_whole(const char *text, int64_t *whole)
{
    const char *s = skip_space(text);
    const bool minus = *s == '-';
    int64_t value = 0;
    if (*s == '+' || *s == '-') ++s;
    if (*s < '0' || *s > '9') return false;
    for (; (*s >= '0' && *s <= '9') || (*s == '_' && s[1] >= '0' && s[1] <= '9'); ++s) {
        if (*s == '_') continue;
        const int digit = *s - '0';
        if (value > (INT64_MAX - digit) / 10) return false;
        value = 10 * value + digit;
    }
    *whole = minus ? -value : value;
    return *skip_space(s) == '\0';
}

bool mbsri_text_real(const char *text, double *real)
{
    static const struct {
        const char *name;
        double value;
    } words[] = {{"inf", INFINITY}, {"infinity", INFINITY}, {"nan", NAN}};
    char word[12];
    size_t length = 0;
    if (mbsri_read_numbers(text, 1, 1, real) == 1) return true;
    const char *s = skip_space(text);
    const bool minus = *s == '-';
    if (*s == '+' || *s == '-') ++s;
    for (; *s && *skip_space(s) && length + 1 < sizeof word; ++s)
        word[length++] = *s >= 'A' && *s <= 'Z' ? (char)(*s - 'A' + 'a') : *s;
    word[length] = '\0';
    for (size_t k = 0; k < sizeof words / sizeof *words; ++k) {
        if (*skip_space(s) || strcmp(word, words[k].name) != 0) continue;
        *real = minus ? -words[k].value : words[k].value;
        return true;
    }
    return false;
}

static bool read_truth(const char *text, bool *truth)
{
    *truth = strcmp(text, "true") == 0 || strcmp(text, "True") == 0;
    return *truth || strcmp(text, "false") == 0 || strcmp(text, "False") == 0;
}

mbsri_value mbsri_value_literal(mbsri_xacro *x, const mbsri_value *v)
{
    int64_t whole;
    double real;
    bool truth;
    if (v->kind != MBSRI_STRING) return *v;
    const char *text = v->of.string;
    const size_t length = strlen(text);
    if (length >= 2 && text[0] == '\'' && text[length - 1] == '\'') {
        const char *bare = mbsri_xacro_copy(x, text + 1, length - 2);
        return mbsri_value_string(bare ? bare : "");
    }
    if (strchr(text, '_')) return *v;
    if (mbsri_text_whole(text, &whole)) return mbsri_value_whole(whole);
    if (mbsri_text_real(text, &real)) return mbsri_value_real(real);
    return read_truth(text, &truth) ? mbsri_value_truth(truth) : *v;
}

bool mbsri_value_condition(const mbsri_value *v, bool *keep)
{
    int64_t whole;
    if (v->kind != MBSRI_STRING) {
        *keep = mbsri_value_true(v);
        return true;
    }
    if (read_truth(v->of.string, keep)) return true;
    if (!mbsri_text_whole(v->of.string, &whole)) return false;
    *keep = whole != 0;
    return true;
}
