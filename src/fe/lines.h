/* Texts line by line, word by word.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_LINES_H
#define MBSRI_FE_LINES_H

#include <mbsrank/base.h>

#include <stdbool.h>

enum { MBSRI_WORD = 128 };

typedef struct mbsri_lines {
    const char *text, *end;  /* what follows the line, and where the text ends */
    const char *word, *stop; /* what follows in the line, and where that ends */
    const char *file;        /* for error texts */
    int line;                /* from 1 */
    char comment;            /* lines that begin with it are left out */
    mbsr_error *error;
} mbsri_lines;

/* The next line that is neither empty nor a comment; false: there is none. */
bool mbsri_next_line(mbsri_lines *lines);

/* The next word of the line, words being separated by blanks and commas; one that is too long is
 * cut. */
bool mbsri_next_word(mbsri_lines *lines, char word[MBSRI_WORD]);

/* Numbers of the line; false: there is none that is finite (then an error text has been written).
 */
bool mbsri_next_number(mbsri_lines *lines, const char *what, double *value);
bool mbsri_next_integer(mbsri_lines *lines, const char *what, int *value);

/* Whether the line ends here, with an error text if not. */
bool mbsri_line_ends(mbsri_lines *lines);

/* Whether two words are the same but for upper and lower case. */
bool mbsri_same_word(const char *a, const char *b);

/* Writes "file:line: ..." and returns MBSR_ERR_FILE. */
int mbsri_refuse_line(const mbsri_lines *lines, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
