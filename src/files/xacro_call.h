/* A call of a function in an expression of xacro, and what it is given.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_CALL_H
#define MBSRI_FILES_XACRO_CALL_H

#include "files/xacro_value.h"

typedef struct mbsri_macro_call {
    const struct mbsri_function *function;
    const mbsri_value *self; /* of a method */
    const mbsri_value *argument;
    const char *const *keyword; /* of each argument, NULL without */
    int count;
} mbsri_macro_call;

typedef enum mbsri_module {
    MBSRI_EVERYWHERE = 1, /* without a module's name */
    MBSRI_MATH = 2,
    MBSRI_PYTHON = 4,
    MBSRI_XACRO = 8
} mbsri_module;

typedef struct mbsri_function {
    const char *name;
    int where;                                                                 /* modules, added */
    int least, most;                                                           /* arguments */
    bool (*call)(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out); /* false: refused */
    double (*one)(double);
    double (*two)(double, double);
} mbsri_function;

/* The function of a table that has this name and is in one of these modules (0: whatever module);
 * NULL: none. */
const mbsri_function *mbsri_function_find(const mbsri_function *table, size_t count, int where,
                                          const char *name);

/* Argument k as a number or string; and what argument 0 consists of, a sequence, a string or the
 * keys of a dictionary, as a list. False: refused. */
bool mbsri_call_number(mbsri_xacro *x, const mbsri_macro_call *c, int k, double *number);
bool mbsri_call_string(mbsri_xacro *x, const mbsri_macro_call *c, int k, const char **string);
bool mbsri_call_items(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out);

/* Says what argument k is. Always false. */
bool mbsri_call_refuse(mbsri_xacro *x, const mbsri_macro_call *c, int k);

#endif
