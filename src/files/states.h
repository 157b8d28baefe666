/* States of a file.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_STATES_H
#define MBSRI_FILES_STATES_H

#include "files/scene.h"

/* Joints with their coordinates, the pose as drawn and the keys; sizes of q and u. */
bool mbsri_scene_states(mbsri_scene *s, mbsr_file *file);

#endif
