/* The sweeps over several states for every processor, two states at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#define MBSRI_LANES 2
#include "batch/kernels.h"

const mbsri_batch_kernels mbsri_batch_base = MBSRI_BATCH_KERNELS("baseline");
