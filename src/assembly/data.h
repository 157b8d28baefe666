/* For tests of the data block.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ASSEMBLY_DATA_H
#define MBSRI_ASSEMBLY_DATA_H

#include "recursion/data.h"

/* Fills every working array with NaN and forgets all stages, so that a test sees what reads before
 * writing. */
void mbsri_data_poison(mbsr_data *d);

#endif
