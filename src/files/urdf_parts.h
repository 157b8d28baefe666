/* What the parts of the reader of URDF share, and that of SDF.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_URDF_PARTS_H
#define MBSRI_FILES_URDF_PARTS_H

#include "files/scene.h"

/* The place that xyz and rpy of an element give; e may be NULL: the identity. Refusals name `of`.
 */
bool mbsri_urdf_place(mbsri_scene *s, const mbsri_element *of, const mbsri_element *e,
                      mbsr_frame *frame);

/* The frame of x and angles of roll, pitch and yaw. */
mbsr_frame mbsri_rpy_frame(const double x[3], const double rpy[3]);

/* The path of a mesh: file:// is left out, and what package:// or model:// names has the folder of
 * its package where that is known. name may be NULL; NULL: no memory, or no name. */
const char *mbsri_package_path(mbsri_scene *s, const char *name);

/* A joint of the scene with the name of an element; NULL: no memory. */
mbsri_scene_joint *mbsri_urdf_joint(mbsri_scene *s, const mbsri_element *e,
                                    mbsr_file_joint_kind kind, const double axis[3]);

/* Loops and couplings, which stand beside links and joints, once the tree is there. */
bool mbsri_urdf_loops(mbsri_scene *s, const mbsri_element *root);

#endif
