/* A consistent state of a model with closures in dense linear algebra.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_DENSE_START_H
#define MBSRI_LOOPS_DENSE_START_H

#include "loops/dense.h"

#include <mbsrank/dae.h>

/* q, u are brought to a state that the closures allow; u' and loop forces (rows; of stiff rows too)
 * are found. The rows that the data leaves out are chosen. */
int mbsri_loops_dense_start(mbsri_dense *w, double t, double *q, double *u, double *udot,
                            double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info);

#endif
