/* The sweeps over several states for x86-64 with AVX2 and FMA (x86-64-v3), four states at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#define MBSRI_LANES 4
#include "sweeps/vmovq.h"

#include "batch/kernels.h"

const mbsri_batch_kernels mbsri_batch_v3 = MBSRI_BATCH_KERNELS("x86-64-v3");
