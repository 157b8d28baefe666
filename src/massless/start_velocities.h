/* Velocities of a consistent start: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_VELOCITIES_H
#define MBSRI_START_VELOCITIES_H

#include "massless/start_systems.h"

/* The momenta of the velocities given, at the positions of w->y. */
int mbsri_start_momenta(mbsri_start *s);

/* u and impulses of loops at the positions of w->y; `drift`: also those of directions that springs
 * alone hold. */
int mbsri_start_velocities(mbsri_start *s, bool drift);

#endif
