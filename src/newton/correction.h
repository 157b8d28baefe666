/* Force elements across the tree: a correction of low rank.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CORRECTION_H
#define MBSRI_CORRECTION_H

#include "newton/carried/record.h"

/* After the tree was factored; MBSR_SINGULAR_BLOCK names the first element. */
int mbsri_correction_factor(mbsr_newton *w, mbsr_data *d);

/* delta may be r. loaded: w->load has changes of joint forces; it is used up. */
void mbsri_correction_solve(mbsr_newton *w, const double *r, bool loaded, double *delta);

#endif
