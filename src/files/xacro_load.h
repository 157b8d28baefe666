/* Other files of an expansion of xacro.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_LOAD_H
#define MBSRI_FILES_XACRO_LOAD_H

#include "files/xacro_value.h"

/* The root of an included file, which is read once; NULL where it is missing and optional. A path
 * that leaves the model's folder and those of the packages is refused, unless option `outside`
 * allows it, by its text: links of the file system are not seen. False: refused. */
bool mbsri_xacro_include(mbsri_xacro *x, const char *path, bool optional,
                         const mbsri_element **root);

/* What a file of YAML says; false: refused. */
bool mbsri_xacro_load_yaml(mbsri_xacro *x, const char *path, mbsri_value *value);

#endif
