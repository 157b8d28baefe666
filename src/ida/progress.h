/* The word between two steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_PROGRESS_H
#define MBSRI_IDA_PROGRESS_H

#include "ida/record.h"

/* Calls the progress function if it is due; its status. */
int mbsri_ida_report(mbsr_ida *ida);
void mbsri_ida_report_anew(mbsr_ida *ida);

/* MBSR_ERR_SOLVER where the last steps are all shorter than what rounding leaves of the time, so
 * that the run would never end; y: the state. */
int mbsri_ida_watch_steps(mbsr_ida *ida, N_Vector y);

#endif
