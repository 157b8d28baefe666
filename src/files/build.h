/* The model of a scene.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_BUILD_H
#define MBSRI_FILES_BUILD_H

#include "files/scene.h"

/* What was read, with its memory. */
typedef struct mbsri_file {
    mbsr_file file; /* first */
    mbsri_arena arena;
    mbsri_list names; /* const char *, by id */
} mbsri_file;

/* Bodies, forces, closures and states of the scene into the file's model; false: refused, or no
 * memory. */
bool mbsri_scene_build(mbsri_scene *s, mbsr_file *file, const mbsri_element *root);

#endif
