/* The sweeps of rigid_record.h for x86-64 with AVX2 and FMA (x86-64-v3).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/vmovq.h"

#include "derivatives/rigid_sweeps.h"

const mbsri_rigid_kernels mbsri_rigid_v3 = MBSRI_RIGID_KERNELS;
