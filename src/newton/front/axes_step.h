/* The step of a body in space whose joint is a sequence of axes, where nothing is carried.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_AXES_STEP_H
#define MBSRI_FRONT_AXES_STEP_H

#include "newton/front/front.h"

/* Whether step k is one by its model: at most one body in its border, elements on its body alone.
 */
bool mbsri_front_may_step(const mbsri_front *f, int k);

/* Passes the body of step k as factor.c does, if all that is known of it is y over x, and its
 * pivots are good; *done says whether. A status of what elements return. */
int mbsri_front_step_axes(mbsri_front *f, mbsr_data *d, int k, bool *done);

#endif
