/* Numbers by name.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_NAMES_H
#define MBSRI_FILES_NAMES_H

#include "files/arena.h"

typedef struct mbsri_name {
    const char *name; /* NULL: free */
    int number;
} mbsri_name;

/* A table with open addressing; zeros: an empty one. */
typedef struct mbsri_names {
    mbsri_name *slot;
    size_t room, count;
} mbsri_names;

/* -1: there is none; name may be NULL. */
int mbsri_names_find(const mbsri_names *names, const char *name);

/* The name as it was added; NULL: there is none. */
const char *mbsri_names_same(const mbsri_names *names, const char *name);

/* A name that is not there; it must stay valid. False: no memory. */
bool mbsri_names_add(mbsri_arena *arena, mbsri_names *names, const char *name, int number);

#endif
