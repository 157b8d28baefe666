/* The word between two steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_PROGRESS_H
#define MBSRI_IDA_PROGRESS_H

#include "ida/record.h"

/* Calls the progress function if it is due; its status. */
int mbsri_ida_report(mbsr_ida *ida);
void mbsri_ida_report_anew(mbsr_ida *ida);

#endif
