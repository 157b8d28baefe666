/* What joints carry, as drawn.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_WEIGHTS_H
#define MBSRI_FILES_WEIGHTS_H

#include "files/scene.h"

/* What the coordinate of a joint moves as drawn, all others held. */
typedef struct mbsri_weight {
    double mass; /* kg or kg m^2, with its armature: the diagonal of the mass matrix */
    double load; /* the most that weight does at 1 m/s^2: N or N m */
} mbsri_weight;

/* For each joint of the scene; of those without one axis zeros. NULL: no memory. */
const mbsri_weight *mbsri_scene_weights(const mbsri_scene *s);

#endif
