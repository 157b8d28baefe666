/* The elements of a file of xacro, expanded.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_XACRO_EXPAND_H
#define MBSRI_FILES_XACRO_EXPAND_H

#include "files/scene.h"

/* Whether a file is one of xacro: its root declares the prefix xacro, or its name ends so. */
bool mbsri_xacro_is(const mbsri_element *root);

/* The tree without xacro, whose elements keep file and line of what they come from; NULL: refused,
 * or no memory. Texts between elements do not count, here as in xml.h. */
mbsri_element *mbsri_xacro_expand(mbsri_scene *s, const mbsri_element *root);

#endif
