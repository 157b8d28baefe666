/* Closed loops in a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_LOOPS_H
#define MBSRI_IDA_LOOPS_H

#include "ida/record.h"

/* After IDA has given up: MBSR_LOOP_SINGULAR, with the name of the loop, where rows of closures are
 * dependent, or nearly, in the last good state; else MBSR_OK. */
int mbsri_ida_blame_loops(mbsr_ida *ida);

/* MBSR_LOOP_OPEN where rows that were left out as redundant at the start have opened. */
int mbsri_ida_check_dropped(mbsr_ida *ida);

#endif
