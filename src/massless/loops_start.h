/* A consistent start of a model with closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_CONSISTENT_H
#define MBSRI_LOOPS_CONSISTENT_H

#include "recursion/data.h"

#include <mbsrank/dae.h>

/* mbsr_dae_consistent of a model with closures that keeps no rates; its arguments have been
 * checked, ranks are not watched. Of info, writes all but what has changed. */
int mbsri_loops_start(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, double t, double *y,
                      double *yp, const mbsr_consistent_opt *opt, mbsr_consistent_info *info);

#endif
