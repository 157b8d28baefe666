/* What the stock closures share: bodies in the plane and in space seen alike, and rows on them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURES_STOCK_H
#define MBSRI_CLOSURES_STOCK_H

#include "forces/stock.h"

#include <mbsrank/closure.h>

#include <stdbool.h>

/* A body as a rigid body in space: rotation, origin, angular velocity, velocity of the origin; a
 * root at rest is at rest in the origin. The velocities are zero where V is not given. */
typedef struct mbsri_end {
    double R[9], r[3], w[3], v[3];
} mbsri_end;

mbsri_end mbsri_end_of(const mbsr_force_body *body);

/* Adds to row `row` the derivatives of a . w + l . v of body k. */
void mbsri_end_add(const mbsr_closure_args *args, int k, const double a[3], const double l[3],
                   int row, const mbsr_closure_jacobian *out);

/* Displacement along column r of body k: a small turn about its origin, and a shift. False: it has
 * no such column. */
bool mbsri_end_shift(const mbsr_closure_args *args, int k, int r, double turn[3], double shift[3]);

/* Adds to column `at` of the derivatives of loop forces a moment about body k's origin and a force.
 */
void mbsri_end_load(const mbsr_closure_args *args, int k, const double moment[3],
                    const double force[3], int at, const mbsr_closure_tangent *out);

/* Velocity of a point that the body carries with it, `arm` from its origin. */
void mbsri_end_velocity(const mbsri_end *end, const double arm[3], double v[3]);

/* The part of its acceleration that comes of the angular velocity: w x (w x arm). */
void mbsri_end_centripetal(const mbsri_end *end, const double arm[3], double a[3]);

/* A point of the first body, at param[0], in the world: for tables whose rows act there. */
int mbsri_point_of_first(const mbsr_closure_args *args, double x[3]);

/* Whether both of the first two bodies lie in the plane (a root at rest lies in both). */
bool mbsri_flat(const mbsr_closure_args *args);

/* For tables: one position row; as many as option[0] says; rows whose derivatives do not move;
 * drifts and biases that are zero. */
int mbsri_one_row(const mbsr_closure_args *args, int *rows, int *position_rows);
int mbsri_chosen_rows(const mbsr_closure_args *args, int *rows, int *position_rows);
int mbsri_constant_rows(const mbsr_closure_args *args, const double *lambda,
                        const mbsr_closure_tangent *out);
int mbsri_no_numbers(const mbsr_closure_args *args, double *out);

/* A definition with cookie, table and two bodies. */
mbsr_closure_def mbsri_stock_closure(const mbsr_closure_table *table, int a, int b);

/* Refuses bodies in GENERAL space, and twice the same. */
int mbsri_check_pair(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE]);

/* Refuses a frame at param[first] whose axes are none. */
int mbsri_check_frame(const mbsr_closure_def *def, int first, const char *which,
                      char text[MBSR_TEXT_SIZE]);

/* s, s' and s'' of the definition's motion (n numbers each), zero without one. */
int mbsri_closure_motion(const mbsr_closure_args *args, double s[MBSR_CLOSURE_ROWS],
                         double sdot[MBSR_CLOSURE_ROWS], double sddot[MBSR_CLOSURE_ROWS]);

#endif
