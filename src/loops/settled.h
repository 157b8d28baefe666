/* Closing loops with stiff rows, of which not all need to meet.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_SETTLED_H
#define MBSRI_LOOPS_SETTLED_H

#include "loops/ranking.h"

#include <mbsrank/closure.h>

/* mbsri_assemble, in which stiff rows that depend on others at the guess do not count where there
 * are more of them than freedoms and they do not meet. */
int mbsri_assemble_settled(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                           mbsr_assembly_info *info);

#endif
