/* Texts line by line: see lines.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/lines.h"

#include "base/error.h"
#include "files/numbers.h"

#include <limits.h>
#include <string.h>

int mbsri_refuse_line(const mbsri_lines *l, const char *format, ...)
{
    char reason[MBSR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    mbsri_vprint(reason, sizeof reason, format, arguments);
    va_end(arguments);
    return mbsri_fail_plain(l->error, MBSR_ERR_FILE, "%.60s:%d: %s", l->file, l->line, reason);
}

static bool separates(char c)
{
    return c == ' ' || c == '\t' || c == ',' || c == '\r' || c == '\0' || c == '\f' || c == '\v';
}

bool mbsri_next_line(mbsri_lines *l)
{
    while (l->text < l->end) {
        const char *stop = memchr(l->text, '\n', (size_t)(l->end - l->text));
        l->word = l->text;
        l->stop = stop ? stop : l->end;
        l->text = stop ? stop + 1 : l->end;
        if (l->line < INT_MAX) ++l->line;
        while (l->word < l->stop && separates(*l->word)) ++l->word;
        if (l->word < l->stop && *l->word != l->comment) return true;
    }
    return false;
}

bool mbsri_next_word(mbsri_lines *l, char word[MBSRI_WORD])
{
    size_t used = 0;
    while (l->word < l->stop && separates(*l->word)) ++l->word;
    for (; l->word < l->stop && !separates(*l->word); ++l->word) {
        if (used + 1 < MBSRI_WORD) word[used++] = *l->word;
    }
    word[used] = '\0';
    return used > 0;
}

bool mbsri_next_number(mbsri_lines *l, const char *what, double *value)
{
    char word[MBSRI_WORD];
    if (!mbsri_next_word(l, word)) {
        (void)mbsri_refuse_line(l, "the line ends, %s is wanted", what);
        return false;
    }
    for (char *c = word; *c; ++c) { /* exponents of Fortran */
        if (*c == 'D' || *c == 'd') *c = 'E';
    }
    if (mbsri_read_numbers(word, 1, 1, value) == 1) return true;
    (void)mbsri_refuse_line(l, "'%.40s' is no number; %s is wanted", word, what);
    return false;
}

bool mbsri_next_integer(mbsri_lines *l, const char *what, int *value)
{
    double x;
    if (!mbsri_next_number(l, what, &x)) return false;
    *value = 0;
    if (x >= -INT_MAX && x <= INT_MAX) *value = (int)x;
    if (x == (double)*value) return true;
    (void)mbsri_refuse_line(l, "%.17g is no whole number below %d; %s is wanted", x, INT_MAX, what);
    return false;
}

bool mbsri_line_ends(mbsri_lines *l)
{
    char word[MBSRI_WORD];
    if (!mbsri_next_word(l, word)) return true;
    (void)mbsri_refuse_line(l, "'%.40s' is one thing more than belongs there", word);
    return false;
}

static int lower(char c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c;
}

bool mbsri_same_word(const char *a, const char *b)
{
    while (*a && lower(*a) == lower(*b)) ++a, ++b;
    return lower(*a) == lower(*b);
}
