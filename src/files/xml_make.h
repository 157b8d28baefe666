/* Elements of XML that are made, not read: copies, replicas, what stands for a composite.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XML_MAKE_H
#define MBSRI_FILES_XML_MAKE_H

#include "files/xml.h"

/* One of that name from the place of another one, alone and without attributes; NULL: no memory. */
mbsri_element *mbsri_element_like(mbsri_arena *arena, const mbsri_element *e, const char *name);

/* Gives it an attribute, in the place of one of that name; neither text is copied. False: no
 * memory. */
bool mbsri_element_set(mbsri_arena *arena, mbsri_element *e, const char *name, const char *value);

/* The same with numbers of 17 digits. */
bool mbsri_element_set_numbers(mbsri_arena *arena, mbsri_element *e, const char *name, int count,
                               const double *x);

/* Behind the last child. */
void mbsri_append(mbsri_element *parent, mbsri_element *e);

/* In the place of child `old`, of which `before` is the sibling in front (NULL: none), the children
 * of `list`, of which there are some; returns the last of them. */
mbsri_element *mbsri_put_in_place(mbsri_element *parent, mbsri_element *before, mbsri_element *old,
                                  mbsri_element *list);

#endif
