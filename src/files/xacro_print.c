/* Values as Python writes them: see xacro_value.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/write_text.h"
#include "files/xacro_value.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBER = 40 };

/* The fewest digits, at most 17, that are read as this number, and the power of ten of the first.
 */
static void find_digits(double x, char digits[NUMBER], int *exponent)
{
    char text[NUMBER];
    int count = 0;
    for (int after = x < DBL_MIN ? 0 : 14; after <= 16; ++after) {
        snprintf(text, sizeof text, "%.*e", after, x);
        const double back = strtod(text, NULL);
        if (back <= x && back >= x) break;
    }
    const char *e = strchr(text, 'e');
    for (const char *c = text; c < e; ++c) {
        if (*c >= '0' && *c <= '9') digits[count++] = *c;
    }
    while (count > 1 && digits[count - 1] == '0') --count;
    digits[count] = '\0';
    *exponent = atoi(e + 1);
}

/* 0.1, 12.0, 1e-05, 1.5e+16: with an exponent outside of 1e-4 to 1e16. */
static void print_real(double x, char to[NUMBER])
{
    char digits[NUMBER], *at = to;
    int exponent;
    if (!isfinite(x)) {
        snprintf(to, NUMBER, "%s", isnan(x) ? "nan" : x > 0.0 ? "inf" : "-inf");
        return;
    }
    find_digits(fabs(x), digits, &exponent);
    const int count = (int)strlen(digits);
    if (signbit(x)) *at++ = '-';
    if (exponent < -4 || exponent >= 16) {
        snprintf(at, NUMBER - 1, "%c%s%.20se%c%02d", digits[0], count > 1 ? "." : "", digits + 1,
                 exponent < 0 ? '-' : '+', abs(exponent));
        return;
    }
    for (int k = exponent < 0 ? exponent : 0; k < count || k <= exponent + 1; ++k) {
        if (k == exponent + 1) *at++ = '.';
        *at++ = k < 0 || k >= count ? '0' : digits[k];
    }
    *at = '\0';
}

static const char *print_number(mbsri_xacro *x, const mbsri_value *v)
{
    char text[NUMBER];
    if (v->kind == MBSRI_WHOLE)
        snprintf(text, sizeof text, "%" PRId64, v->of.whole);
    else
        print_real(v->of.real, text);
    return mbsri_xacro_copy(x, text, strlen(text));
}

/* A string between quotes, as in a list. */
static void quote(mbsri_text *t, const char *s)
{
    const char *mark = strchr(s, '\'') && !strchr(s, '"') ? "\"" : "'";
    mbsri_put(t, mark, 1);
    for (; *s; ++s) {
        if (*s == '\n')
            mbsri_put(t, "\\n", 2);
        else if (*s == '\t')
            mbsri_put(t, "\\t", 2);
        else if (*s == '\r')
            mbsri_put(t, "\\r", 2);
        else {
            if (*s == '\\' || *s == *mark) mbsri_put(t, "\\", 1);
            mbsri_put(t, s, 1);
        }
    }
    mbsri_put(t, mark, 1);
}

static bool print(mbsri_xacro *x, mbsri_text *t, const mbsri_value *v);

static bool print_items(mbsri_xacro *x, mbsri_text *t, const mbsri_value *v)
{
    const int count = v->of.list->count;
    const bool keys = v->kind == MBSRI_DICTIONARY;
    const char *marks = keys ? "{}" : v->kind == MBSRI_LIST ? "[]" : "()";
    if (!mbsri_xacro_enter(x)) return false;
    mbsri_put(t, marks, 1);
    for (int k = 0; k < count; ++k) {
        if (k > 0) mbsri_put(t, keys && k % 2 ? ": " : ", ", 2);
        if (!print(x, t, mbsri_items(v) + k)) return false;
    }
    if (v->kind == MBSRI_TUPLE && count == 1) mbsri_put(t, ",", 1);
    mbsri_put(t, marks + 1, 1);
    mbsri_xacro_leave(x);
    return true;
}

/* As within a list. */
static bool print(mbsri_xacro *x, mbsri_text *t, const mbsri_value *v)
{
    const size_t before = t->size;
    if (v->kind == MBSRI_STRING) {
        quote(t, v->of.string);
    } else if (mbsri_is_sequence(v) || v->kind == MBSRI_DICTIONARY) {
        return print_items(x, t, v);
    } else {
        const char *text = mbsri_value_text(x, v);
        if (!text) return false;
        mbsri_put(t, text, strlen(text));
    }
    if (t->size > MBSRI_XACRO_TEXT) return mbsri_xacro_refuse(x, "a text is too long");
    return mbsri_xacro_spend(x, 16 + 3 * (t->size - before));
}

const char *mbsri_value_text(mbsri_xacro *x, const mbsri_value *v)
{
    mbsri_text text = {.arena = x->s->arena};
    switch (v->kind) {
    case MBSRI_NOTHING: return "None";
    case MBSRI_TRUTH: return v->of.truth ? "True" : "False";
    case MBSRI_WHOLE:
    case MBSRI_REAL: return print_number(x, v);
    case MBSRI_STRING: return v->of.string;
    case MBSRI_LIST:
    case MBSRI_TUPLE:
    case MBSRI_DICTIONARY:
        if (!mbsri_xacro_spend(x, 4096) || !print_items(x, &text, v)) return NULL;
        return text.data;
    default: mbsri_xacro_refuse(x, "%s cannot be written", mbsri_kind_name(v)); return NULL;
    }
}
