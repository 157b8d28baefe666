/* What IDA has counted.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_COUNT_H
#define MBSRI_IDA_COUNT_H

#include "ida/record.h"

/* Adds what IDA has counted so far to *stats. */
void mbsri_ida_count(const mbsr_ida *ida, mbsr_ida_stats *stats);

#endif
