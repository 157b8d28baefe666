/* Macros of xacro: their definitions, and what a call gives them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_MACRO_H
#define MBSRI_FILES_XACRO_MACRO_H

#include "files/xacro_scope.h"

/* name, name:=default, name:=^ (the caller's property of this name), name:=^|default, *name (an
 * element), **name (what is in an element). */
typedef struct mbsri_macro_parameter {
    const char *name;
    const char *standard; /* text; NULL: none */
    bool forwarded;
} mbsri_macro_parameter;

typedef struct mbsri_macro {
    const mbsri_element *body;
    mbsri_list parameters;
} mbsri_macro;

/* A definition into a scope; false: refused. */
bool mbsri_macro_define(mbsri_xacro *x, const mbsri_element *e, mbsri_scope *scope);

/* The macro that a call means, and the scope it is called in: that of a namespace where the name
 * has one. NULL: refused. */
const mbsri_macro *mbsri_macro_find(mbsri_xacro *x, const char *name, mbsri_scope **scope);

/* The scope of a call with the parameters in it. Attributes are those of `e` but for `without`,
 * blocks the children of `blocks` in turn. NULL: refused. */
mbsri_scope *mbsri_macro_open(mbsri_xacro *x, const mbsri_macro *macro, const mbsri_element *e,
                              const char *without, const mbsri_element *blocks, mbsri_scope *scope);

#endif
