/* Scopes of xacro with their properties and macros, and texts with ${...} and $(...).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A scope is the file's, a namespace's or a call's of a macro. It sees what the scopes around it
 * have, which are those of the call, not of the definition. A property is evaluated when it is used
 * first, in the scope where it stands. */
#ifndef MBSRI_FILES_XACRO_SCOPE_H
#define MBSRI_FILES_XACRO_SCOPE_H

#include "files/names.h"
#include "files/xacro_value.h"

typedef struct mbsri_scope {
    struct mbsri_scope *parent;
    bool is_namespace;
    mbsri_names names, macro_names;
    mbsri_list properties, macros; /* of macros: const struct mbsri_macro * */
} mbsri_scope;

/* A scope within another; NULL: refused. */
mbsri_scope *mbsri_scope_open(mbsri_xacro *x, mbsri_scope *parent, bool is_namespace);

/* Numbers a name that is not there; false: refused. */
bool mbsri_scope_name(mbsri_xacro *x, mbsri_names *names, const char *name, int number);

/* A property; `lazy`: its text is evaluated when it is used. Blocks are under "*name" and "**name".
 * False: refused. */
bool mbsri_scope_set(mbsri_xacro *x, mbsri_scope *scope, const char *name, const mbsri_value *value,
                     bool lazy);

/* Whether a name is there, and its value: 1 found, 0 not there, -1 refused. */
bool mbsri_scope_has(const mbsri_scope *scope, const char *name);
int mbsri_scope_find(mbsri_xacro *x, mbsri_scope *scope, const char *name, mbsri_value *value);

/* From this scope and all around it. */
void mbsri_scope_remove(mbsri_scope *scope, const char *name);

/* The value of a text: of ${...} alone of any kind, else a string. False: refused. */
bool mbsri_xacro_value(mbsri_xacro *x, mbsri_scope *scope, const char *text, mbsri_value *value);

/* The same as a string; NULL: refused. */
const char *mbsri_xacro_text(mbsri_xacro *x, mbsri_scope *scope, const char *text);

#endif
