/* A dense matrix by central differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_DIFFERENCES_H
#define MBSRI_IDA_DIFFERENCES_H

#include "ida/record.h"

/* Makes IDA use such a matrix, or its own by difference quotients of one side. */
void mbsri_ida_use_central(void *user, bool central);

#endif
