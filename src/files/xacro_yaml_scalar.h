/* Scalars of YAML.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_YAML_SCALAR_H
#define MBSRI_FILES_XACRO_YAML_SCALAR_H

#include "files/xacro_value.h"

/* A text without the quotes at its two ends; NULL: refused. */
const char *mbsri_yaml_unquote(mbsri_xacro *x, const char *from, const char *to);

/* The type of a scalar without quotes, by YAML 1.1. False: refused. */
bool mbsri_yaml_resolve(mbsri_xacro *x, const char *text, mbsri_value *value);

/* What a tag such as !degrees makes of an expression: rad or m. False: refused. */
bool mbsri_yaml_unit(mbsri_xacro *x, const char *tag, size_t length, const char *text,
                     mbsri_value *value);

#endif
