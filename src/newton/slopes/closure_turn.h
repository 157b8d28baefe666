/* Closures whose forces turn with one of their two bodies, as those of stiff pins along its axes
 * do.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * S = d(C^T lambda) ties the bodies a and b of such a closure, but by nothing that its rows do not
 * know:
 *
 *   S_ab = C_a^T L     forces on a change with the motion of b as they would with other lambda
 *   S_ba = Y C_a       those on b change with the motion of a as the gaps of the rows do
 *
 * With phi = dlambda + L x_b for dlambda, forces on a depend on phi and on a alone; and as the
 * position rows say C_a x_a + C_b x_b + K dlambda = r, with K the compliances of the rows, forces
 * on b change by
 *
 *   C_b^T (phi - L x_b) + S_bb x_b + Y (r - C_b x_b - K (phi - L x_b))
 *
 * where only r has come from elsewhere. So no unknowns are needed beside the multipliers. */
#ifndef MBSRI_CLOSURE_TURN_H
#define MBSRI_CLOSURE_TURN_H

#include "model/record.h"

/* Of a closure with rows x columns; L and Y^T have numbers in the columns of the second body alone.
 */
typedef struct mbsri_closure_turn {
    double *L, *Y;
    double *acts, *holds; /* C in the forces by phi, and in the position rows: C - K Y^T, C - K L */
    double *load, *shift; /* of a solution: Y r on the second body (columns), and L x_b (rows) */
} mbsri_closure_turn;

/* Doubles of these, and where they stand. */
size_t mbsri_closure_turn_size(const mbsri_closure *c);
mbsri_closure_turn mbsri_closure_turn_at(const mbsri_closure *c, double *memory);

/* Whether the model allows it: two bodies that move, and position rows alone. */
bool mbsri_closure_may_turn(const mbsri_closure *c);

/* L and Y of the derivatives C and S; false: S is not of this kind, to 1e-10 of its largest entry.
 */
bool mbsri_closure_turns(const mbsri_closure *c, const double *C, const double *S,
                         const mbsri_closure_turn *out);

/* With L and Y: acts, holds; what phi for dlambda leaves of S_bb and of the slopes of the velocity
 * rows, which c dlambda times the compliances is added to. */
void mbsri_closure_turn_over(const mbsri_closure *c, double factor, const double *C,
                             const mbsri_closure_turn *out, double *S, double *slope);

#endif
