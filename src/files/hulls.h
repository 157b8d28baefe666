/* Convex hulls of meshes that touch.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_HULLS_H
#define MBSRI_FILES_HULLS_H

#include "files/scene.h"

/* Gives a mesh for contact its hull, where options ask for one; a finding at `e` says why it has
 * none. False: no memory. */
bool mbsri_hull_shape(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape);

#endif
