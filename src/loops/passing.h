/* What is unknown of loops, past a joint.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_PASSING_H
#define MBSRI_LOOPS_PASSING_H

#include "loops/waiting.h"

/* What is open at body i past its joint, whose D is decomposed, to its predecessor. MBSR_ERR_NO_MEMORY. */
int mbsri_system_pass(mbsri_system *w, int i);

#endif
