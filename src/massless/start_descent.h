/* Positions of a consistent start where Newton's method leads nowhere: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_DESCENT_H
#define MBSRI_START_DESCENT_H

#include "massless/start_systems.h"

/* From w->y down the slope of springs that alone hold something, masses staying where they are, to
 * where Newton's method of start_positions.h has little left to do. */
int mbsri_start_descend(mbsri_start *s);

#endif
