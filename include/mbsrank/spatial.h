/* Frames and rotations in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_SPATIAL_H
#define MBSRANK_SPATIAL_H

#include <mbsrank/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A frame that is NULL is the one it stands in: no shift, no turn. An axis or quaternion that is
 * NULL is one of length zero, which makes a frame without axes; such a frame is refused where it is
 * used.
 *
 * Conventions: 3 x 3 matrices are column-major. The columns of a rotation R are a frame's axes, in
 * components along the axes that it stands in: x_outer = R x_frame. Quaternions are (w, x, y, z).
 * Six-vectors (twists, wrenches) have the angular part first, as Featherstone's have. */

/* A frame standing in another: origin and axes. Made by a constructor below or field by field; a
 * frame of zeros is none, since its axes are no axes. */
typedef struct mbsr_frame {
    double x[3]; /* origin, m */
    double R[9]; /* axes */
} mbsr_frame;

/* Kinds of shapes, as files draw them (files.h) and as bodies touch (contact.h), with their sizes
 * (m). */
typedef enum mbsr_shape_kind {
    MBSR_SHAPE_BOX,       /* size: half edges */
    MBSR_SHAPE_SPHERE,    /* size[0]: radius */
    MBSR_SHAPE_CYLINDER,  /* radius, half length along z */
    MBSR_SHAPE_CAPSULE,   /* radius, half length between the centres of its caps, along z */
    MBSR_SHAPE_ELLIPSOID, /* half axes */
    MBSR_SHAPE_PLANE,     /* z = 0, all below is solid; drawn with half edges, 0: endless */
    MBSR_SHAPE_MESH,      /* by its triangles; size: scale, in drawings alone */
    MBSR_SHAPE_HEIGHTS    /* half edges along x and y of a grid of heights, all below is solid */
} mbsr_shape_kind;

/* The frame in which it stands: no displacement, no rotation. */
MBSR_API mbsr_frame mbsr_frame_identity(void);

/* Shifted, axes parallel. */
MBSR_API mbsr_frame mbsr_frame_at(double x, double y, double z);

/* Origin x (NULL: zero), turned by an angle in rad about an axis of any length but zero. */
MBSR_API mbsr_frame mbsr_frame_rotated(const double x[3], const double axis[3], double angle);

/* Origin x (NULL: zero), axes by a quaternion of any length but zero. */
MBSR_API mbsr_frame mbsr_frame_quaternion(const double x[3], const double quaternion[4]);

/* Origin x (NULL: zero), z axis along `z`, which has any length but zero. The directions of the x
 * and y axes are the library's choice. */
MBSR_API mbsr_frame mbsr_frame_along(const double x[3], const double z[3]);

/* Frame b, given in a, expressed in the frame that a stands in: R = R_a R_b, x = x_a + R_a x_b. */
MBSR_API mbsr_frame mbsr_frame_product(const mbsr_frame *a, const mbsr_frame *b);

/* The frame that a stands in, expressed in a: R = R_a^T, x = -R_a^T x_a. */
MBSR_API mbsr_frame mbsr_frame_inverse(const mbsr_frame *a);

/* Between quaternions and rotations. The quaternion of a rotation has length 1 and w >= 0. Status:
 * MBSR_OK; MBSR_ERR_NULL (output, or R), with nothing written; MBSR_ZERO_QUATERNION (NULL too), R
 * is zero; MBSR_NOT_FINITE, with the output not finite. */
MBSR_API int mbsr_quaternion_rotation(const double quaternion[4], double R[9]);
MBSR_API int mbsr_rotation_quaternion(const double R[9], double quaternion[4]);

#ifdef __cplusplus
}
#endif

#endif
