/* Directions that move no mass in models with closures: what loops exert along them, and which they
 * hold.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of the combinations of joint rates that move no mass, rigid rows of closures, C x = 0, leave
 * fewer. Loop forces act along the others and hold them; along those that are left they do no work,
 * but C^T lambda turns with the bodies: its slope with lambda held, lambda times the curvature of
 * the closures, stiffens or softens as the slopes of applied forces do. Stiff rows are springs and
 * dampers, -k C^T C and -d C^T C, that bear lambda. */
#ifndef MBSRI_NULL_LOOPS_H
#define MBSRI_NULL_LOOPS_H

#include "massless/null_space.h"

/* w->loads.lambda of the motion at a state, from the equations of motion (loops/refuse.h):
 * redundant rows share by least norm, stiff ones by least energy. *independent: rank of the rigid
 * rows. Statuses of mbsr_forward_dynamics. The data is at mbsri_velocities of the state. */
int mbsri_null_loop_forces(mbsri_null_space *w, double t, const double *q, const double *u,
                           int *independent);

/* The directions become those that rigid rows leave: w->k, direction, twist, q_rate, C and S with
 * their errors; gamma follows no longer. The data is at mbsri_velocities of the state. */
int mbsri_null_leave_held(mbsri_null_space *w);

/* Adds to sizes (k) what loop forces, each for itself, have along the directions; after the
 * derivatives of closures. */
void mbsri_null_loop_sizes(const mbsri_null_space *w, double *sizes);

/* Adds to C and S what stiff rows contribute, and a row each to w->element.rows (element_rows.h),
 * whose element is -1 - closure. */
int mbsri_null_stiff_rows(mbsri_null_space *w);

/* Whether the closure has a stiff row with damping (velocity), or a stiff row, that sees the
 * direction. */
bool mbsri_null_closure_resists(mbsri_null_space *w, const mbsri_closure *c, const double *twist,
                                const double *a, bool velocity);

#endif
