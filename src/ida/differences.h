/* A dense matrix whose columns of coordinates are right where something is stiff.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_DIFFERENCES_H
#define MBSRI_IDA_DIFFERENCES_H

#include "ida/record.h"

/* Makes IDA use such a matrix, or its own by difference quotients of one side. */
void mbsri_ida_use_central(void *user, bool central);

/* x becomes dF/dy' x at the present state of IDA: for forms in which velocities have rates that the
 * mass matrix mixes. `user` is the driver. */
int mbsri_ida_weigh(void *user, N_Vector x);

#endif
