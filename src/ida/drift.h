/* Energy and gaps in a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_DRIFT_H
#define MBSRI_IDA_DRIFT_H

#include "ida/record.h"

/* At the start, before its residual is evaluated, and at the end of a call that has advanced, once
 * a step; they leave ida->displaced and ida->work. */
void mbsri_ida_drift_start(mbsr_ida *ida, double t, const double *y);
void mbsri_ida_drift_note(mbsr_ida *ida);

#endif
