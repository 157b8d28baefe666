/* Surfaces of triangles: from STL, OBJ, MSH and lists of numbers, and what they enclose.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MESH_H
#define MBSRI_FILES_MESH_H

#include "files/arena.h"

#include <mbsrank/joint.h>

/* A triangle by its corners, as 32-bit numbers hold them. */
typedef struct mbsri_triangle {
    double corner[3][3];
} mbsri_triangle;

/* The triangles of a file, behind those that are there. The kind is told by the contents, and by
 * the name for MSH: STL with numbers or as bytes, else OBJ, whose faces may have more than three
 * corners; of points without faces it is their convex hull. NULL, or why there are none. */
const char *mbsri_mesh_read(mbsri_arena *arena, const char *text, size_t size, const char *name,
                            mbsri_list *triangles);

/* The same of lists of numbers: points, and for each triangle the numbers of three of them, from 0
 * (NULL: the hull). */
const char *mbsri_mesh_of_numbers(mbsri_arena *arena, const char *points, const char *faces,
                                  mbsri_list *triangles);

/* Where its points go: x = scale R^T (x - origin). */
typedef struct mbsri_mesh_place {
    double scale[3];
    mbsr_frame reference; /* R and the origin */
} mbsri_mesh_place;

typedef enum mbsri_mesh_inertia {
    MBSRI_MESH_LEGACY, /* pyramids under all triangles count as mass */
    MBSRI_MESH_EXACT,  /* of the closed surface */
    MBSRI_MESH_SHELL   /* of the surface itself */
} mbsri_mesh_inertia;

/* At density 1: volume (m^3), or of a shell its area (m^2); centre; tensor about it (xx, yy, zz,
 * xy, xz, yz). */
typedef struct mbsri_mesh_solid {
    double volume, centre[3], tensor[6];
} mbsri_mesh_solid;

/* Moves the triangles to their place; those that it mirrors are turned over. */
void mbsri_mesh_move(const mbsri_list *triangles, const mbsri_mesh_place *place);

/* NULL, or why there is none. */
const char *mbsri_mesh_measure(const mbsri_list *triangles, mbsri_mesh_inertia kind,
                               mbsri_mesh_solid *solid);

/* The convex hull of points, three numbers each. NULL, or why there is none. */
const char *mbsri_mesh_hull(mbsri_arena *arena, const double *points, int count,
                            mbsri_list *triangles);

/* The box around them along the axes of a frame. */
void mbsri_mesh_bounds(const mbsri_list *triangles, const mbsr_frame *frame, double lower[3],
                       double upper[3]);

#endif
