/* A point at which two shapes touch.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_POINT_H
#define MBSRI_CONTACT_POINT_H

#include "contact/record.h"

/* A shape where it stands in the world. */
typedef struct mbsri_placed {
    const mbsri_shape *shape;
    double R[9], x[3];
    double low[3], high[3];
} mbsri_placed;

/* What the two features are. */
typedef enum mbsri_features {
    MBSRI_POINT_PLANE, /* of a over a face of b */
    MBSRI_POINT_POINT,
    MBSRI_POINT_LINE,
    MBSRI_LINE_LINE,
    MBSRI_POINT_CIRCLE, /* of a at a rim of b */
    MBSRI_RIM_PLANE,    /* the lowest point of a rim of a over a plane b */
    MBSRI_ELLIPSOID_PLANE,
    MBSRI_ELLIPSOID_LINE,
    MBSRI_ELLIPSOID_POINT,
    MBSRI_ELLIPSOID_ELLIPSOID,
    MBSRI_POINT_SURFACE, /* of a over a height field b */
    MBSRI_ELLIPSOID_SURFACE
} mbsri_features;

/* One point. Where the features were found the other way round, a and b are exchanged
 * (`exchanged`), so that the names of the features fit. */
typedef struct mbsri_touch {
    mbsri_features features;
    bool exchanged;
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
    /* LINE_LINE: into the faces beside the edges, 0: none; where s < 0 how far one of the points is
     * out of the other core, b's point of a's where out_of_a, and the normal of the face there */
    double into_a[2][3], into_b[2][3];
    double height, out[3];
    bool out_of_a;
    double half[3], Ra[9];   /* half axes and axes of an ellipsoid; radius of a rim or circle in
                                half[0] */
    double half_b[3], Rb[9]; /* ELLIPSOID_ELLIPSOID: of b; SURFACE: Rb turns how pb moves into how
                                the normal does */
    double by_distance, by_place[3]; /* SURFACE: derivatives of the weight by s and pb */
    double by_cosine, curve; /* first and second derivatives of the weight by n . ta, of a cylinder
                                on a plane */
} mbsri_touch;

#endif
