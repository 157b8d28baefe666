/* A file of XML as a tree of elements with attributes; texts count where there are no elements
 * beside them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XML_H
#define MBSRI_FILES_XML_H

#include "files/arena.h"

typedef struct mbsri_element {
    const char *name;
    const char *file;
    int line;
    int model; /* which of the models that a file of MJCF attaches; 0: the file's own */
    const char **attribute; /* names and values in turn, then NULL */
    const char *text;       /* of one without children, with more than white space; else NULL */
    struct mbsri_element *parent, *child, *last, *next;
} mbsri_element;

/* What limits a file: none in use comes near. Elements in each other; bytes in all. */
enum { MBSRI_XML_DEPTH = 1000, MBSRI_XML_SIZE = 1 << 30 };

/* The tree of a text; NULL: text tells why (file, line), or the arena has failed. Entities of the
 * file's own are refused. */
mbsri_element *mbsri_xml_read(mbsri_arena *arena, const char *bytes, size_t size, const char *name,
                              char message[MBSR_TEXT_SIZE]);

/* The value of an attribute; NULL: there is none. */
const char *mbsri_attribute(const mbsri_element *e, const char *name);

/* The first child of that name, and the next sibling of the same. NULL: none. e may be NULL. */
const mbsri_element *mbsri_child(const mbsri_element *e, const char *name);
const mbsri_element *mbsri_next(const mbsri_element *e);

/* The text of the first child of that name; NULL: there is none. */
const char *mbsri_text_of(const mbsri_element *e, const char *name);

/* Whether it has that name. */
bool mbsri_is(const mbsri_element *e, const char *name);

#endif
