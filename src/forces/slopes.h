/* Derivatives of forces at points of one or two bodies (marker.h) with respect to the pose and V of
 * these bodies. Not for GENERAL space.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A vector x (along the world axes) that depends on pose and V has as derivative one vector for
 * each number of them: body after body the pose and then V, as in mbsr_force_derivatives. With the
 * small rotation phi and displacement rho of a body:
 *
 *   y turns with the body:              dy = phi x y
 *   arm from the origin to a point x:   d arm = dx - rho
 *   v = r' + omega x arm:               dv = dr' + domega x arm + omega x d arm */
#ifndef MBSRI_SLOPES_H
#define MBSRI_SLOPES_H

#include <mbsrank/force.h>

#include <stdbool.h>

enum { MBSRI_MAX_COLUMNS = 24 };

typedef struct mbsri_vector {
    double x[3];
} mbsri_vector;

typedef struct mbsri_columns {
    const mbsr_force_body *body;
    const mbsr_force_derivatives *out;
    int size[2];  /* numbers of V of each body, and as many of its pose; none of the ground */
    int first[2]; /* its first column */
    int count;    /* of all columns */
} mbsri_columns;

/* The columns of an element on one or two bodies. */
mbsri_columns mbsri_make_columns(const mbsr_force_args *args, const mbsr_force_derivatives *out);

/* Which of a body's numbers. */
typedef enum mbsri_state_part { MBSRI_POSE, MBSRI_RATE } mbsri_state_part;

/* dx += sign (phi x y), phi the rotation of body k (POSE) or its angular velocity (RATE). */
void mbsri_add_turn(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                    const double y[3], mbsri_vector *dx);

/* dx += sign phi */
void mbsri_add_spin(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                    mbsri_vector *dx);

/* dx += sign rho, the displacement of the origin of body k (POSE) or its velocity (RATE). */
void mbsri_add_shift(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                     mbsri_vector *dx);

/* dv += sign times the derivative of the velocity that body k has at the end of an arm. */
void mbsri_add_velocity(const mbsri_columns *c, int k, double sign, const double arm[3],
                        const mbsri_vector *darm, mbsri_vector *dv);

/* Displacement of the end of an arm fixed to body k for number r of its pose, which is its velocity
 * for number r of V. Returns whether the body turns. */
bool mbsri_point_motion(const mbsri_columns *c, int k, int r, const double arm[3], double dx[3]);

/* The derivative of mbsri_push: adds sign times that of (arm x force + moment, force) to the rows
 * of body k. darm NULL: the arm is fixed to the body; dmoment may be NULL. */
void mbsri_push_slopes(const mbsri_columns *c, int k, double sign, const double arm[3],
                       const double force[3], const mbsri_vector *darm, const mbsri_vector *dforce,
                       const mbsri_vector *dmoment);

#endif
