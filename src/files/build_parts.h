/* What the parts share that make a model of a scene.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_BUILD_PARTS_H
#define MBSRI_FILES_BUILD_PARTS_H

#include "files/elements.h"
#include "files/scene.h"

/* Of the model, told with the element. Always false. */
bool mbsri_scene_refused(mbsri_scene *s, const mbsri_element *e, const mbsr_model *model);

/* Frames of all bodies in the world, as drawn; NULL: no memory. */
mbsr_frame *mbsri_scene_drawn(const mbsri_scene *s);

bool mbsri_scene_force(mbsri_scene *s, mbsr_file *file, mbsr_force_def def, const mbsri_element *e,
                       int *id);

/* A law on gear times a sum over joints. */
bool mbsri_scene_sum_force(mbsri_scene *s, mbsr_file *file, const mbsri_scene_sum *sum, double gear,
                           const mbsri_file_law *law, const mbsri_element *e, int *id);

/* Lengths of rest of tendons along sites, while sites are on bodies as drawn. */
bool mbsri_scene_settle(mbsri_scene *s);

/* Stiffness and slip of joints, as the options want them: into the joints. */
bool mbsri_scene_limits(mbsri_scene *s);

/* All force elements; those of actuators. */
bool mbsri_scene_forces(mbsri_scene *s, mbsr_file *file, const mbsri_element *root);
bool mbsri_scene_actuators(mbsri_scene *s, mbsr_file *file);

#endif
