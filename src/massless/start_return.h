/* What the search for a balance has moved but need not: see start_return.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_RETURN_H
#define MBSRI_START_RETURN_H

#include "massless/start_systems.h"

/* Takes w->y back to where masses were, by one step of Newton's method. */
int mbsri_start_return_masses(mbsri_start *s);

/* One step of many back along all but directions that springs alone hold, w->y being a state in
 * balance; `number` of the step, from zero on; *way: how far it is, of what coordinates span. */
int mbsri_start_return(mbsri_start *s, int number, double *way);

#endif
