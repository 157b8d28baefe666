/* What expressions of xacro may call beside math: functions of Python and of xacro.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_FUNCTIONS_H
#define MBSRI_FILES_XACRO_FUNCTIONS_H

#include "files/xacro_call.h"

/* What a name means that no property has: a function, a constant, a module; false: nothing. */
bool mbsri_global_find(const char *name, mbsri_value *value);

/* What a module has under a name; false: nothing. */
bool mbsri_module_find(int module, const char *name, mbsri_value *value);

#endif
