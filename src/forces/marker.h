/* Points fixed to bodies in the plane and in space: where they are, how they move, and forces on
 * them. POINT and PLANAR bodies move in the plane z = 0; of a force on them the part in the plane
 * counts. Not for GENERAL space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MARKER_H
#define MBSRI_MARKER_H

#include <mbsrank/force.h>

/* All along the world axes. */
typedef struct mbsri_marker {
    double arm[3]; /* from the body's origin */
    double x[3];   /* position */
    double v[3];   /* velocity; zero where the body's V is NULL */
} mbsri_marker;

/* The body's axes; those of a POINT or of the ground at rest are the world's. */
void mbsri_body_axes(const mbsr_force_body *body, double R[9]);

/* Its angular velocity; zero where V is NULL. */
void mbsri_body_spin(const mbsr_force_body *body, double omega[3]);

/* The point given in body axes. */
void mbsri_marker_on(const mbsr_force_body *body, const double in_body[3], mbsri_marker *marker);

/* The point of the body that is at x, in world axes, now. */
void mbsri_marker_at(const mbsr_force_body *body, const double x[3], mbsri_marker *marker);

/* Adds a force at the marker and a moment (NULL: none), times `sign`, to the body's f. */
void mbsri_push(const mbsr_force_body *body, const mbsri_marker *marker, double sign,
                const double force[3], const double moment[3]);

/* Three parameters from a point; NULL: the body's origin. */
void mbsri_store_point(const double point[3], double param[3]);

/* Refuses body k in GENERAL space, and the point `name` of a POINT that is not its origin. */
int mbsri_check_marker(const mbsr_force_args *args, int k, const double point[3], const char *name,
                       char text[MBSR_TEXT_SIZE]);

/* Refuses both ends on one body, GENERAL space, and points of a POINT that are not its origin;
 * point_a and point_b stand in the parameters from `first` on. */
int mbsri_check_markers(const mbsr_force_args *args, int first, char text[MBSR_TEXT_SIZE]);

/* Refuses body k of the element unless it is SPATIAL or, where `ground`, the ground in any space
 * but GENERAL. */
int mbsri_check_spatial(const mbsr_force_args *args, int k, int ground, char text[MBSR_TEXT_SIZE]);

#endif
