/* Directions that move no mass and that no loop holds.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_BALANCE_H
#define MBSRI_LOOPS_BALANCE_H

#include "loops/dense.h"

#include <mbsrank/dae.h>

/* From closed positions q: velocities that the closures allow, the balance of forces in these directions
 * (q and u are changed), u' and loop forces; K is that of mbsri_loops_leave_out. */
int mbsri_balance(mbsri_dense *w, double t, double *q, double *u, double *udot, double *lambda,
                  const mbsr_consistent_opt *opt, mbsr_consistent_info *info);

#endif
