/* Scalars of YAML: see xacro_yaml_scalar.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/numbers.h"
#include "files/xacro_yaml_scalar.h"

#include "files/xacro_evaluate.h"

#include <math.h>
#include <string.h>

const char *mbsri_yaml_unquote(mbsri_xacro *x, const char *from, const char *to)
{
    static const char escapes[] = "\\\"/ntr", values[] = "\\\"/\n\t\r";
    const bool twice = *from == '"';
    char *text = mbsri_xacro_take(x, (size_t)(to - from)), *at = text;
    for (const char *s = from + 1; text && s < to - 1; ++s) {
        const char *escape = strchr(escapes, s[1]);
        if (twice && *s == '\\' && !escape) {
            mbsri_xacro_refuse(x, "\\%c in a text of YAML is not read", s[1]);
            return NULL;
        }
        *at++ = twice && *s == '\\' ? values[escape - escapes] : *s;
        if ((twice && *s == '\\') || (!twice && *s == '\'')) ++s;
    }
    return text;
}

/* One of the words between bars, in lower case, or with the first or all letters in upper case. */
static bool is_one_of(const char *text, const char *words)
{
    const size_t length = strlen(text);
    char lower[8] = "";
    if (length == 0 || length >= sizeof lower) return false;
    bool upper[2] = {true, true}; /* all; all but the first */
    bool none = true;
    for (size_t k = 0; k < length; ++k) {
        const bool large = text[k] >= 'A' && text[k] <= 'Z',
                   letter = large || (text[k] >= 'a' && text[k] <= 'z');
        lower[k] = large ? (char)(text[k] - 'A' + 'a') : text[k];
        if (letter && !large) upper[k > 0] = false;
        if (k > 0 && large) none = false;
    }
    if (!none && !(upper[0] && upper[1])) return false;
    for (const char *at = words + 1; (at = strstr(at, lower)); ++at) {
        if (at[-1] == '|' && at[length] == '|') return true;
    }
    return false;
}

/* Where digits with underscores between them end. */
static const char *skip_digits(const char *s)
{
    while (mbsri_is_digit(*s) || *s == '_') ++s;
    return s;
}

/* Digits, a point, digits, and an exponent with its sign. */
static bool looks_real(const char *s)
{
    const bool sign = *s == '+' || *s == '-';
    if (sign) ++s;
    if (!mbsri_is_digit(*s) && (sign || *s != '.' || !mbsri_is_digit(s[1]))) return false;
    s = skip_digits(s);
    if (*s != '.') return false;
    s = skip_digits(s + 1);
    if (*s == 'e' || *s == 'E') {
        if ((s[1] != '+' && s[1] != '-') || !mbsri_is_digit(s[2])) return false;
        for (s += 2; mbsri_is_digit(*s);) ++s;
    }
    return *s == '\0';
}

static bool looks_whole(const char *s)
{
    if (*s == '+' || *s == '-') ++s;
    return mbsri_is_digit(*s) && *skip_digits(s) == '\0';
}

/* Octal, hexadecimal, binary, to the base of 60, a date: nobody means these. */
static bool looks_odd(const char *s)
{
    const char *start = s;
    if (*s == '+' || *s == '-') ++s;
    if (!mbsri_is_digit(*s)) return false;
    const char *end = skip_digits(s);
    if (*s == '0' && (*end == 'x' || *end == 'b') && end == s + 1) return true;
    if (*s == '0' && end > s + 1 && *end == '\0') return true;
    if (*end == ':' && mbsri_is_digit(end[1])) {
        for (++end; mbsri_is_digit(*end) || *end == ':' || *end == '.' || *end == '_';) ++end;
        return *end == '\0';
    }
    return s == start && end == s + 4 && *end == '-' && mbsri_is_digit(end[1]) &&
           strchr(end + 1, '-');
}

bool mbsri_yaml_resolve(mbsri_xacro *x, const char *text, mbsri_value *value)
{
    const bool yes = is_one_of(text, "|yes|true|on|");
    const char *unsigned_text = text + (*text == '+' || *text == '-');
    char digits[120];
    size_t count = 0;
    int64_t whole;
    double real;
    *value = mbsri_value_string(text);
    if (!*text || strcmp(text, "~") == 0 || is_one_of(text, "|null|")) {
        *value = (mbsri_value){.kind = MBSRI_NOTHING};
    } else if (yes || is_one_of(text, "|no|false|off|")) {
        *value = mbsri_value_truth(yes);
    } else if (*unsigned_text == '.' && is_one_of(unsigned_text + 1, "|inf|")) {
        *value = mbsri_value_real(*text == '-' ? -INFINITY : INFINITY);
    } else if (strcmp(text, ".nan") == 0 || strcmp(text, ".NaN") == 0 ||
               strcmp(text, ".NAN") == 0) {
        *value = mbsri_value_real(NAN);
    } else if (looks_odd(text)) {
        return mbsri_xacro_refuse(x, "'%.40s' is a date, or no decimal number", text);
    } else if (looks_real(text) || looks_whole(text)) {
        for (const char *s = text; *s && count + 1 < sizeof digits; ++s) {
            if (*s != '_') digits[count++] = *s;
        }
        digits[count] = '\0';
        const bool is_whole = looks_whole(text);
        if (is_whole ? !mbsri_text_whole(digits, &whole) : !mbsri_text_real(digits, &real))
            return mbsri_xacro_refuse(x, "'%.40s' is not read as a number", text);
        *value = is_whole ? mbsri_value_whole(whole) : mbsri_value_real(real);
    }
    return true;
}

bool mbsri_yaml_unit(mbsri_xacro *x, const char *tag, size_t length, const char *text,
                     mbsri_value *value)
{
    static const struct {
        const char *name;
        double factor;
    } units[] = {{"!radians", 1.0}, {"!degrees", 3.14159265358979323846 / 180.0},
                 {"!meters", 1.0},  {"!millimeters", 0.001},
                 {"!foot", 0.3048}, {"!inches", 0.0254}};
    for (size_t k = 0; k < sizeof units / sizeof *units; ++k) {
        double number;
        if (strlen(units[k].name) != length || strncmp(units[k].name, tag, length) != 0) continue;
        if (!mbsri_xacro_evaluate(x, NULL, text, value)) return false;
        const bool good = value->kind == MBSRI_STRING ? mbsri_text_real(value->of.string, &number)
                                                      : mbsri_is_number(value, &number);
        if (!good) return mbsri_xacro_refuse(x, "%s is given %s", units[k].name, text);
        *value = mbsri_value_real(number * units[k].factor);
        return true;
    }
    return mbsri_xacro_refuse(x, "the tag %.*s of YAML is not read",
                              (int)(length < 40 ? length : 40), tag);
}
