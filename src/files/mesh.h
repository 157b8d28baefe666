/* Surfaces of triangles, from STL and OBJ.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MESH_H
#define MBSRI_FILES_MESH_H

#include "files/arena.h"

/* What a closed surface encloses, at density 1: volume (m^3), its centre and the tensor about it (xx, yy,
 * zz, xy, xz, yz), with coordinates times scale. The kind is told by the contents: STL with numbers or as
 * bytes, else OBJ, whose faces may have more than three corners. NULL, or why there is none. */
const char *mbsri_mesh_solid(mbsri_arena *arena, const char *text, size_t size,
                             const double scale[3], double *volume, double centre[3],
                             double tensor[6]);

#endif
