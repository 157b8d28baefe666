/* Slopes of single force elements in the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ELEMENT_SLOPES_H
#define MBSRI_ELEMENT_SLOPES_H

#include "massless/null_space.h"

/* Finds which elements have derivatives of their own that can be used here, w->loads.own, and keeps
 * their forces at the state, f_held and tau_held, but for rounding, and what positions that are off
 * make of them, w->element.strain: the data is at mbsri_velocities. Reads w->size, q_scale and
 * span. */
int mbsri_hold_elements(mbsri_null_space *w);

/* Adds to C, S and their errors what these elements contribute at a state, in closed form. q_rate
 * is that of the directions. Leaves the data at mbsri_velocities of the state. */
int mbsri_element_slopes(mbsri_null_space *w, double t, const double *q, const double *u);

/* Rate at which springs with derivatives of their own move all mass of the model, sqrt(c / m),
 * without springs that at which dampers stop it, d / m, without mass that at which they give way to
 * springs, c / d; c and d with typical sizes as displacements and rates. 0: nothing of that. The
 * data is at mbsri_velocities of a state; reads w->size, q_scale and span; writes w->element.slope.
 */
int mbsri_element_rate(mbsri_null_space *w, double *rate);

#endif
