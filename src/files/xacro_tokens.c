/* Tokens of an expression of xacro: see xacro_tokens.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_tokens.h"

#include "files/numbers.h"

#include <string.h>

/* Letters beyond ASCII, too. */
static bool begins_name(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (unsigned char)c >= 128;
}

/* ---- numbers ---- */

/* Without the underscores between digits, which may be letters; false: too long, or one stands
 * elsewhere. */
static bool copy_digits(const char *from, const char *to, bool letters, char *digits, size_t size)
{
    size_t count = 0;
    for (; from < to; ++from) {
        if (*from == '_') {
            for (int side = -1; side <= 1; side += 2) {
                const char c = from[side];
                if (!mbsri_is_digit(c) && !(letters && c != '_' && begins_name(c))) return false;
            }
            continue;
        }
        if (count + 1 == size) return false;
        digits[count++] = *from;
    }
    digits[count] = '\0';
    return true;
}

/* 0x1F, 0b101, 0o17. */
static bool read_based(const char *digits, int64_t *whole)
{
    const int base = digits[1] == 'x' || digits[1] == 'X'   ? 16
                     : digits[1] == 'o' || digits[1] == 'O' ? 8
                                                            : 2;
    *whole = 0;
    if (!digits[2]) return false;
    for (const char *s = digits + 2; *s; ++s) {
        const int lower = *s >= 'A' && *s <= 'Z' ? *s - 'A' + 'a' : *s,
                  digit = mbsri_is_digit(*s) ? *s - '0'
                          : lower >= 'a'     ? lower - 'a' + 10
                                             : 99;
        if (digit >= base || *whole > (INT64_MAX - digit) / base) return false;
        *whole = *whole * base + digit;
    }
    return true;
}

static bool read_number(mbsri_xacro *x, const char **text, mbsri_token *token)
{
    const char *s = *text, *end = s;
    const bool based = s[0] == '0' && s[1] && strchr("xXbBoO", s[1]);
    bool real = false, good;
    char digits[120];
    int64_t whole = 0;
    double number = 0.0;
    while (mbsri_is_digit(*end) || begins_name(*end) || *end == '.' ||
           ((*end == '+' || *end == '-') && !based && (end[-1] == 'e' || end[-1] == 'E'))) {
        real = real || (!based && (*end == '.' || *end == 'e' || *end == 'E'));
        ++end;
    }
    good = copy_digits(s, end, based, digits, sizeof digits);
    if (good && based)
        good = read_based(digits, &whole);
    else if (good && real)
        good = mbsri_read_numbers(digits, 1, 1, &number) == 1;
    else if (good)
        good = mbsri_text_whole(digits, &whole) && (digits[0] != '0' || whole == 0);
    if (!good) return mbsri_xacro_refuse(x, "'%.*s' is not read as a number", (int)(end - s), s);
    token->kind = MBSRI_TOKEN_VALUE;
    token->value = real ? mbsri_value_real(number) : mbsri_value_whole(whole);
    *text = end;
    return true;
}

/* ---- strings ---- */

static bool read_string(mbsri_xacro *x, const char **text, mbsri_token *token)
{
    static const char from[] = "\\'\"ntr\n", to[] = "\\'\"\n\t\r";
    const char mark = **text, *s = *text + 1;
    const size_t length = strlen(s);
    char *string = mbsri_xacro_take(x, length + 1), *at = string;
    if (!string) return false;
    for (; *s && *s != mark; ++s) {
        const char *escape = *s == '\\' && s[1] ? strchr(from, s[1]) : NULL;
        if (*s == '\\' && s[1] && strchr("01234567xuUNabfv", s[1]))
            return mbsri_xacro_refuse(x, "\\%c in a string is not read", s[1]);
        if (!escape) {
            *at++ = *s;
            continue;
        }
        if (to[escape - from]) *at++ = to[escape - from];
        ++s;
    }
    if (!*s) return mbsri_xacro_refuse(x, "a string does not end: %.40s", *text);
    *at = '\0';
    token->kind = MBSRI_TOKEN_VALUE;
    token->value = mbsri_value_string(string);
    *text = s + 1;
    return true;
}

/* ---- all ---- */

static bool read_name(mbsri_xacro *x, const char **text, mbsri_token *token)
{
    const char *s = *text;
    while (begins_name(*s) || mbsri_is_digit(*s)) ++s;
    if (*s == '\'' || *s == '"')
        return mbsri_xacro_refuse(x, "strings that begin with %.*s%c are not read",
                                  (int)(s - *text), *text, *s);
    token->kind = MBSRI_TOKEN_NAME;
    token->text = mbsri_xacro_copy(x, *text, (size_t)(s - *text));
    *text = s;
    return token->text != NULL;
}

bool mbsri_token_next(mbsri_xacro *x, const char **text, mbsri_token *token)
{
    static const char *const marks[] = {"**", "//", "==", "!=", "<=", ">=", "<", ">", "+", "-", "*",
                                        "/",  "%",  "(",  ")",  "[",  "]",  ",", ":", ".", "="};
    const char *s = *text + strspn(*text, " \t\r\n");
    *token = (mbsri_token){.kind = MBSRI_TOKEN_END, .text = "the end"};
    *text = s;
    if (!*s) return true;
    if (!mbsri_xacro_spend(x, 16)) return false;
    if (mbsri_is_digit(*s) || (*s == '.' && mbsri_is_digit(s[1])))
        return read_number(x, text, token);
    if (begins_name(*s)) return read_name(x, text, token);
    if (*s == '\'' || *s == '"') return read_string(x, text, token);
    for (size_t k = 0; k < sizeof marks / sizeof *marks; ++k) {
        if (strncmp(s, marks[k], strlen(marks[k])) != 0) continue;
        token->kind = MBSRI_TOKEN_MARK;
        token->text = marks[k];
        *text = s + strlen(marks[k]);
        return true;
    }
    return mbsri_xacro_refuse(x, "'%.20s' is nothing that expressions have here", s);
}
