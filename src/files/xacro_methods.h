/* Methods of strings and dictionaries in expressions of xacro.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_METHODS_H
#define MBSRI_FILES_XACRO_METHODS_H

#include "files/xacro_call.h"

/* A method of a value, which must stay; false: it has none of this name. */
bool mbsri_method_find(const mbsri_value *self, const char *name, mbsri_value *value);

#endif
