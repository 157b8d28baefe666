/* What the parts of the reader of URDF share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_URDF_PARTS_H
#define MBSRI_FILES_URDF_PARTS_H

#include "files/scene.h"

/* The place that xyz and rpy of an element give; e may be NULL: the identity. Refusals name `of`. */
bool mbsri_urdf_place(mbsri_scene *s, const mbsri_element *of, const mbsri_element *e,
                      mbsr_frame *frame);

/* Loops and couplings, which stand beside links and joints, once the tree is there. */
bool mbsri_urdf_loops(mbsri_scene *s, const mbsri_element *root);

#endif
