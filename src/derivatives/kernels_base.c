/* The sweeps of rigid_record.h for every processor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/rigid_sweeps.h"

const mbsri_rigid_kernels mbsri_rigid_base = MBSRI_RIGID_KERNELS;
