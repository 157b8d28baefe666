/* The driver's watch of ranks, in force only while it integrates.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * `watch` and `watched` of the driver hold its own watch, which is taken at the start, while the
 * caller's is in force, and the caller's while the driver integrates. */
#ifndef MBSRI_IDA_WATCH_H
#define MBSRI_IDA_WATCH_H

#include "ida/record.h"

#include <mbsrank/driver.h>

static inline void mbsri_ida_exchange_watch(mbsr_ida *ida)
{
    mbsr_rank_watch_exchange(ida->model, ida->data, &ida->watch, ida->watched);
}

/* Keeps y and yp, from which IDA starts, for a failure of its first step. */
static inline void mbsri_ida_keep_start(mbsr_ida *ida)
{
    N_VScale(1.0, ida->y, ida->run.first_y);
    N_VScale(1.0, ida->yp, ida->run.first_yp);
}

#endif
