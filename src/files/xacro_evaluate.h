/* The value of an expression of xacro.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_EVALUATE_H
#define MBSRI_FILES_XACRO_EVALUATE_H

#include "files/xacro_value.h"

/* Names are those of the scope, then those that xacro offers; without a scope the latter alone.
 * False: refused. */
bool mbsri_xacro_evaluate(mbsri_xacro *x, struct mbsri_scope *scope, const char *text,
                          mbsri_value *value);

#endif
