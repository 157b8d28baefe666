/* Positions of a consistent start: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_POSITIONS_H
#define MBSRI_START_POSITIONS_H

#include "massless/start_systems.h"

/* q at which springs that alone hold directions balance, masses staying where they are, and gaps
 * are closed. */
int mbsri_start_positions(mbsri_start *s);

#endif
