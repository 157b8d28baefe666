/* YAML as files of robots have it, as values: maps, lists (in blocks and in brackets), scalars on
 * one line, comments, anchors, and the units of xacro such as !degrees.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_YAML_H
#define MBSRI_FILES_XACRO_YAML_H

#include "files/xacro_value.h"

/* The value of a text; `name` is its file's and stays. False: refused with its line: texts over
 * several lines, merged maps, other tags, several documents. Scalars are of the types that YAML 1.1
 * gives them: 1e5 without a point is a string. */
bool mbsri_yaml_read(mbsri_xacro *x, const char *text, size_t size, const char *name,
                     mbsri_value *value);

#endif
