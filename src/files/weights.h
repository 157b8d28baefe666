/* What joints carry, as drawn.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_WEIGHTS_H
#define MBSRI_FILES_WEIGHTS_H

#include "files/scene.h"

/* For each joint of the scene the mass that its coordinate moves, all others held, with its armature: the diagonal of the
 * mass matrix as drawn, kg or kg m^2; of joints without one axis 0. NULL: no memory. */
const double *mbsri_scene_weights(const mbsri_scene *s);

#endif
