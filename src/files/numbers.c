/* Numbers in texts: see numbers.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/numbers.h"

#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char *skip_space(const char *s)
{
    while (*s == ' ' || (*s >= '\t' && *s <= '\r')) ++s;
    return s;
}

/* Where the number ends; its digits as a whole number times 10^exponent where they are few
 * (`small`). NULL: no number. */
static const char *scan(const char *s, uint64_t *digits, int *exponent, bool *small)
{
    int count = 0, seen = 0, shift = 0;
    *digits = 0;
    if (*s == '+' || *s == '-') ++s;
    for (bool point = false;; ++s) {
        if (*s == '.' && !point) {
            point = true;
            continue;
        }
        if (!mbsri_is_digit(*s)) break;
        ++seen;
        if (count > 0 || *s != '0') ++count;
        if (count <= 18) *digits = 10 * *digits + (uint64_t)(*s - '0');
        if (point) --shift;
    }
    if (seen == 0) return NULL;
    if (*s == 'e' || *s == 'E') {
        const char *e = s + 1;
        const bool minus = *e == '-';
        int value = 0;
        if (*e == '+' || *e == '-') ++e;
        if (!mbsri_is_digit(*e)) return NULL;
        for (; mbsri_is_digit(*e); ++e) value = value < 100000 ? 10 * value + *e - '0' : value;
        shift += minus ? -value : value;
        s = e;
    }
    *exponent = shift;
    *small = count <= 18 && *digits <= UINT64_C(1) << 53 && shift >= -22 && shift <= 22;
    return s;
}

/* By the C library, with the decimal point of its locale. */
static bool convert(const char *from, const char *to, double *value)
{
    char buffer[128];
    const char *point = localeconv()->decimal_point;
    const size_t room = strlen(point);
    size_t used = 0;
    for (; from < to; ++from) {
        if (used + room + 1 >= sizeof buffer) return false;
        if (*from == '.') {
            memcpy(buffer + used, point, room);
            used += room;
        } else {
            buffer[used++] = *from;
        }
    }
    buffer[used] = '\0';
    char *end;
    *value = strtod(buffer, &end);
    return *end == '\0' && isfinite(*value);
}

bool mbsri_read_number(const char **text, double *value)
{
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *s = skip_space(*text);
    uint64_t digits;
    int exponent;
    bool small;
    const char *end = scan(s, &digits, &exponent, &small);
    if (!end || (*end && end == skip_space(end))) return false;
    if (small) { /* both numbers are exact: one rounding */
        const double whole = (double)digits,
                     size = exponent < 0 ? whole / power[-exponent] : whole * power[exponent];
        *value = *s == '-' ? -size : size;
    } else if (!convert(s, end, value)) {
        return false;
    }
    *text = skip_space(end);
    return true;
}

int mbsri_read_numbers(const char *text, int least, int most, double *values)
{
    int count = 0;
    text = skip_space(text);
    while (*text && count < most) {
        if (!mbsri_read_number(&text, values + count)) return -1;
        ++count;
    }
    return *text || count < least ? -1 : count;
}

bool mbsri_read_integer(const char *text, int *value)
{
    double x;
    if (mbsri_read_numbers(text, 1, 1, &x) != 1 || x != floor(x) || fabs(x) > 1e9) return false;
    *value = (int)x;
    return true;
}
