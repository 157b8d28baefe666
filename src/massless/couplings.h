/* Which directions that move no mass may act on which.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COUPLINGS_H
#define MBSRI_COUPLINGS_H

#include "massless/null_space.h"

/* Sets w->difference.affects and w->difference.colour from the directions, their twists and q_rate:
 * directions of one colour do not act on one and the same, so that one difference quotient serves
 * all of them. */
void mbsri_null_couple(mbsri_null_space *w);

#endif
