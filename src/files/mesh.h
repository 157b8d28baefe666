/* Surfaces of triangles, from STL and OBJ.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MESH_H
#define MBSRI_FILES_MESH_H

#include "files/arena.h"

#include <mbsrank/files.h>

/* Its triangles one after the other, as mbsr_mesh_triangles says. NULL, or why they end. */
const char *mbsri_mesh_read(mbsri_arena *arena, const char *text, size_t size,
                            mbsr_triangle_fn take, void *user);

/* What a closed surface encloses, at density 1: volume (m^3), its centre and the tensor about it (xx, yy,
 * zz, xy, xz, yz), with coordinates times scale. NULL, or why there is none. */
const char *mbsri_mesh_solid(mbsri_arena *arena, const char *text, size_t size,
                             const double scale[3], double *volume, double centre[3],
                             double tensor[6]);

#endif
