/* Shapes that are near each other.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_NEAR_H
#define MBSRI_CONTACT_NEAR_H

#include "contact/touch.h"

/* The box around a shape, along the world's axes, and the radius of a ball about its middle. */
typedef struct mbsri_box {
    double low[3], high[3], ball;
    int shape;
    int first[2], last[2]; /* columns of the grid that it reaches into (near.c) */
} mbsri_box;

/* Columns that a shape is in, on average at most. */
enum { MBSRI_NEAR_ENTRIES = 4 };

/* What the element keeps in the memory of a data object. */
typedef struct mbsri_near {
    mbsri_placed *placed; /* by shape */
    int *order;     /* shapes but those of the ground alone, by where they begin along an axis */
    mbsri_box *box; /* of those, in that order, side by side in memory */
    const mbsri_box **entry; /* boxes by the columns that they are in, and in each in that order */
    int (*pair)[2];          /* of shapes, a < b, in ascending order */
    int (*spare)[2];
    int *start;
    int *kept; /* whether the order is one; the axis */
} mbsri_near;

/* Bytes; where the parts stand in them. */
size_t mbsri_near_place(const mbsr_contacts *c, void *memory, mbsri_near *near);

/* Places all shapes, and finds the pairs whose boxes and balls overlap and that may touch; args:
 * all bodies. A status, with a text. */
int mbsri_near_find(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near,
                    int *count);

/* Sorts pairs by both numbers, which are below `numbers`. */
void mbsri_near_sort(mbsri_near *near, int numbers, int count);

/* Places one shape on its body. */
void mbsri_near_put(const mbsri_shape *shape, const mbsr_force_body *body, mbsri_placed *placed);

#endif
