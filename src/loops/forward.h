/* Forward and inverse dynamics of models with closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_FORWARD_H
#define MBSRI_LOOPS_FORWARD_H

#include "recursion/data.h"

/* mbsr_forward_dynamics; the data is left at the forces, with loop forces and accelerations. */
int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, double *udot);

/* Torques tau (nu) of those joint rates that `actuated` (nu, in the order of the sweeps) has 1 for,
 * 0 for the others, and loop forces (rows) that together are `need` (nu); after the inverse
 * dynamics of the tree. */
int mbsri_loops_actuate(const mbsr_model *m, mbsr_data *d, const double *actuated,
                        const double *need, double *tau, double *lambda, const char *function);

#endif
