/* Numbers in texts, whatever the locale.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_NUMBERS_H
#define MBSRI_FILES_NUMBERS_H

#include <stdbool.h>

/* A decimal number at *text, which moves behind it and behind white space; false: there is none, or
 * it is beyond what a double holds. NaN and infinity are none. */
bool mbsri_read_number(const char **text, double *value);

/* Exactly `least` to `most` numbers and nothing else; returns how many, -1: not so. */
int mbsri_read_numbers(const char *text, int least, int most, double *values);

/* A whole number alone. */
bool mbsri_read_integer(const char *text, int *value);

/* A decimal digit. */
static inline bool mbsri_is_digit(char c)
{
    return c >= '0' && c <= '9';
}

#endif
