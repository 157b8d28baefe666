/* Points at which two shapes touch, and how they move with the bodies.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Every point is that of two features, one of each core: a corner, an edge, a face, a circle. Which
 * features are held against each other does not depend on how they lie: all corners against the
 * nearest point of the other core, all edges against all edges, with a weight that fades where
 * edges become parallel or end. So points neither jump nor come and go, but with their depth or
 * weight at zero. */
#ifndef MBSRI_CONTACT_TOUCH_H
#define MBSRI_CONTACT_TOUCH_H

#include "contact/record.h"

/* A shape where it stands in the world. */
typedef struct mbsri_placed {
    const mbsri_shape *shape;
    double R[9], x[3];
    double low[3], high[3];
} mbsri_placed;

void mbsri_place_shape(const mbsri_shape *shape, const double R[9], const double x[3],
                       mbsri_placed *placed);

/* What the two features are. */
typedef enum mbsri_features {
    MBSRI_POINT_PLANE, /* of a over a face of b */
    MBSRI_POINT_POINT,
    MBSRI_POINT_LINE,
    MBSRI_LINE_LINE,
    MBSRI_POINT_CIRCLE, /* of a at a rim of b */
    MBSRI_RIM_PLANE,    /* the lowest point of a rim of a over a plane b */
    MBSRI_ELLIPSOID_PLANE
} mbsri_features;

/* One point. Where the features were found the other way round, a and b are exchanged (`turned`),
 * so that the names of the features fit. */
typedef struct mbsri_touch {
    mbsri_features features;
    bool turned;
    double n[3];         /* unit, from b to a */
    double s;            /* n . (pa - pb) */
    double pa[3], pb[3]; /* of the cores */
    double ra, rb;       /* how far the surfaces are before these */
    double depth, weight;
    double ta[3], tb[3]; /* directions of lines; axis and middle of a rim or circle; middle of an
                            ellipsoid in pa - ta */
    double ua, ub;       /* LINE_LINE: places along the edges, 0 .. 1, and */
    double la, lb;       /* their lengths */
    double window;       /* where weights fade at the ends, m */
    double half[3],
        Ra[9]; /* ELLIPSOID_PLANE: half axes and axes; radius of a rim or circle in half[0] */
    double by_cosine, curve; /* first and second derivatives of the weight by n . ta, of a cylinder
                                on a plane */
} mbsri_touch;

/* Calls `touch` for every point with a depth and a weight above zero. */
typedef int (*mbsri_touch_fn)(void *user, const mbsri_touch *touch);
int mbsri_touches(const mbsri_placed *a, const mbsri_placed *b, mbsri_touch_fn touch, void *user);

/* Whether two kinds of shapes are served. */
bool mbsri_kinds_served(mbsr_shape_kind a, mbsr_shape_kind b);

/* How a point moves with small motions of both bodies: a rotation and a velocity each, at pa and
 * pb. */
typedef struct mbsri_motion {
    double wa[3], va[3], wb[3], vb[3];
} mbsri_motion;

typedef struct mbsri_moved {
    double n[3], p[3]; /* changes of normal and point, p the middle of both surfaces, */
    double depth, weight;
    double axis[3], cosine; /* of ta and n . ta, where the weight depends on it */
} mbsri_moved;

void mbsri_touch_moves(const mbsri_touch *t, const mbsri_motion *by, mbsri_moved *moved);

/* The middle of both surfaces. */
void mbsri_touch_point(const mbsri_touch *t, double p[3]);

#endif
