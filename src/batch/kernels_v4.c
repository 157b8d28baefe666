/* The sweeps over several states for x86-64 with AVX-512 (x86-64-v4), eight states at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#define MBSRI_LANES 8
#include "batch/kernels.h"

const mbsri_batch_kernels mbsri_batch_v4 = MBSRI_BATCH_KERNELS("x86-64-v4");
