/* A function that expressions of xacro call.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_FUNCTION_H
#define MBSRI_FILES_XACRO_FUNCTION_H

#include "files/xacro_value.h"

typedef struct mbsri_call {
    const struct mbsri_function *function;
    const mbsri_value *self; /* of a method */
    const mbsri_value *argument;
    const char *const *keyword; /* of each argument, NULL without */
    int count;
} mbsri_call;

typedef enum mbsri_module {
    MBSRI_EVERYWHERE = 1, /* without a module's name */
    MBSRI_MATH = 2,
    MBSRI_PYTHON = 4,
    MBSRI_XACRO = 8
} mbsri_module;

typedef struct mbsri_function {
    const char *name;
    int where;                                                           /* modules, added */
    int least, most;                                                     /* arguments */
    bool (*call)(mbsri_xacro *x, const mbsri_call *c, mbsri_value *out); /* false: refused */
    double (*one)(double);
    double (*two)(double, double);
} mbsri_function;

#endif
