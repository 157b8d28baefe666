/* What a unit impulse on each joint rate changes it by, loops closed.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_MOBILITY_H
#define MBSRI_LOOPS_MOBILITY_H

#include "recursion/data.h"

/* diag(Z (Z^T M Z)^-1 Z^T), Z spanning the rates that the rows allow which are neither loose nor
 * dropped, into mobility (nu, by the caller's order); -1 for rates that a motion without mass has a
 * part in. At the positions of the data, in O(bodies + loops). */
int mbsri_loops_mobility(const mbsr_model *m, mbsr_data *d, double *mobility, const char *function);

#endif
