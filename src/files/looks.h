/* Elements that others name: materials, textures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_LOOKS_H
#define MBSRI_FILES_LOOKS_H

#include "files/names.h"
#include "files/xml.h"

/* By their names; the first of a name counts. Zeros: none. */
typedef struct mbsri_looks {
    mbsri_names names;
    mbsri_list elements;
} mbsri_looks;

/* Adds it, unless it has no name. False: no memory. */
bool mbsri_looks_keep(mbsri_arena *arena, const mbsri_element *e, mbsri_looks *to);

/* NULL: there is none of that name, which may be NULL. */
const mbsri_element *mbsri_looks_find(const mbsri_looks *looks, const char *name);

#endif
