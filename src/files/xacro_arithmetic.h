/* Operators of expressions of xacro, and the functions of Python's module math.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_ARITHMETIC_H
#define MBSRI_FILES_XACRO_ARITHMETIC_H

#include "files/xacro_call.h"

/* "+", "-", "*", "/", "//", "%", "**". Whole numbers have 64 bits, beyond which they are refused,
 * as is what is not finite though its operands are. False: refused. */
bool mbsri_arithmetic(mbsri_xacro *x, const char *mark, const mbsri_value *a, const mbsri_value *b,
                      mbsri_value *out);

/* Members of math: functions and constants. */
bool mbsri_math_find(const char *name, mbsri_value *value);

/* A real number as a whole one, rounded by `round`; false: refused. */
bool mbsri_make_whole(mbsri_xacro *x, double real, double (*round)(double), mbsri_value *out);

#endif
