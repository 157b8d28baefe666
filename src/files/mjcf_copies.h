/* Elements of MJCF under other names: replicas, attached models.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MJCF_COPIES_H
#define MBSRI_FILES_MJCF_COPIES_H

#include "files/mjcf_parts.h"

typedef struct mbsri_copies mbsri_copies;

/* The value of an attribute in the copy of an element; NULL: no memory. */
typedef const char *mbsri_rename_fn(mbsri_copies *c, const mbsri_element *e, const char *attribute,
                                    const char *value);

struct mbsri_copies {
    mbsri_mjcf *m;
    mbsri_rename_fn *rename;
    void *user;        /* for rename */
    mbsri_names names; /* "kind name" of what is copied */
};

/* Enters an element of that kind; all that stand in one. False: no memory. */
bool mbsri_copies_enter(mbsri_copies *c, const char *kind, const mbsri_element *e);
bool mbsri_copies_enter_all(mbsri_copies *c, const mbsri_element *e);

/* The kind of what an attribute of other sections names; NULL: it names nothing. */
const char *mbsri_copies_kind(const char *attribute);

/* Whether an attribute names something that was entered. */
bool mbsri_copies_know(mbsri_copies *c, const char *attribute, const char *value);

/* With all that stands in it; NULL: refused (there are too many), or no memory. */
mbsri_element *mbsri_copy_element(mbsri_copies *c, const mbsri_element *e);

#endif
