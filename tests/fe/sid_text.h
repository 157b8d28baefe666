/* Texts of SID files, looked at and changed line by line.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SID_TEXT_H
#define TEST_SID_TEXT_H

#include "expect.h"

#include <mbsrank/sid.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where the lines of a block begin, behind that of its name, on the level of mdCM. */
static inline const char *test_sid_block(const char *text, const char *name)
{
    char line[64];
    snprintf(line, sizeof line, "\n           %s\n", name);
    const char *found = strstr(text, line);
    assert_non_null(found);
    return found + strlen(line);
}

/* The value of an entry of a block, such as ("Cr", "m1(%4d,%4d,%4d)", 1, 2, 3); 0 if it is not
 * there. */
static inline double test_sid_entry(const char *text, const char *block, const char *format, int i,
                                    int j, int k)
{
    char entry[40], end[64], number[64] = "";
    const char *from = test_sid_block(text, block);
    snprintf(end, sizeof end, "\n           end %s\n", block);
    if (strncmp(format, "m0", 2) == 0)
        snprintf(entry, sizeof entry, "m0(%4d,%4d)", i, j);
    else
        snprintf(entry, sizeof entry, "m1(%4d,%4d,%4d)", i, j, k);
    const char *stop = strstr(from - 1, end), *found = strstr(from, entry);
    assert_non_null(stop);
    if (!found || found > stop) return 0.0;
    found = strchr(found, '=') + 1;
    memcpy(number, found, strcspn(found, "\n"));
    for (char *c = number; *c; ++c) {
        if (*c == 'D') *c = 'E';
    }
    return strtod(number, NULL);
}

/* A copy of the text in which the entries of a block that begin with `order` ("m0", "m1") are
 * multiplied. */
static inline char *test_sid_scaled(const char *text, const char *block, const char *order,
                                    double factor)
{
    char end[64];
    const char *from = test_sid_block(text, block);
    char *copy = calloc(2, strlen(text) + 1), *to = copy;
    snprintf(end, sizeof end, "           end %s\n", block);
    memcpy(to, text, (size_t)(from - text));
    to += from - text;
    while (strncmp(from, end, strlen(end)) != 0) {
        const size_t length = strcspn(from, "\n") + 1, blanks = strspn(from, " ");
        if (strncmp(from + blanks, order, 2) == 0) {
            char number[64] = "";
            const size_t head = strcspn(from, "=") + 1;
            memcpy(number, from + head, length - head);
            for (char *c = number; *c; ++c) {
                if (*c == 'D') *c = 'E';
            }
            memcpy(to, from, head);
            to += head;
            to += sprintf(to, " %.17g\n", factor * strtod(number, NULL));
        } else {
            memcpy(to, from, length);
            to += length;
        }
        from += length;
    }
    strcpy(to, from);
    return copy;
}

#endif
