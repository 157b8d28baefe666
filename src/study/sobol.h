/* Sobol' points, one coordinate at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SOBOL_H
#define MBSRI_SOBOL_H

#include <mbsrank/study.h>

enum { MBSRI_SOBOL_BITS = 32 };

/* Direction numbers of coordinate k, 0 .. MBSR_SOBOL_PARAMETERS - 1. */
void mbsri_sobol_directions(int k, uint32_t v[MBSRI_SOBOL_BITS]);

/* The coordinate of a point, times 2^32; points are in the order of Gray's code. */
uint32_t mbsri_sobol_point(const uint32_t v[MBSRI_SOBOL_BITS], uint32_t index);

#endif
