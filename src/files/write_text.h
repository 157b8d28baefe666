/* A text of XML that grows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_WRITE_TEXT_H
#define MBSRI_FILES_WRITE_TEXT_H

#include "files/arena.h"

/* Zeros but for the arena: an empty one. Where there is no memory the arena has failed. */
typedef struct mbsri_text {
    mbsri_arena *arena;
    char *data; /* with a NUL behind it */
    size_t size, room;
    int depth; /* elements that are open */
} mbsri_text;

/* As it stands. */
void mbsri_put(mbsri_text *t, const char *s, size_t length);

/* An element on a line of its own: mbsri_begin, attributes, then mbsri_end if there is nothing in
 * it, or mbsri_into, what is in it, and mbsri_out. */
void mbsri_begin(mbsri_text *t, const char *element);
void mbsri_end(mbsri_text *t);
void mbsri_into(mbsri_text *t);
void mbsri_out(mbsri_text *t, const char *element);

/* Attributes; by mbsri_set_text a value that is NULL or "" is left out. Numbers have 17 digits, and
 * a point whatever the locale. */
void mbsri_set_attribute(mbsri_text *t, const char *name, const char *value);
void mbsri_set_text(mbsri_text *t, const char *name, const char *value);
void mbsri_set_numbers(mbsri_text *t, const char *name, int n, const double *values);
void mbsri_set_number(mbsri_text *t, const char *name, double value);

#endif
