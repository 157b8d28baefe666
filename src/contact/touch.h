/* Points at which two shapes touch, and how they move with the bodies.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Every point is that of two features, one of each core: a corner, an edge, a face, a circle. Which
 * features are held against each other does not depend on how they lie: all corners against the
 * nearest point of the other core, all edges against all edges, with a weight that fades where
 * edges become parallel or end, or the normal turns into a face beside them. So points neither jump
 * nor come and go, but with their depth or weight at zero. */
#ifndef MBSRI_CONTACT_TOUCH_H
#define MBSRI_CONTACT_TOUCH_H

#include "contact/point.h"

void mbsri_place_shape(const mbsri_shape *shape, const double R[9], const double x[3],
                       mbsri_placed *placed);

/* Weight of two edges beside those of their ends and angle: 1 while the normal points out of both
 * faces of each, 0 from 30 degrees beyond on; where the edges have passed each other, 0 as soon as
 * neither point is in the other core, and when they are deeper in each other than both radii.
 * slopes (6; NULL: not asked for): by the products of the normal (of a: against it) with into_a and
 * into_b, by s and by height. */
double mbsri_edges_weight(const mbsri_touch *t, double *slopes);

/* Calls `touch` for every point with a depth and a weight above zero; depths count from where both
 * surfaces are `margin` apart. */
typedef int (*mbsri_touch_fn)(void *user, const mbsri_touch *touch);
int mbsri_touches(const mbsri_placed *a, const mbsri_placed *b, double margin, mbsri_touch_fn touch,
                  void *user);

/* How a point moves with small motions of both bodies: a rotation and a velocity each, at pa and
 * pb. */
typedef struct mbsri_motion {
    double wa[3], va[3], wb[3], vb[3];
} mbsri_motion;

typedef struct mbsri_touch_change {
    double n[3], p[3]; /* changes of normal and point, p the middle of both surfaces, */
    double depth, weight;
    double axis[3], cosine; /* of ta and n . ta, where the weight depends on it */
} mbsri_touch_change;

void mbsri_touch_moves(const mbsri_touch *t, const mbsri_motion *by, mbsri_touch_change *moved);

/* The middle of both surfaces. */
void mbsri_touch_point(const mbsri_touch *t, double p[3]);

#endif
