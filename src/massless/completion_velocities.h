/* Velocities of a completed state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_VELOCITIES_H
#define MBSRI_COMPLETION_VELOCITIES_H

#include "massless/completion_matrix.h"

/* u and loop forces at the positions and momenta of w->y, whose residual is known; where loops are
 * closed, positions and momenta too. The residual is that of the state found. */
int mbsri_completion_velocities(mbsr_completion *w);

/* s' = k (C u + g_t) of stiff rows into w->yp, with the residual there. */
int mbsri_completion_spring_rates(mbsr_completion *w);

#endif
