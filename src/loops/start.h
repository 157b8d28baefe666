/* A consistent state of a model with closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_START_H
#define MBSRI_LOOPS_START_H

#include "loops/dense.h"

#include <mbsrank/dae.h>

/* q, u are brought to a state that the closures allow; u' and loop forces (rows; of stiff rows too) are
 * found. The rows that the data leaves out are chosen. */
int mbsri_loops_consistent(mbsri_dense *w, double t, double *q, double *u, double *udot,
                           double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info);

/* u' and loop forces at (q, u) as it is; tau (nu) or NULL. MBSR_UNDETERMINED by name. */
int mbsri_loops_accelerate(mbsri_dense *w, double t, const double *q, const double *u,
                           const double *tau, double *udot, double *lambda);

/* mbsr_forward_dynamics; the data is left at the forces, with loop forces and accelerations. */
int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, double *udot);

#endif
