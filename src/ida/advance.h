/* Integration up to a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_ADVANCE_H
#define MBSRI_IDA_ADVANCE_H

#include "ida/record.h"

/* mbsr_ida_advance to a finite time after a start; the state stays in the driver. */
int mbsri_ida_advance(mbsr_ida *ida, double t_end);

void mbsri_ida_put(mbsr_ida *ida, double *t, double *y, double *yp);

#endif
