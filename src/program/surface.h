/* Meshes in a page.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_SURFACE_H
#define MBSRANK_SURFACE_H

#include <mbsrank/base.h>

#include <stdio.h>

/* An object of JSON: Collada stays as it is, under "collada"; the triangles of all others go, under
 * "surface", into some 8 bytes each (surface.c). The object is written in any case, empty on
 * failure: then a status, and the text of *error says of mesh `name` why. */
int put_mesh(FILE *to, const char *name, const char *text, size_t size, mbsr_error *error);

/* The same of triangles, 9 numbers each. */
int put_triangles(FILE *to, const char *name, int count, const double *triangle, mbsr_error *error);

#endif
