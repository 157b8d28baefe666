/* Making the object for batches of states.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BATCH_BUILD_H
#define MBSRI_BATCH_BUILD_H

#include "batch/record.h"

/* mbsr_batch_create with kernels of choice. */
int mbsri_batch_make(const mbsr_model *model, const mbsri_batch_kernels *kernels,
                     mbsr_batch **batch, mbsr_error *error);

#endif
