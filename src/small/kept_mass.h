/* Candidates without whose mass nothing determines the motion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_KEPT_MASS_H
#define MBSRI_SMALL_KEPT_MASS_H

#include "small/record.h"

#include <mbsrank/index.h>

/* Candidates whose mass an undetermined direction of the reduced model moves, in the full one, keep
 * it; how many of them did not yet. The report is of the state given. */
int mbsri_small_keep_mass(mbsr_small_masses *s, double t, const mbsr_index_report *report,
                          int *count);

#endif
