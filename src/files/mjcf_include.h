/* Files that a file of MJCF names.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MJCF_INCLUDE_H
#define MBSRI_FILES_MJCF_INCLUDE_H

#include "files/scene.h"

/* Another file of XML, which element e names, by a path that stays valid; NULL: refused, or no
 * memory. */
mbsri_element *mbsri_mjcf_load(mbsri_scene *s, const mbsri_element *e, const char *path);

/* In the place of each <include> in a tree what is in that file, seen from a folder. */
bool mbsri_mjcf_include(mbsri_scene *s, mbsri_element *root, const char *folder);

#endif
