/* Options of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_OPTIONS_H
#define MBSRI_IDA_OPTIONS_H

#include "ida/record.h"

/* Refuses options that make no sense. `size`: length of y. */
int mbsri_ida_check(const mbsr_ida_opt *opt, int size, mbsr_error *error);

#endif
