/* The first step, and when two times are the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_FIRST_STEP_H
#define MBSRI_IDA_FIRST_STEP_H

#include "ida/record.h"

/* First step when none is given, s, 0 < h <= longest, from y, y' of the driver at the present
 * time. */
double mbsri_ida_first_step(mbsr_ida *ida, double direction, double longest);

/* The longest where there is no reason for another: a thousandth of the time that tolerances know.
 */
double mbsri_ida_longest_first_step(const mbsr_ida *ida);

/* Whether two times differ by no more than rounding, as IDA sees it. */
bool mbsri_ida_same_time(double a, double b);

#endif
