/* Pieces of the momentum form that the reduced ODE uses too.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DAE_MOMENTUM_H
#define MBSRI_DAE_MOMENTUM_H

#include "recursion/data.h"

/* Impulses m and momenta p (by the caller's order) at the state of mbsr_stage_velocities. */
void mbsri_momenta(const mbsr_model *m, mbsr_data *d, double *p);

/* ep from p, after the backward recursion of the masses. */
void mbsri_condense(const mbsr_model *m, mbsr_data *d, const double *p);

/* q' and p' at the state of mbsr_stage_velocities, with loop forces lambda as mbsri_forces takes
 * them; forces are evaluated on the way. */
int mbsri_momentum_derivatives(const mbsr_model *m, mbsr_data *d, const double *lambda,
                               double *qdot, double *pdot);

#endif
