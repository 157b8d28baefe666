/* Convex hulls of points.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MESH_HULL_H
#define MBSRI_FILES_MESH_HULL_H

#include "files/arena.h"

/* A triangle of a hull by the numbers of its points, seen from outside the other way round than a
 * clock. */
typedef struct mbsri_hull_side {
    int corner[3];
} mbsri_hull_side;

/* The convex hull of points, three numbers each, into a list of mbsri_hull_side. most = 0: all of
 * it. Else it has at most that many corners (4 or more): those that lie farthest outside of the
 * others, until none is farther than a thousandth of the size. NULL, or why there is none. */
const char *mbsri_hull(mbsri_arena *arena, const double *points, int count, int most,
                       mbsri_list *sides);

#endif
