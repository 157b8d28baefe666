/* Rates of a completed state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_RATES_H
#define MBSRI_COMPLETION_RATES_H

#include "massless/completion_matrix.h"

/* q', p' and u' into w->rate, loop forces into w->yp, at w->y, whose residual is known.
 * exactly: forces along directions without mass balance there to the last digit, and are to. */
int mbsri_completion_rates(mbsr_completion *w, bool exactly);

/* The same by forward dynamics; MBSR_UNDETERMINED where there are directions that neither mass nor
 * a rigid row determines. */
int mbsri_completion_forward(mbsr_completion *w);

#endif
