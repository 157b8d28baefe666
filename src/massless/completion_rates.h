/* Rates of a completed state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_RATES_H
#define MBSRI_COMPLETION_RATES_H

#include "massless/completion_matrix.h"

/* q', p' and u' into w->rate, loop forces into w->yp, at w->y, whose residual is known. */
int mbsri_completion_rates(mbsr_completion *w);

#endif
