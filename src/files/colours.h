/* Colours of shapes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_COLOURS_H
#define MBSRI_FILES_COLOURS_H

#include "files/mjcf_parts.h"

/* URDF: the materials with a colour of the robot, then those of its visuals, which others may name.
 * False: no memory. */
bool mbsri_urdf_looks(mbsri_scene *s, const mbsri_element *robot, mbsri_looks *materials);

/* Of a visual or collision: its own <material>, else the one that it names. False: refused. */
bool mbsri_urdf_colour(mbsri_scene *s, const mbsri_element *e, const mbsri_looks *materials,
                       mbsr_file_shape *shape);

/* MJCF: the children of that kind of a list of assets. False: no memory. */
bool mbsri_mjcf_looks(mbsri_scene *s, const mbsri_element *list, const char *kind, mbsri_looks *to);

/* Of a geom: rgba, else its material's, times the first colour of a texture that is computed.
 * False: refused. */
bool mbsri_mjcf_colour(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape);

#endif
